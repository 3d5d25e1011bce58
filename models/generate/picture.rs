//! The map as a comment at the head of the model, for small grids.

use super::world::{Direction, Place, World};

/// The maximum number of rows and columns of a grid with a picture.
const LARGEST: usize = 48;

/// Returns comment lines with the map, north on top, and a legend; empty for large grids.
pub(super) fn comment(world: &World) -> String {
    if world.rows > LARGEST || world.cols > LARGEST {
        return String::new();
    }
    let mut text = "//\n".to_owned();
    for row in (0..world.rows).rev() {
        let line: String = (0..world.cols).map(|col| sign(world, Place { row, col })).collect();
        text += &format!("//   {line}\n");
    }
    let opponents = if world.opponents.is_empty() { "" } else { "& start of an opponent, " };
    text + &format!(
        "//\n// North (row + 1) is up. A-Z items, * charger, @ start, # wall, ~ slippery, ^ v > < one-way,\n\
         // : moving obstacle, {opponents}+ some action is disabled. Further signs may hide below these.\n"
    )
}

fn sign(world: &World, place: Place) -> char {
    let cell = world.cell(place);
    let item = cell.item.map(|i| world.items[i].name);
    let rules = [
        (cell.wall, '#'),
        (item.is_some(), item.unwrap_or('?')),
        (world.starts.contains(&place), '@'),
        (world.opponents.contains(&place), '&'),
        (cell.charger, '*'),
        (world.patrols.iter().any(|patrol| patrol.covers(place)), ':'),
        (!cell.slip.is_empty(), '~'),
        (cell.one_way == Some(Direction::North), '^'),
        (cell.one_way == Some(Direction::South), 'v'),
        (cell.one_way == Some(Direction::East), '>'),
        (cell.one_way == Some(Direction::West), '<'),
        (!cell.disabled.is_empty(), '+'),
    ];
    rules.into_iter().find(|(holds, _)| *holds).map_or('.', |(_, sign)| sign)
}
