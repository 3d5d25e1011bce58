//! Generators of models with preferences, from a few numbers or from a drawing.
//!
//! - [`gridworld`]: a random grid world of [`Parameters`].
//! - [`from_map`]: the world of a map file.
//! - [`Generated`]: the texts of the model and of the preferences.
//!
//! ```
//! use meliora_generate::{Choices, Parameters, gridworld};
//!
//! let choices = Choices { prefer: Some("B>A".into()), empty: None, seed: 0 };
//! let world = gridworld(&Parameters::new(3, 3, 2), &choices)?;
//! assert!(world.model.contains("endmodule"));
//! assert!(world.preferences.contains("prefer"));
//! # Ok::<(), meliora_base::error::Error>(())
//! ```
//!
//! # The grid world
//! Robots move north, south, east or west over a grid, pick up items and use up their
//! battery. A move into a wall, off the grid or against a one-way cell leaves the robot in its
//! cell; a move onto a slippery cell may slide one step further. A move costs one unit of battery,
//! even if it is blocked; at 0 the robot stays in its cell forever. Ending a move in the cell of a
//! charger fills the battery. Items can
//! *open* other items, or the chargers. An item that others open becomes available when one of them is picked
//! up: when a robot ends a move in its cell while it is available. Chargers become available in the
//! same way. The objective `A` is to be in the cell of the available item A.
//!
//! Several robots act in turns, in any order; they share the items that are opened and do not block
//! each other. A moving obstacle takes a random step along its track whenever a robot acts. It
//! blocks the cell in which it is at the start of the move; a slide ignores it.
//!
//! With opponents, the model is a game. After each move of a robot, each opponent moves to a neighbouring
//! cell or stays. Nobody enters a cell that a robot and an opponent would share: it is blocked, also for
//! slides. An opponent does not slip and has no battery; one-way cells do not stop it. It enters no walls,
//! and no cells of items, chargers and forks, where it could block us forever.
//!
//! # Map files
//! ```text
//! // A comment.
//! map
//! C.+.E
//! #~.!#
//! B.R.D
//! #~F~#
//! A.#.*
//! end
//! battery 8                      // or none, which is the default
//! cell + no east west            // what a sign means
//! cell R start no east west
//! cell ! slip north south west
//! open A B -> D E charger        // A and B make these available
//! open C -> E F charger
//! patrol 1,1 3,1                 // a moving obstacle between two cells, as row,column
//! prefer D>A, E>A, D>B, E>B, E>C, F>C
//! empty gain                     // bottom, gain or incomparable
//! ```
//! The rows of the map are listed from north to south, one character per cell. Row 0 is the last row.
//! Characters with a default meaning: `.` and blank free, `#` wall, `A`-`Z` items, `*` charger,
//! `@` start of a robot, `~` slippery (north and south), `^` `v` `>` `<` one-way. `cell SIGN KIND…`
//! gives a character a new meaning. The kinds are `free`, `wall`, `charger`, `start`, `item X`,
//! `slip DIRECTION…`, `no DIRECTION…` (disables these actions) and `oneway DIRECTION`; several may
//! be combined. Without a `prefer` statement the order is random.

mod cells;
mod fork;
mod map;
mod opponent;
mod picture;
mod preference;
mod random;
#[cfg(test)]
mod tests;
mod world;
mod write;

use std::sync::Arc;

pub use meliora_model::preference::Empty;
pub use world::{Direction, Directions};

use meliora_base::error::{Error, Result, SourceFile, ensure};
use meliora_base::random::Draw;
use meliora_model::preference::Statement;
use world::World;

/// The maximum number of rows, and of columns.
const LARGEST_SIDE: usize = 1024;
/// The maximum capacity of a battery, in moves.
pub const LARGEST_BATTERY: u32 = 100_000;
/// The maximum number of items: one for each capital letter.
pub const MOST_ITEMS: usize = 26;
/// The maximum number of robots.
pub const MOST_ROBOTS: usize = 9;
/// The maximum number of opponents.
pub const MOST_OPPONENTS: usize = 9;

/// The parameters of a random grid world.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Parameters {
    /// Number of rows.
    pub rows: usize,
    /// Number of columns.
    pub cols: usize,
    /// Capacity of the battery; `None` if moves are free.
    pub battery: Option<u32>,
    /// Number of items.
    pub items: usize,
    /// Number of items that others must open.
    pub locked: usize,
    /// Number of chargers.
    pub chargers: usize,
    /// True if an item must open the chargers.
    pub locked_charger: bool,
    /// Walls, in per cent of the cells.
    pub walls: usize,
    /// Slippery cells, in per cent of the cells.
    pub slippery: usize,
    /// Directions in which slippery cells may slide; each cell draws one of these sets.
    pub drifts: Vec<Directions>,
    /// Number of one-way cells.
    pub one_way: usize,
    /// Number of cells in which two opposite actions are disabled.
    pub disabled: usize,
    /// Number of robots.
    pub robots: usize,
    /// Number of moving obstacles.
    pub patrols: usize,
    /// Number of robots of the opponent; with them, the model is a game.
    pub opponents: usize,
    /// Number of forks in a sequence. A fork is a dead end where chance decides between the last
    /// two items (the two before them at the next fork, and so on), each better than all before it.
    pub forks: usize,
}

impl Parameters {
    /// Returns the parameters of the benchmark family. Walls and slippery cells take 10 % of the
    /// cells each. There is one locked charger, and the battery has three times the longer side.
    /// There is one fork if it fits (two from 7 items on), and half of the other items are locked.
    pub fn new(rows: usize, cols: usize, items: usize) -> Self {
        use Direction::{East, North, South, West};
        let fits = |forks: usize| {
            let (height, width) = fork::size(forks);
            items > 2 * forks && items >= 4 * forks - 1 && rows > height && cols > width
        };
        let forks = (1..=2).rev().find(|&forks| fits(forks)).unwrap_or(0);
        let drifts = [&[North, South][..], &[East, West], &[North, South, West]];
        Parameters {
            rows,
            cols,
            battery: u32::try_from(3 * rows.max(cols)).ok(),
            items,
            locked: (items - 2 * forks) / 2,
            chargers: 1,
            locked_charger: items > 0,
            walls: 10,
            slippery: 10,
            drifts: drifts.map(|drift| drift.iter().copied().collect()).to_vec(),
            one_way: 0,
            disabled: 0,
            robots: 1,
            patrols: 0,
            opponents: 0,
            forks,
        }
    }

    /// Returns the command that generates this world, for the first lines of the files. The order
    /// and the value of nothing are in the preference file itself.
    fn command(&self, choices: &Choices) -> String {
        let battery = self.battery.map_or("none".to_owned(), |full| full.to_string());
        let drift = |drift: &Directions| drift.iter().map(Direction::letter).collect::<String>();
        let drifts: Vec<String> = self.drifts.iter().map(drift).collect();
        let numbers = [
            ("rows", self.rows),
            ("cols", self.cols),
            ("items", self.items),
            ("locked", self.locked),
            ("chargers", self.chargers),
            ("walls", self.walls),
            ("slippery", self.slippery),
            ("one-way", self.one_way),
            ("disabled", self.disabled),
            ("robots", self.robots),
            ("patrols", self.patrols),
            ("opponent", self.opponents),
            ("forks", self.forks),
        ];
        let numbers = numbers.iter().filter(|(name, n)| {
            *n != 0 || matches!(*name, "locked" | "chargers" | "forks" | "walls" | "slippery")
        });
        let mut command = "meliora generate gridworld".to_owned();
        numbers.for_each(|(name, number)| command += &format!(" --{name} {number}"));
        command += if self.locked_charger { "" } else { " --open-chargers" };
        command += &if drifts.is_empty() { String::new() } else { format!(" --drift {}", drifts.join(",")) };
        command + &format!(" --battery {battery} --seed {}", choices.seed)
    }

    /// Checks that the parameters describe a model.
    fn validate(&self) -> Result<()> {
        check_size(self.rows, self.cols).map_err(Error::Usage)?;
        self.check_forks()?;
        let Parameters { locked, robots, chargers, .. } = self;
        let scattered = self.items - 2 * self.forks;
        let has_drifts = !self.drifts.is_empty() && self.drifts.iter().all(|drift| !drift.is_empty());
        require(self.battery.is_none_or(|full| (1..=LARGEST_BATTERY).contains(&full)), || {
            format!("a battery holds 1 to {LARGEST_BATTERY} units; `none` is one that never ends")
        })?;
        require(*locked < scattered, || {
            let reason = "one must be there to open the others";
            format!("{locked} of {scattered} items outside the forks are locked: {reason}")
        })?;
        require((1..=MOST_ROBOTS).contains(robots), || {
            format!("there must be 1 to {MOST_ROBOTS} robots, not {robots}")
        })?;
        require(self.opponents <= MOST_OPPONENTS, || {
            format!("there can be at most {MOST_OPPONENTS} opponents, not {}", self.opponents)
        })?;
        require(self.opponents == 0 || self.patrols == 0, || {
            "a world with opponents has no moving obstacles".to_owned()
        })?;
        require(*chargers <= self.rows * self.cols, || {
            format!("{chargers} chargers are more than there are cells")
        })?;
        require(self.walls <= 90 && self.slippery <= 100, || {
            "at most 90 per cent of the cells can be walls, at most 100 slippery".to_owned()
        })?;
        require(self.slippery == 0 || has_drifts, || {
            "a slippery cell needs a direction to slide to".to_owned()
        })
    }

    fn check_forks(&self) -> Result<()> {
        let (rows, cols) = fork::size(self.forks.min(fork::DEEPEST));
        let Parameters { items, forks, .. } = *self;
        require((1..=MOST_ITEMS).contains(&items), || {
            format!("there must be 1 to {MOST_ITEMS} items, not {items}")
        })?;
        require(forks <= fork::DEEPEST, || {
            format!("there can be at most {} forks, not {forks}", fork::DEEPEST)
        })?;
        require(self.rows >= rows && self.cols >= cols, || {
            format!("{forks} forks need {rows} rows and {cols} columns")
        })?;
        require(items > 2 * forks, || {
            format!("{forks} forks take {} items, and one must lie outside: use more items", 2 * forks)
        })
    }
}

/// Returns a usage error with this message if a condition is false.
fn require(holds: bool, message: impl FnOnce() -> String) -> Result<()> {
    ensure(holds, || Error::Usage(message()))
}

/// The seed, and values that replace drawn ones.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Choices {
    /// Statements such as `D>A, E>=A, B~C`; `None` for those of the map, or a random order.
    pub prefer: Option<String>,
    /// The value of nothing; `None` for that of the map, or `bottom`.
    pub empty: Option<Empty>,
    /// The seed of the random draws.
    pub seed: u64,
}

/// A model and its preferences as texts.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Generated {
    /// The model, in PRISM's language.
    pub model: String,
    /// The preference file.
    pub preferences: String,
}

/// Generates a random grid world. The same arguments give the same texts in every version and on
/// every machine.
///
/// # Errors
/// [`Error::Usage`] if the parameters or the given preferences are invalid, or if there is not
/// enough room.
pub fn gridworld(parameters: &Parameters, choices: &Choices) -> Result<Generated> {
    let mut draw = Draw::new(choices.seed);
    let world = random::world(parameters, &mut draw)?;
    let title =
        format!("A random {} x {} grid world.\n// {}", world.rows, world.cols, parameters.command(choices));
    finish(&world, &title, choices, parameters.forks, None, None)
}

/// Generates the grid world of a map file.
///
/// # Errors
/// [`Error::Input`] with the place if the map is invalid; [`Error::Usage`] if the given preferences
/// are.
pub fn from_map(source: &Arc<SourceFile>, choices: &Choices) -> Result<Generated> {
    let map = map::read(source)?;
    let name = source.name.rsplit(['/', '\\']).next().unwrap_or_default();
    let title = format!("A grid world, drawn in {name:?}.");
    finish(&map.world, &title, choices, 0, map.prefer, map.empty)
}

fn finish(
    world: &World,
    title: &str,
    choices: &Choices,
    forks: usize,
    prefer: Option<Vec<Statement>>,
    empty: Option<Empty>,
) -> Result<Generated> {
    let statements = match (&choices.prefer, prefer) {
        (Some(text), _) => preference::parse(text, world)
            .map_err(|(_, message)| Error::Usage(format!("the preferences `{text}`: {message}")))?,
        (None, Some(statements)) => statements,
        // The order has a stream of its own, so that the world does not depend on whether the order
        // is drawn or given.
        (None, None) => preference::random(world, forks, &mut Draw::new(!choices.seed)),
    };
    let empty = choices.empty.or(empty).unwrap_or_default();
    Ok(Generated {
        model: write::write(world, title),
        preferences: preference::write(world, &statements, empty, title),
    })
}

/// Checks that a grid of this size is neither empty nor too large.
fn check_size(rows: usize, cols: usize) -> Result<(), String> {
    let sides = 1..=LARGEST_SIDE;
    ensure(sides.contains(&rows) && sides.contains(&cols), || {
        format!("a grid has 1 to {LARGEST_SIDE} rows and columns, not {rows} x {cols}")
    })
}
