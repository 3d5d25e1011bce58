//! A grid world as plain data, and where each move in it leads.

use std::collections::BTreeMap;

/// One of the four ways to go. North is one row up: row 0 is the southernmost.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Direction {
    /// One row up.
    North,
    /// One row down.
    South,
    /// One column on.
    East,
    /// One column back.
    West,
}

impl Direction {
    /// All four, in the order in which everything lists them.
    pub const ALL: [Direction; 4] = [Direction::North, Direction::South, Direction::East, Direction::West];

    /// The word for it, which is also the name of the action.
    pub fn name(self) -> &'static str {
        match self {
            Direction::North => "north",
            Direction::South => "south",
            Direction::East => "east",
            Direction::West => "west",
        }
    }

    /// The capital letter for it.
    pub fn letter(self) -> char {
        match self {
            Direction::North => 'N',
            Direction::South => 'S',
            Direction::East => 'E',
            Direction::West => 'W',
        }
    }

    /// The change of row and column.
    pub(super) fn shift(self) -> Shift {
        match self {
            Direction::North => Shift { rows: 1, cols: 0 },
            Direction::South => Shift { rows: -1, cols: 0 },
            Direction::East => Shift { rows: 0, cols: 1 },
            Direction::West => Shift { rows: 0, cols: -1 },
        }
    }
}

/// A change of row and column.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub(super) struct Shift {
    /// Rows further north.
    pub(super) rows: i64,
    /// Columns further east.
    pub(super) cols: i64,
}

/// A set of directions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub struct Directions(u8);

impl Directions {
    /// The set with `direction` in it.
    #[must_use]
    pub fn with(self, direction: Direction) -> Self {
        Directions(self.0 | 1 << direction as u8)
    }

    /// Whether `direction` is in the set.
    pub fn contains(self, direction: Direction) -> bool {
        self.0 & 1 << direction as u8 != 0
    }

    /// Whether the set has no member.
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// The members, in the order of [`Direction::ALL`].
    pub fn iter(self) -> impl Iterator<Item = Direction> {
        Direction::ALL.into_iter().filter(move |&d| self.contains(d))
    }
}

impl FromIterator<Direction> for Directions {
    fn from_iter<I: IntoIterator<Item = Direction>>(directions: I) -> Self {
        directions.into_iter().fold(Directions::default(), Directions::with)
    }
}

/// A cell's coordinates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Place {
    /// Rows north of the southernmost.
    pub(super) row: usize,
    /// Columns east of the westernmost.
    pub(super) col: usize,
}

/// What one cell is like.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct Cell {
    /// Nothing gets in.
    pub(super) wall: bool,
    /// Where one may slide to on arrival; empty: the cell is dry.
    pub(super) slip: Directions,
    /// It is entered and left in this direction only.
    pub(super) one_way: Option<Direction>,
    /// Actions that cannot be chosen here.
    pub(super) disabled: Directions,
    /// The item that lies here, by its number in [`World::items`].
    pub(super) item: Option<usize>,
    /// The battery is filled here.
    pub(super) charger: bool,
}

/// What an item can make available.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Lock {
    /// An item, by its number.
    Item(usize),
    /// All chargers.
    Charger,
}

/// Something to be picked up, in the cells that name it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Item {
    /// A capital letter.
    pub(super) name: char,
    /// What becomes available when it is picked up.
    pub(super) opens: Vec<Lock>,
}

/// A moving obstacle: it walks at random up and down a straight track.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Patrol {
    /// The southern or western end, where it starts.
    pub(super) from: Place,
    /// The other end.
    pub(super) to: Place,
}

impl Patrol {
    /// Whether the track runs from south to north.
    pub(super) fn is_vertical(&self) -> bool {
        self.from.col == self.to.col
    }

    /// Whether `place` is on the track.
    pub(super) fn covers(&self, place: Place) -> bool {
        (self.from.row..=self.to.row).contains(&place.row)
            && (self.from.col..=self.to.col).contains(&place.col)
    }
}

/// A grid with all that is on it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct World {
    /// Number of rows.
    pub(super) rows: usize,
    /// Number of columns.
    pub(super) cols: usize,
    /// What the battery holds; `None`: the robots never tire.
    pub(super) battery: Option<u32>,
    /// The cells, row by row from the south.
    pub(super) cells: Vec<Cell>,
    /// The items, in the order of their names.
    pub(super) items: Vec<Item>,
    /// Where the robots start.
    pub(super) starts: Vec<Place>,
    /// The moving obstacles.
    pub(super) patrols: Vec<Patrol>,
}

/// What being in a cell after a move brings about.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Effect {
    /// The locked item that must be available for `opens` to happen.
    pub(super) needs: Option<usize>,
    /// What becomes available.
    pub(super) opens: Vec<Lock>,
    /// Whether the battery is filled (where the chargers are available).
    pub(super) charges: bool,
}

/// One result of a move.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Branch {
    /// From where the move started to where it ends.
    pub(super) shift: Shift,
    /// What happens there.
    pub(super) effect: Option<Effect>,
    /// Its probability, in parts of the sum over all branches.
    pub(super) weight: u32,
}

/// The cells from which a move has the same results.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Group {
    /// The results.
    pub(super) branches: Vec<Branch>,
    /// The cells.
    pub(super) origins: CellSet,
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
    /// The set of the cells with a property.
    pub(super) fn new(world: &World, property: impl Fn(Place) -> bool) -> Self {
        CellSet { cols: world.cols, members: world.places().map(property).collect() }
    }

    /// Whether the set has no member.
    pub(super) fn is_empty(&self) -> bool {
        !self.members.contains(&true)
    }
}

impl World {
    /// All cells' coordinates, row by row from the south.
    pub(super) fn places(&self) -> impl Iterator<Item = Place> + use<> {
        let (rows, cols) = (self.rows, self.cols);
        (0..rows).flat_map(move |row| (0..cols).map(move |col| Place { row, col }))
    }

    /// The number of a cell in [`World::cells`].
    pub(super) fn index(&self, place: Place) -> usize {
        place.row * self.cols + place.col
    }

    /// The cell at a place.
    pub(super) fn cell(&self, place: Place) -> &Cell {
        &self.cells[self.index(place)]
    }

    /// Whether an item opens this lock: only then it is closed at first.
    pub(super) fn is_locked(&self, lock: Lock) -> bool {
        self.items.iter().any(|item| item.opens.contains(&lock))
    }

    /// The locks that start closed: items first, chargers last.
    pub(super) fn locks(&self) -> Vec<Lock> {
        let items = (0..self.items.len()).map(Lock::Item);
        items.chain([Lock::Charger]).filter(|&lock| self.is_locked(lock)).collect()
    }

    /// The items that can never be picked up, because all that opens them is closed for ever.
    pub(super) fn unavailable(&self) -> Vec<usize> {
        let count = self.items.len();
        let mut open: Vec<bool> = (0..count).map(|i| !self.is_locked(Lock::Item(i))).collect();
        // Each round opens at least one more, or was the last.
        for _ in 0..count {
            for (i, item) in self.items.iter().enumerate().filter(|(i, _)| open[*i]).collect::<Vec<_>>() {
                let opened = item.opens.iter().filter_map(|lock| match lock {
                    Lock::Item(j) if *j != i => Some(*j),
                    _ => None,
                });
                opened.for_each(|j| open[j] = true);
            }
        }
        (0..count).filter(|&i| !open[i]).collect()
    }

    /// Where one step leads, or `None` where a wall, the edge or a one-way cell is in the way.
    pub(super) fn step(&self, from: Place, direction: Direction) -> Option<Place> {
        let Shift { rows, cols } = direction.shift();
        let row = from.row.checked_add_signed(isize::try_from(rows).ok()?)?;
        let col = from.col.checked_add_signed(isize::try_from(cols).ok()?)?;
        let to = Place { row, col };
        let passes = |place: Place| self.cell(place).one_way.is_none_or(|only| only == direction);
        (row < self.rows && col < self.cols && !self.cell(to).wall && passes(from) && passes(to))
            .then_some(to)
    }

    /// What being in a cell after a move brings about.
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

    /// The results of a move, or `None` where it is disabled. A move that is blocked stays and does
    /// not slip; a move onto a slippery cell ends there or one step further in one of its directions,
    /// and a slide that is blocked ends in the slippery cell.
    pub(super) fn outcome(&self, from: Place, direction: Direction) -> Option<Vec<Branch>> {
        if self.cell(from).disabled.contains(direction) {
            return None;
        }
        let Some(to) = self.step(from, direction) else {
            return Some(vec![self.branch(from, from, 1)]);
        };
        let slides = self.cell(to).slip.iter().map(|slide| self.step(to, slide).unwrap_or(to));
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
        let difference = |a: usize, b: usize| if a >= b { (a - b) as i64 } else { -((b - a) as i64) };
        let shift = Shift { rows: difference(to.row, from.row), cols: difference(to.col, from.col) };
        Branch { shift, effect: self.effect(to), weight }
    }

    /// The cells, grouped by what a move in `direction` does there; cells where it is disabled are
    /// in no group.
    pub(super) fn groups(&self, direction: Direction) -> Vec<Group> {
        let mut groups: BTreeMap<Vec<Branch>, Vec<bool>> = BTreeMap::new();
        for place in self.places() {
            if let Some(branches) = self.outcome(place, direction) {
                let members = groups.entry(branches).or_insert_with(|| vec![false; self.cells.len()]);
                members[self.index(place)] = true;
            }
        }
        let set = |members| CellSet { cols: self.cols, members };
        groups.into_iter().map(|(branches, members)| Group { branches, origins: set(members) }).collect()
    }
}
