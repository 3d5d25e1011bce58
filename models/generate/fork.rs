//! Forks: places where chance decides between two outcomes, both better than all outcomes outside,
//! as B and C in the paper's example.
//!
//! ```text
//!   ###
//!   #X#     The robot enters from the east, onto ice that slides north and south. The one-way cells
//!   #^#     behind it do not let it back. So neither X nor Y is certain out there, yet to enter is
//!   #~.@    certain to improve. An arm may lead to a further fork, with a further improvement.
//!   #v#
//!   #Y#
//!   ###
//! ```

use super::world::{Cell, Direction, Place, World};
use meliora_base::random::Draw;

/// The maximum number of forks in a sequence.
pub(super) const DEEPEST: usize = 3;

/// Returns the number of rows that a tree of forks extends to either side of its middle.
fn reach(depth: usize) -> usize {
    // 2, 5, 11: an arm, and half of the fork at its end.
    3 * (1 << depth.saturating_sub(1)) - 1
}

/// Returns the rows and columns of a tree of forks, including its border and the column before it.
pub(super) fn size(depth: usize) -> (usize, usize) {
    match depth {
        0 => (0, 0),
        _ => (2 * reach(depth) + 3, 2 * depth + 2),
    }
}

/// Builds a tree of forks at a random place in an empty world. Its items are the last ones, two per
/// depth. Returns the cell before its entrance, and marks the cells that are no longer free.
pub(super) fn build(world: &mut World, depth: usize, draw: &mut Draw) -> Option<(Place, Vec<bool>)> {
    if depth == 0 {
        return None;
    }
    let (rows, cols) = size(depth);
    let (south, west) = (draw.below(world.rows + 1 - rows), draw.below(world.cols + 1 - cols));
    let block = move |place: Place| {
        (south..south + rows).contains(&place.row) && (west..west + cols).contains(&place.col)
    };
    let taken: Vec<bool> = world.places().map(block).collect();
    let before = west + cols - 1;
    for place in world.places().filter(|&place| block(place) && place.col != before) {
        *world.cell_mut(place) = Cell { wall: true, ..Cell::default() };
    }
    let middle = Place { row: south + reach(depth) + 1, col: before - 2 };
    *world.cell_mut(Place { col: before - 1, ..middle }) = Cell::default();
    fork(world, middle, depth, world.items.len() - 2 * depth);
    Some((Place { col: before, ..middle }, taken))
}

/// Builds one fork with its slippery cell at `ice`, and the forks behind it; items are numbered
/// from `first`.
fn fork(world: &mut World, ice: Place, depth: usize, first: usize) {
    let slip = [Direction::North, Direction::South].into_iter().collect();
    *world.cell_mut(ice) = Cell { slip, ..Cell::default() };
    let length = if depth == 1 { 2 } else { reach(depth - 1) + 1 };
    for (number, direction) in [Direction::North, Direction::South].into_iter().enumerate() {
        let along = |steps: usize| match direction {
            Direction::North => Place { row: ice.row + steps, ..ice },
            _ => Place { row: ice.row - steps, ..ice },
        };
        *world.cell_mut(along(1)) = Cell { one_way: Some(direction), ..Cell::default() };
        (2..length).for_each(|steps| *world.cell_mut(along(steps)) = Cell::default());
        let end = along(length);
        *world.cell_mut(end) = Cell { item: Some(first + number), ..Cell::default() };
        if depth > 1 {
            *world.cell_mut(Place { col: end.col - 1, ..end }) = Cell::default();
            fork(world, Place { col: end.col - 2, ..end }, depth - 1, first + 2);
        }
    }
}
