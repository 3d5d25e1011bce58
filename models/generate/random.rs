//! Random worlds from a few parameters.

use super::Parameters;
use super::fork;
use super::world::{Cell, Direction, Directions, Lock, Patrol, Place, World};
use meliora_base::error::{Error, Result};
use meliora_base::random::Draw;

/// Draws the world of the parameters. The order of the draws must not change: the same parameters
/// and seed give the same world in every version.
pub(super) fn world(parameters: &Parameters, draw: &mut Draw) -> Result<World> {
    parameters.validate()?;
    let mut sketch = Sketch::new(parameters);
    let fork = fork::build(&mut sketch.world, parameters.forks, draw);
    if let Some((_, taken)) = &fork {
        sketch.taken.clone_from(taken);
    }
    let empty = sketch.world.clone();
    sketch.walls(parameters.walls, draw);
    // Random walls may cut off the fork; then the walls are drawn again.
    for _ in 0..TRIES {
        match &fork {
            Some((before, _)) if !sketch.largest_room().contains(before) => {
                sketch.world = empty.clone();
                sketch.walls(parameters.walls, draw);
            }
            _ => break,
        }
    }
    let mut free = sketch.largest_room();
    free.retain(|&place| !sketch.taken[sketch.world.index(place)]);
    draw.shuffle(&mut free);
    let scattered = parameters.items - 2 * parameters.forks;
    let wanted = scattered + parameters.robots + parameters.chargers + parameters.opponents;
    if free.len() < wanted {
        return Err(Error::Usage(format!(
            "the largest room of this {} x {} grid has {} cells: too few for {wanted} items, chargers and robots; \
             use a larger grid, fewer of them, or fewer walls (--walls)",
            parameters.rows,
            parameters.cols,
            free.len(),
        )));
    }
    let world = &mut sketch.world;
    world.starts = free.drain(..parameters.robots).collect();
    for (number, place) in free.drain(..scattered).enumerate().collect::<Vec<_>>() {
        world.cell_mut(place).item = Some(number);
    }
    for place in free.drain(..parameters.chargers).collect::<Vec<_>>() {
        world.cell_mut(place).charger = true;
    }
    world.opponents = free.drain(..parameters.opponents).collect();
    let in_fork = |place: &Place| sketch.taken[world.index(*place)];
    for place in world.places().filter(in_fork).collect::<Vec<_>>() {
        world.cell_mut(place).refuge = true;
    }
    sketch.locks(parameters, draw);
    sketch.patrols(parameters.patrols, &mut free, draw)?;
    sketch.features(parameters, &mut free, draw)?;
    Ok(sketch.world)
}

/// The maximum number of attempts to draw walls that do not cut off the fork.
const TRIES: usize = 20;

/// A world under construction.
struct Sketch {
    world: World,
    /// The cells of a fork, which stay reserved.
    taken: Vec<bool>,
}

impl Sketch {
    fn new(parameters: &Parameters) -> Self {
        let names = ('A'..='Z').take(parameters.items);
        let world = World::new(parameters.rows, parameters.cols, names);
        let taken = vec![false; world.cells.len()];
        Sketch { world: World { battery: parameters.battery, ..world }, taken }
    }

    /// Draws walls as straight bars, longer on larger grids, until they take the given share of the
    /// cells.
    fn walls(&mut self, percent: usize, draw: &mut Draw) {
        let (rows, cols) = (self.world.rows, self.world.cols);
        let mut missing = rows * cols * percent / 100;
        let longest = (rows.min(cols) / 8).max(2);
        // Bars overlap; even for 90 % of walls, 100 bars per cell suffice.
        for _ in 0..100 * rows * cols {
            if missing == 0 {
                break;
            }
            let start = Place { row: draw.below(rows), col: draw.below(cols) };
            let upright = draw.below(2) == 0;
            for step in 0..=draw.below(longest) {
                let place = match upright {
                    true => Place { row: start.row + step, ..start },
                    false => Place { col: start.col + step, ..start },
                };
                if missing > 0 && place.row < rows && place.col < cols {
                    let at = self.world.index(place);
                    let fresh = !self.taken[at] && !std::mem::replace(&mut self.world.cells[at].wall, true);
                    missing -= usize::from(fresh);
                }
            }
        }
    }

    /// Returns the largest connected set of cells without a wall, sorted by rows.
    fn largest_room(&self) -> Vec<Place> {
        let world = &self.world;
        let mut room = vec![None; world.cells.len()];
        let mut best: Vec<Place> = Vec::new();
        for corner in world.places() {
            if world.cell(corner).wall || room[world.index(corner)].is_some() {
                continue;
            }
            let mut found = vec![corner];
            room[world.index(corner)] = Some(corner);
            let mut next = 0;
            while let Some(&place) = found.get(next) {
                next += 1;
                for to in Direction::ALL.into_iter().filter_map(|d| world.step(place, d)) {
                    if room[world.index(to)].replace(corner).is_none() {
                        found.push(to);
                    }
                }
            }
            if found.len() > best.len() {
                best = found;
            }
        }
        best.sort_unstable();
        best
    }

    /// Locks the last items outside of the fork. Each is opened by one or two earlier items, mostly
    /// by items that are always available. A locked charger is opened by one or two items, too.
    fn locks(&mut self, parameters: &Parameters, draw: &mut Draw) {
        let scattered = parameters.items - 2 * parameters.forks;
        let open = scattered - parameters.locked;
        let mut opened_by = |lock: Lock, before: usize, draw: &mut Draw| {
            for _ in 0..1 + draw.below(2) {
                let any = if draw.below(4) == 0 { before } else { open };
                let opens = &mut self.world.items[draw.below(any)].opens;
                opens.push(lock);
                opens.sort_unstable();
                opens.dedup();
            }
        };
        (open..scattered).for_each(|item| opened_by(Lock::Item(item), item, draw));
        if parameters.locked_charger && parameters.chargers > 0 {
            opened_by(Lock::Charger, open, draw);
        }
    }

    /// Draws straight tracks of two to five free cells.
    fn patrols(&mut self, count: usize, free: &mut Vec<Place>, draw: &mut Draw) -> Result<()> {
        let mut candidates = free.clone();
        candidates.sort_unstable();
        while self.world.patrols.len() < count {
            let Some(from) = draw.take(&mut candidates) else {
                let message = format!("no room for {count} moving obstacles; use a larger grid or fewer");
                return Err(Error::Usage(message));
            };
            let along = if draw.below(2) == 0 { Direction::North } else { Direction::East };
            let mut track = vec![from];
            let longest = 2 + draw.below(4);
            while let Some(&end) = track.last().filter(|_| track.len() < longest) {
                match self.world.step(end, along).filter(|next| free.contains(next)) {
                    Some(next) => track.push(next),
                    None => break,
                }
            }
            if let [from, .., to] = track[..] {
                self.world.patrols.push(Patrol { from, to });
                free.retain(|place| !track.contains(place));
                candidates.retain(|place| !track.contains(place));
            }
        }
        Ok(())
    }

    /// Draws slippery cells in patches, then one-way cells and cells with disabled actions.
    fn features(&mut self, parameters: &Parameters, free: &mut Vec<Place>, draw: &mut Draw) -> Result<()> {
        let wanted = self.world.cells.len() * parameters.slippery / 100;
        let kinds = &parameters.drifts;
        let patch = (parameters.rows.min(parameters.cols) / 32).max(1);
        let mut is_free = vec![false; self.world.cells.len()];
        free.iter().for_each(|&place| is_free[self.world.index(place)] = true);
        let mut wet = 0;
        for &corner in free.iter() {
            if wet >= wanted || kinds.is_empty() {
                break;
            }
            let slip = kinds[draw.below(kinds.len())];
            let (height, width) = (1 + draw.below(patch), 1 + draw.below(patch));
            for place in
                block(corner, height, width).filter(|p| p.row < self.world.rows && p.col < self.world.cols)
            {
                let at = self.world.index(place);
                if wet < wanted && std::mem::take(&mut is_free[at]) {
                    self.world.cells[at].slip = slip;
                    wet += 1;
                }
            }
        }
        free.retain(|&place| is_free[self.world.index(place)]);
        self.scatter(parameters.one_way, "one-way cells", free, draw, |cell, draw| {
            cell.one_way = Some(Direction::ALL[draw.below(4)]);
        })?;
        self.scatter(parameters.disabled, "cells with disabled actions", free, draw, |cell, draw| {
            let pair = draw.below(2) * 2;
            cell.disabled = Directions::from_iter([Direction::ALL[pair], Direction::ALL[pair + 1]]);
        })
    }

    fn scatter(
        &mut self,
        count: usize,
        what: &str,
        free: &mut Vec<Place>,
        draw: &mut Draw,
        set: impl Fn(&mut Cell, &mut Draw),
    ) -> Result<()> {
        for _ in 0..count {
            let Some(place) = draw.take(free) else {
                return Err(Error::Usage(format!("no room for {count} {what}; use a larger grid or fewer")));
            };
            set(self.world.cell_mut(place), draw);
        }
        Ok(())
    }
}

fn block(corner: Place, height: usize, width: usize) -> impl Iterator<Item = Place> {
    (0..height).flat_map(move |r| (0..width).map(move |c| Place { row: corner.row + r, col: corner.col + c }))
}
