//! The writer of the opponents of a game: players, turns, and the cells that opponents block.

use std::collections::BTreeSet;

use super::cells::condition;
use super::world::{Branch, CellSet, Direction, Shift, World};
use super::write::{Robot, formula, offset};

/// The stem of the action of an opponent that does not move.
const STAY: &str = "stay";

/// An opponent with its names, which end in its number if there are several.
struct Opponent<'a> {
    world: &'a World,
    number: usize,
}

impl<'a> Opponent<'a> {
    fn all(world: &'a World) -> impl Iterator<Item = Self> {
        (0..world.opponents.len()).map(move |number| Opponent { world, number })
    }

    fn name(&self, stem: &str) -> String {
        let line = if stem.is_empty() { "" } else { "_" };
        let several = self.world.opponents.len() > 1;
        let suffix = if several { (self.number + 1).to_string() } else { String::new() };
        format!("opponent{line}{stem}{suffix}")
    }

    fn actions(&self) -> Vec<String> {
        let stems = Direction::ALL.map(Direction::name).into_iter().chain([STAY]);
        stems.map(|stem| self.name(stem)).collect()
    }

    /// Returns the condition that it is in the cell that a shift leads to from another place.
    fn is_at(&self, (row, col): (&str, &str), (rows, cols): Shift) -> String {
        format!("{}={} & {}={}", self.name("r"), offset(row, rows), self.name("c"), offset(col, cols))
    }

    /// Returns where it starts: two numbers, or constants if there are several opponents.
    fn start(&self) -> (String, String) {
        let place = self.world.opponents[self.number];
        match self.world.opponents.len() {
            1 => (place.row.to_string(), place.col.to_string()),
            _ => (self.name("row"), self.name("col")),
        }
    }

    /// Returns the formulas for a direction: a cell is closed, or somebody is in it.
    fn formulas(&self, direction: Direction, robots: &[Robot<'_>]) -> String {
        let (r, c, world) = (self.name("r"), self.name("c"), self.world);
        let closed = CellSet::new(world, |place| world.opponent_step(place, direction).is_none());
        let shift = direction.shift();
        let (row, col) = (offset(&r, shift.0), offset(&c, shift.1));
        let robots =
            robots.iter().map(|robot| format!("{}={row} & {}={col}", robot.name("r"), robot.name("c")));
        let others = Opponent::all(world).filter(|other| other.number != self.number);
        let others = others.map(|other| other.is_at((&r, &c), shift));
        let named = |what: &str| self.name(&format!("{}_{what}", direction.name()));
        formula(&named("closed"), &condition(&closed, &r, &c))
            + &formula(&named("met"), &robots.chain(others).collect::<Vec<_>>())
    }

    fn module(&self) -> String {
        let ((row, col), world) = (self.start(), self.world);
        let (r, c) = (self.name("r"), self.name("c"));
        let mut text = format!("\nmodule {}\n\n", self.name(""));
        text += &format!("  {r} : [0..{}] init {row};  // row\n", world.rows - 1);
        text += &format!("  {c} : [0..{}] init {col};  // column\n\n", world.cols - 1);
        for direction in Direction::ALL {
            let named = |what: &str| self.name(&format!("{}_{what}", direction.name()));
            let (rows, cols) = direction.shift();
            let update = match rows {
                0 => format!("({c}'={})", offset(&c, cols)),
                _ => format!("({r}'={})", offset(&r, rows)),
            };
            let action = self.name(direction.name());
            text += &format!("  [{action}] !{} & !{} -> {update};\n", named("closed"), named("met"));
        }
        text + &format!("  [{}] true -> true;\n\nendmodule\n", self.name(STAY))
    }

    /// Returns the module of a further opponent: that of the first with the names of the two exchanged.
    fn renamed(&self, first: &Self) -> String {
        let pair = |stem: &str| format!("{}={}", first.name(stem), self.name(stem));
        let back = |stem: &str| format!("{}={}", self.name(stem), first.name(stem));
        let positions = ["r", "c"].into_iter().flat_map(|stem| [pair(stem), back(stem)]);
        let others = ["row", "col", STAY].into_iter().chain(Direction::ALL.map(Direction::name)).map(pair);
        let pairs: Vec<String> = positions.chain(others).collect();
        let lines: Vec<String> = pairs.chunks(3).map(|chunk| chunk.join(", ")).collect();
        format!("\nmodule {} = {} [{}] endmodule\n", self.name(""), first.name(""), lines.join(",\n  "))
    }
}

/// Returns the players: the robots together, and each opponent. Empty without opponents.
pub(super) fn players(world: &World, robots: &[Robot<'_>]) -> String {
    if world.opponents.is_empty() {
        return String::new();
    }
    let player = |name: &str, actions: &[String]| {
        let actions: Vec<String> = actions.iter().map(|action| format!("[{action}]")).collect();
        let lines: Vec<String> = actions.chunks(5).map(|chunk| chunk.join(", ")).collect();
        format!("player {name} {} endplayer\n", lines.join(",\n  "))
    };
    let own: Vec<String> = robots.iter().flat_map(Robot::actions).collect();
    let name = if robots.len() == 1 { "robot" } else { "robots" };
    let opponents = Opponent::all(world).map(|opponent| player(&opponent.name(""), &opponent.actions()));
    format!("\n{}{}", player(name, &own), opponents.collect::<String>())
}

/// Returns the modules of the opponents. Empty without opponents.
pub(super) fn modules(world: &World, robots: &[Robot<'_>]) -> String {
    let mut opponents = Opponent::all(world);
    let Some(first) = opponents.next() else { return String::new() };
    let mut text = "\n// Cells that opponents do not enter, and cells that are taken.\n".to_owned();
    if world.opponents.len() > 1 {
        for opponent in Opponent::all(world) {
            let (place, (row, col)) = (world.opponents[opponent.number], opponent.start());
            text += &format!("const int {row} = {}; const int {col} = {};\n", place.row, place.col);
        }
    }
    Direction::ALL.into_iter().for_each(|direction| text += &first.formulas(direction, robots));
    text += &first.module();
    opponents.for_each(|opponent| text += &opponent.renamed(&first));
    text
}

/// Returns the module of the turns: after each move of a robot, the opponents move one after the other,
/// and the turn counts down to ours. It is the first module, because diagrams are smaller if they split
/// the states by the turn first. Empty without opponents.
pub(super) fn turns(world: &World, robots: &[Robot<'_>]) -> String {
    let last = world.opponents.len();
    if last == 0 {
        return String::new();
    }
    let mut text = format!(
        "\n// Turn 0 is that of our side; then each opponent moves.\nmodule turns\n\n  turn : [0..{last}] init 0;\n\n"
    );
    let own: Vec<String> = robots.iter().flat_map(Robot::actions).collect();
    let others = Opponent::all(world).map(|opponent| opponent.actions());
    for (number, actions) in std::iter::once(own).chain(others).enumerate() {
        let turn = (last + 1 - number) % (last + 1);
        let next = last - number;
        for action in actions {
            text += &format!("  [{action}] turn={turn} -> (turn'={next});\n");
        }
    }
    text + "\nendmodule\n"
}

/// Returns the conditions that the opponents are in the cell that a shift leads to, one for each.
pub(super) fn at(robot: &Robot<'_>, shift: Shift) -> impl Iterator<Item = String> {
    let (r, c) = (robot.name("r"), robot.name("c"));
    Opponent::all(robot.world).map(move |opponent| opponent.is_at((&r, &c), shift))
}

/// Returns true if a result of a move is that of a slide to another cell.
pub(super) fn is_slide(shift: Shift, direction: Direction) -> bool {
    shift != direction.shift() && shift != (0, 0)
}

/// Returns the formulas that an opponent is where slides lead to. Empty without opponents.
pub(super) fn slides(robot: &Robot<'_>, shifts: impl Iterator<Item = Shift>) -> String {
    let shifts: BTreeSet<Shift> = shifts.filter(|_| !robot.world.opponents.is_empty()).collect();
    let one = |&shift: &Shift| formula(&taken(robot, shift), &at(robot, shift).collect::<Vec<_>>());
    let formulas: String = shifts.iter().map(one).collect();
    let heading = "\n// An opponent is in the cell that a slide leads to.\n";
    if formulas.is_empty() { formulas } else { heading.to_owned() + &formulas }
}

/// Returns the name of the condition that an opponent is where a slide leads to.
fn taken(robot: &Robot<'_>, (rows, cols): Shift) -> String {
    let word = |steps: isize, [plus, minus]: [&str; 2]| {
        format!("_{}", if steps > 0 { plus } else { minus }).repeat(steps.unsigned_abs())
    };
    robot.name(&format!("taken{}{}", word(rows, ["north", "south"]), word(cols, ["east", "west"])))
}

/// Returns the results of a move, each with a condition on which slides opponents block. A blocked slide
/// ends in the slippery cell, which is the first result.
pub(super) fn variants(
    robot: &Robot<'_>,
    direction: Direction,
    branches: &[Branch],
) -> Vec<(String, Vec<Branch>)> {
    let has_opponents = !robot.world.opponents.is_empty();
    let is_slide = |branch: &&Branch| has_opponents && is_slide(branch.shift, direction);
    let slides: Vec<Shift> = branches.iter().filter(is_slide).map(|branch| branch.shift).collect();
    let variant = |blocked: usize| {
        let is_blocked =
            |shift: Shift| slides.iter().position(|&s| s == shift).is_some_and(|at| blocked >> at & 1 == 1);
        let sign = |shift: Shift| if is_blocked(shift) { "" } else { "!" };
        let guard = slides.iter().map(|&shift| format!(" & {}{}", sign(shift), taken(robot, shift)));
        let (lost, mut left): (Vec<Branch>, Vec<Branch>) =
            branches.iter().cloned().partition(|branch| is_blocked(branch.shift));
        left.first_mut().into_iter().for_each(|to| to.weight += lost.iter().map(|b| b.weight).sum::<u32>());
        (guard.collect(), left)
    };
    (0..1 << slides.len()).map(variant).collect()
}
