//! A grid world as plain data, and the results of moves.

use std::collections::BTreeMap;

use strum::{EnumString, IntoStaticStr};

/// A direction. North is one row up: row 0 is the southernmost.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, EnumString, IntoStaticStr)]
#[strum(serialize_all = "lowercase")]
pub enum Direction {
    /// One row up.
    North,
    /// One row down.
    South,
    /// One column to the right.
    East,
    /// One column to the left.
    West,
}

impl Direction {
    /// All four, in the order used by all lists.
    pub const ALL: [Direction; 4] = [Direction::North, Direction::South, Direction::East, Direction::West];

    /// Returns its name, which is also the name of the action.
    pub(crate) fn name(self) -> &'static str {
        self.into()
    }

    /// Returns its initial as a capital letter.
    pub fn letter(self) -> char {
        char::from(self.name().as_bytes()[0].to_ascii_uppercase())
    }

    /// Returns the change of row and column.
    pub(super) fn shift(self) -> Shift {
        match self {
            Direction::North => (1, 0),
            Direction::South => (-1, 0),
            Direction::East => (0, 1),
            Direction::West => (0, -1),
        }
    }
}

/// A change of row and column: rows further north, columns further east.
pub(super) type Shift = (isize, isize);

/// A set of directions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub struct Directions(u8);

impl Directions {
    /// Returns true if `direction` is in the set.
    pub(crate) fn contains(self, direction: Direction) -> bool {
        self.0 & 1 << direction as u8 != 0
    }

    /// Returns true if the set is empty.
    pub(crate) fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Returns the members, in the order of [`Direction::ALL`].
    pub(crate) fn iter(self) -> impl Iterator<Item = Direction> {
        Direction::ALL.into_iter().filter(move |&d| self.contains(d))
    }
}

impl FromIterator<Direction> for Directions {
    fn from_iter<I: IntoIterator<Item = Direction>>(directions: I) -> Self {
        Directions(directions.into_iter().fold(0, |set, direction| set | 1 << direction as u8))
    }
}

/// The coordinates of a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Place {
    /// The row, counted from the south.
    pub(super) row: usize,
    /// The column, counted from the west.
    pub(super) col: usize,
}

impl Place {
    /// Returns the place after a shift; `None` south or west of the grid.
    pub(super) fn moved(self, (rows, cols): Shift) -> Option<Place> {
        Some(Place { row: self.row.checked_add_signed(rows)?, col: self.col.checked_add_signed(cols)? })
    }
}

/// The properties of a cell.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct Cell {
    /// True if the cell cannot be entered.
    pub(super) wall: bool,
    /// The directions in which a robot may slide on arrival; empty if the cell is not slippery.
    pub(super) slip: Directions,
    /// The only direction in which the cell is entered and left.
    pub(super) one_way: Option<Direction>,
    /// The actions that are disabled here.
    pub(super) disabled: Directions,
    /// The item in this cell, by its index in [`World::items`].
    pub(super) item: Option<usize>,
    /// True if the battery is filled here.
    pub(super) charger: bool,
    /// True if the cell is in a fork, which opponents do not enter.
    pub(super) refuge: bool,
}

/// An object that items can open.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Lock {
    /// An item, by its index.
    Item(usize),
    /// All chargers.
    Charger,
}

/// An item, which is picked up in the cells that name it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Item {
    /// The name, a capital letter.
    pub(super) name: char,
    /// The locks that open when it is picked up.
    pub(super) opens: Vec<Lock>,
}

/// A moving obstacle, on a random walk along a straight track.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Patrol {
    /// The southern or western end, where it starts.
    pub(super) from: Place,
    /// The other end.
    pub(super) to: Place,
}

impl Patrol {
    /// Returns true if the track runs from south to north.
    pub(super) fn is_vertical(&self) -> bool {
        self.from.col == self.to.col
    }

    /// Returns true if `place` is on the track.
    pub(super) fn covers(&self, place: Place) -> bool {
        (self.from.row..=self.to.row).contains(&place.row)
            && (self.from.col..=self.to.col).contains(&place.col)
    }
}

/// A grid with its contents.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct World {
    /// Number of rows.
    pub(super) rows: usize,
    /// Number of columns.
    pub(super) cols: usize,
    /// The capacity of the battery; `None` if moves are free.
    pub(super) battery: Option<u32>,
    /// The cells, row by row from the south.
    pub(super) cells: Vec<Cell>,
    /// The items, in the order of their names.
    pub(super) items: Vec<Item>,
    /// The start cells of the robots.
    pub(super) starts: Vec<Place>,
    /// The moving obstacles.
    pub(super) patrols: Vec<Patrol>,
    /// The start cells of the opponents.
    pub(super) opponents: Vec<Place>,
}

/// The effect of ending a move in a cell.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Effect {
    /// The locked item that must be available for `opens` to happen.
    pub(super) needs: Option<usize>,
    /// The locks that open.
    pub(super) opens: Vec<Lock>,
    /// True if the battery is filled, provided that the chargers are available.
    pub(super) charges: bool,
}

/// One possible result of a move.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Branch {
    /// The difference between the end and the start of the move.
    pub(super) shift: Shift,
    /// The effect at the end.
    pub(super) effect: Option<Effect>,
    /// Its probability, as a share of the sum over all branches.
    pub(super) weight: u32,
}

/// A set of cells of one grid.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct CellSet {
    /// Number of columns of the grid.
    pub(super) cols: usize,
    /// Membership, row by row from the south.
    pub(super) members: Vec<bool>,
}

impl CellSet {
    /// Returns the set of the cells with a property.
    pub(super) fn new(world: &World, property: impl Fn(Place) -> bool) -> Self {
        CellSet { cols: world.cols, members: world.places().map(property).collect() }
    }

    /// Returns true if the set is empty.
    pub(super) fn is_empty(&self) -> bool {
        !self.members.contains(&true)
    }
}

impl World {
    /// Returns a grid of free cells, with items that open nothing.
    pub(super) fn new(rows: usize, cols: usize, names: impl IntoIterator<Item = char>) -> Self {
        World {
            rows,
            cols,
            battery: None,
            cells: vec![Cell::default(); rows * cols],
            items: names.into_iter().map(|name| Item { name, opens: Vec::new() }).collect(),
            starts: Vec::new(),
            patrols: Vec::new(),
            opponents: Vec::new(),
        }
    }

    /// Returns the coordinates of all cells, row by row from the south.
    pub(super) fn places(&self) -> impl Iterator<Item = Place> + use<> {
        let (rows, cols) = (self.rows, self.cols);
        (0..rows).flat_map(move |row| (0..cols).map(move |col| Place { row, col }))
    }

    /// Returns the index of a cell in [`World::cells`].
    pub(super) fn index(&self, place: Place) -> usize {
        place.row * self.cols + place.col
    }

    /// Returns the cell at a place.
    pub(super) fn cell(&self, place: Place) -> &Cell {
        &self.cells[self.index(place)]
    }

    /// Returns the cell at a place, to be changed.
    pub(super) fn cell_mut(&mut self, place: Place) -> &mut Cell {
        let index = self.index(place);
        &mut self.cells[index]
    }

    /// Returns true if an item opens this lock; only such locks start closed.
    pub(super) fn is_locked(&self, lock: Lock) -> bool {
        self.items.iter().any(|item| item.opens.contains(&lock))
    }

    /// Returns the locks that start closed: items first, chargers last.
    pub(super) fn locks(&self) -> Vec<Lock> {
        let items = (0..self.items.len()).map(Lock::Item);
        items.chain([Lock::Charger]).filter(|&lock| self.is_locked(lock)).collect()
    }

    /// Returns the items that can never be picked up, because all items that open them stay closed.
    pub(super) fn unavailable(&self) -> Vec<usize> {
        let count = self.items.len();
        let mut open: Vec<bool> = (0..count).map(|i| !self.is_locked(Lock::Item(i))).collect();
        // Each round opens at least one more item, until none is left.
        for _ in 0..count {
            for (i, item) in self.items.iter().enumerate() {
                for &lock in if open[i] { &item.opens[..] } else { &[] } {
                    if let Lock::Item(opened) = lock {
                        open[opened] = true;
                    }
                }
            }
        }
        (0..count).filter(|&i| !open[i]).collect()
    }

    /// Returns the cell one step away; `None` if a wall, the edge or a one-way cell is in the way.
    pub(super) fn step(&self, from: Place, direction: Direction) -> Option<Place> {
        let to = from.moved(direction.shift())?;
        let passes = |place: Place| self.cell(place).one_way.is_none_or(|only| only == direction);
        (to.row < self.rows && to.col < self.cols && !self.cell(to).wall && passes(from) && passes(to))
            .then_some(to)
    }

    /// Returns true if opponents can enter a cell. They could block an item or a charger forever.
    pub(super) fn is_open(&self, place: Place) -> bool {
        let cell = self.cell(place);
        !(cell.wall || cell.refuge || cell.charger || cell.item.is_some())
    }

    /// Returns the cell one step away that an opponent can enter.
    pub(super) fn opponent_step(&self, from: Place, direction: Direction) -> Option<Place> {
        let to = from.moved(direction.shift())?;
        (to.row < self.rows && to.col < self.cols && self.is_open(to)).then_some(to)
    }

    /// Returns the effect of ending a move in a cell.
    pub(super) fn effect(&self, place: Place) -> Option<Effect> {
        let cell = self.cell(place);
        let item = cell.item.filter(|&i| !self.items[i].opens.is_empty());
        let effect = Effect {
            needs: item.filter(|&i| self.is_locked(Lock::Item(i))),
            opens: item.map(|i| self.items[i].opens.clone()).unwrap_or_default(),
            charges: cell.charger && self.battery.is_some(),
        };
        (effect.charges || !effect.opens.is_empty()).then_some(effect)
    }

    /// Returns the results of a move; `None` if it is disabled. A blocked move ends in its start
    /// cell, without slipping. A move onto a slippery cell ends there, or one step further in one
    /// of its directions. A blocked slide ends in the slippery cell.
    pub(super) fn outcome(&self, from: Place, direction: Direction) -> Option<Vec<Branch>> {
        self.outcome_among(from, direction, &[])
    }

    /// Returns the results of a move among opponents; they block their cells, as walls do.
    pub(super) fn outcome_among(
        &self,
        from: Place,
        direction: Direction,
        opponents: &[Place],
    ) -> Option<Vec<Branch>> {
        if self.cell(from).disabled.contains(direction) {
            return None;
        }
        let step = |from, direction| self.step(from, direction).filter(|to| !opponents.contains(to));
        let Some(to) = step(from, direction) else {
            return Some(vec![self.branch(from, from, 1)]);
        };
        let slides = self.cell(to).slip.iter().map(|slide| step(to, slide).unwrap_or(to));
        let mut weights: BTreeMap<Place, u32> = BTreeMap::from([(to, 1)]);
        slides.for_each(|end| *weights.entry(end).or_insert(0) += 1);
        if weights.len() == 1 {
            return Some(vec![self.branch(from, to, 1)]);
        }
        let sure = weights.remove(&to).unwrap_or(1);
        let mut branches = vec![self.branch(from, to, sure)];
        branches.extend(weights.into_iter().map(|(end, weight)| self.branch(from, end, weight)));
        Some(branches)
    }

    fn branch(&self, from: Place, to: Place, weight: u32) -> Branch {
        let difference = |a: usize, b: usize| a as isize - b as isize;
        let shift = (difference(to.row, from.row), difference(to.col, from.col));
        Branch { shift, effect: self.effect(to), weight }
    }

    /// Groups the cells by the results of a move in `direction`; cells in which it is disabled are
    /// left out.
    pub(super) fn groups(&self, direction: Direction) -> BTreeMap<Vec<Branch>, CellSet> {
        let mut groups = BTreeMap::new();
        for place in self.places() {
            if let Some(branches) = self.outcome(place, direction) {
                let origins = groups.entry(branches).or_insert_with(|| CellSet::new(self, |_| false));
                origins.members[self.index(place)] = true;
            }
        }
        groups
    }
}
