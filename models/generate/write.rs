//! The writer of a world as a model in PRISM's language.

use std::collections::{BTreeMap, BTreeSet};

use super::cells::{condition, wrap};
use super::opponent;
use super::picture;
use super::world::{Branch, CellSet, Direction, Effect, Lock, Patrol, Place, Shift, World};

/// Returns the text of the model; `title` is its first comment line.
pub(super) fn write(world: &World, title: &str) -> String {
    let robots: Vec<Robot> = (0..world.starts.len()).map(|number| Robot::new(world, number)).collect();
    let kind = if world.opponents.is_empty() { "mdp" } else { "smg" };
    let mut text = format!("// {title}\n{}\n{kind}\n", picture::comment(world));
    text += &opponent::players(world, &robots);
    text += &opponent::turns(world, &robots);
    if let Some(full) = world.battery {
        text += &format!("\nconst int full = {full};  // the battery\n");
    }
    if let [first, _, ..] = &robots[..] {
        let starts = robots.iter().map(|r| {
            format!("const int row{0} = {1}; const int col{0} = {2};\n", r.suffix, r.start.row, r.start.col)
        });
        text += &format!("\n// Where the robots start.\n{}", starts.collect::<String>());
        text += &first.shared_locks(robots.len());
    }
    if let Some(robot) = robots.first() {
        let moves: Vec<Move> = Direction::ALL.into_iter().map(|d| Move::new(robot, d)).collect();
        text += &opponent::slides(robot, moves.iter().flat_map(Move::slides));
        moves.iter().for_each(|m| text += &m.formulas());
        text += &robot.module(&moves);
        robots.iter().skip(1).for_each(|other| text += &other.renamed(robot));
    }
    text += &opponent::modules(world, &robots);
    for (number, patrol) in world.patrols.iter().enumerate() {
        text += &patrol_module(number + 1, patrol, &robots);
    }
    text + &labels(world, &robots)
}

/// A robot with its names, which end in its number if there are several robots.
pub(super) struct Robot<'a> {
    pub(super) world: &'a World,
    start: Place,
    suffix: String,
    others: usize,
}

impl<'a> Robot<'a> {
    fn new(world: &'a World, number: usize) -> Self {
        let others = world.starts.len() - 1;
        let suffix = if others == 0 { String::new() } else { (number + 1).to_string() };
        Robot { world, start: world.starts[number], suffix, others }
    }

    pub(super) fn name(&self, stem: &str) -> String {
        format!("{stem}{}", self.suffix)
    }

    pub(super) fn actions(&self) -> Vec<String> {
        Direction::ALL.iter().map(|direction| self.name(direction.name())).collect()
    }

    /// Returns the flag that this robot sets when it opens a lock.
    fn flag(&self, lock: Lock) -> String {
        self.name(&self.lock(lock))
    }

    /// Returns the name of the condition that a lock is open, no matter which robot opened it.
    fn lock(&self, lock: Lock) -> String {
        match lock {
            Lock::Item(i) => format!("open_{}", self.world.items[i].name),
            Lock::Charger => "open_charger".to_owned(),
        }
    }

    fn place(&self, place: Place) -> String {
        format!("{}={} & {}={}", self.name("r"), place.row, self.name("c"), place.col)
    }

    fn condition(&self, set: &CellSet) -> Vec<String> {
        condition(set, &self.name("r"), &self.name("c"))
    }

    /// Returns formulas for several robots: a lock is open if one of them has opened it.
    fn shared_locks(&self, robots: usize) -> String {
        let formula = |lock: Lock| {
            let name = self.lock(lock);
            let flags: Vec<String> = (1..=robots).map(|n| format!("{name}{n}")).collect();
            format!("formula {name} = {};\n", flags.join(" | "))
        };
        let formulas: String = self.world.locks().into_iter().map(formula).collect();
        let heading = "\n// What a robot has made available, all may use.\n";
        if formulas.is_empty() { formulas } else { heading.to_owned() + &formulas }
    }

    fn variables(&self) -> String {
        let (r, c, world) = (self.name("r"), self.name("c"), self.world);
        let starts = match self.others {
            0 => (self.start.row.to_string(), self.start.col.to_string()),
            _ => (self.name("row"), self.name("col")),
        };
        let mut place = format!("  {r} : [0..{}] init {};  // row\n", world.rows - 1, starts.0);
        place += &format!("  {c} : [0..{}] init {};  // column\n", world.cols - 1, starts.1);
        let battery = format!("  {} : [0..full] init full;  // battery\n", self.name("b"));
        let mut rest = if world.battery.is_some() { battery } else { String::new() };
        for lock in world.locks() {
            rest += &format!("  {} : bool init false;\n", self.flag(lock));
        }
        // Among opponents, diagrams are smallest if the positions of all robots follow each other.
        if world.opponents.is_empty() { place + &rest } else { rest + &place }
    }

    fn module(&self, moves: &[Move]) -> String {
        let mut text = format!("\nmodule {}\n\n{}", self.name("robot"), self.variables());
        moves.iter().for_each(|m| text += &m.commands());
        if self.world.battery.is_some() {
            text += "\n  // An empty battery: no move leads anywhere.\n";
            for direction in Direction::ALL {
                text += &format!("  [{}] {}=0 -> true;\n", self.name(direction.name()), self.name("b"));
            }
        }
        text + "\nendmodule\n"
    }

    /// Returns the module of a further robot: that of the first with the names of the two robots
    /// exchanged.
    fn renamed(&self, first: &Robot) -> String {
        let battery = self.world.battery.map(|_| "b");
        let stems =
            ["r", "c", "row", "col"].into_iter().chain(battery).chain(Direction::ALL.map(Direction::name));
        let mut pairs: Vec<String> =
            stems.map(|stem| format!("{}={}", first.name(stem), self.name(stem))).collect();
        for lock in self.world.locks() {
            let (one, other) = (first.flag(lock), self.flag(lock));
            // Flags are exchanged in both directions: a robot must see the flags that the first one
            // has set.
            pairs.extend([format!("{one}={other}"), format!("{other}={one}")]);
        }
        let lines: Vec<String> = pairs.chunks(8).map(|chunk| chunk.join(", ")).collect();
        let (name, list) = (self.name("robot"), lines.join(",\n  "));
        format!("\nmodule {name} = {} [{list}] endmodule\n", first.name("robot"))
    }
}

/// The named conditions and the commands for one direction.
struct Move<'a> {
    robot: &'a Robot<'a>,
    direction: Direction,
    disabled: CellSet,
    cases: Vec<Case>,
}

/// A group of cells from which the move has the same results.
struct Case {
    name: String,
    branches: Vec<Branch>,
    origins: CellSet,
}

impl<'a> Move<'a> {
    fn new(robot: &'a Robot<'a>, direction: Direction) -> Self {
        let world = robot.world;
        let disabled = CellSet::new(world, |place| world.cell(place).disabled.contains(direction));
        let mut slips = 0;
        let case = |(branches, origins): (Vec<Branch>, CellSet)| {
            let name = describe(world, direction, &branches, &mut slips);
            Case { name: robot.name(&format!("{}_{name}", direction.name())), branches, origins }
        };
        let mut cases: Vec<Case> = world.groups(direction).into_iter().map(case).collect();
        cases.sort_by_key(|case| order(&case.branches, direction));
        Move { robot, direction, disabled, cases }
    }

    fn action(&self) -> String {
        self.robot.name(self.direction.name())
    }

    /// Returns the name of the condition that an obstacle is in the way, if there are obstacles.
    fn met(&self) -> Option<String> {
        let World { patrols, opponents, .. } = self.robot.world;
        (!patrols.is_empty() || !opponents.is_empty()).then(|| self.named("met"))
    }

    /// Returns the shifts of all slides to another cell.
    fn slides(&self) -> impl Iterator<Item = Shift> {
        let branches = self.cases.iter().flat_map(|case| &case.branches);
        branches.map(|branch| branch.shift).filter(|&shift| opponent::is_slide(shift, self.direction))
    }

    fn named(&self, what: &str) -> String {
        self.robot.name(&format!("{}_{what}", self.direction.name()))
    }

    fn formulas(&self) -> String {
        let mut text = format!("\n// Moves {}.\n", self.direction.name());
        let mut named: Vec<String> = Vec::new();
        if !self.disabled.is_empty() {
            let name = self.named("disabled");
            text += &formula(&name, &self.robot.condition(&self.disabled));
            named.push(name);
        }
        let is_free = |case: &&Case| order(&case.branches, self.direction) == 0;
        for case in self.cases.iter().filter(|case| !is_free(case)) {
            text += &formula(&case.name, &self.robot.condition(&case.origins));
            named.push(case.name.clone());
        }
        // The plain step covers the cells of no other case.
        if let Some(case) = self.cases.iter().find(is_free) {
            let rest = if named.is_empty() { "false".to_owned() } else { named.join(" | ") };
            text += &wrap(&format!("formula {} = !({rest});\n", case.name), "    ");
        }
        if let Some(met) = self.met() {
            text += &self.met_formula(&met);
        }
        text
    }

    /// Returns the formula that a moving obstacle or an opponent is in the cell in which the move would end.
    fn met_formula(&self, name: &str) -> String {
        let (rows, cols) = self.direction.shift();
        let world = self.robot.world;
        let meets = world.patrols.iter().enumerate().filter_map(|(number, patrol)| {
            let (fixed, along) = if patrol.is_vertical() {
                (("c", patrol.from.col, cols, world.cols), ("r", rows))
            } else {
                (("r", patrol.from.row, rows, world.rows), ("c", cols))
            };
            // The coordinate across the track must be one step away from it, or on it for a move
            // along it.
            let across = fixed.1.checked_add_signed(-fixed.2).filter(|&across| across < fixed.3)?;
            let position = offset(&self.robot.name(along.0), along.1);
            Some(format!("{}={across} & p{}={position}", self.robot.name(fixed.0), number + 1))
        });
        let opponents = opponent::at(self.robot, self.direction.shift());
        formula(name, &meets.chain(opponents).collect::<Vec<_>>())
    }

    fn commands(&self) -> String {
        let battery =
            self.robot.world.battery.map(|_| format!("{}>0 & ", self.robot.name("b"))).unwrap_or_default();
        let unmet = self.met().map(|met| format!("!{met} & ")).unwrap_or_default();
        let mut text = "\n".to_owned();
        for case in &self.cases {
            for (guard, branches) in opponent::variants(self.robot, self.direction, &case.branches) {
                let updates = self.branches(&branches);
                text += &format!("  [{}] {battery}{unmet}{}{guard} ->{updates};\n", self.action(), case.name);
            }
        }
        if let Some(met) = self.met() {
            text += &self.met_commands(&format!("{battery}{met}"));
        }
        text
    }

    /// Returns the commands of a move into an obstacle: the robot stays, as in front of a
    /// wall.
    fn met_commands(&self, guard: &str) -> String {
        let world = self.robot.world;
        let has_opponents = !world.opponents.is_empty();
        let near = |place: Place| {
            let to = place.moved(self.direction.shift());
            to.is_some_and(|to| world.patrols.iter().any(|patrol| patrol.covers(to)))
                || (has_opponents && world.opponent_step(place, self.direction).is_some())
        };
        let mut stays: BTreeMap<Option<Effect>, Vec<Place>> = BTreeMap::new();
        for place in world.places().filter(|&p| near(p) && !world.cell(p).disabled.contains(self.direction)) {
            stays.entry(world.effect(place)).or_default().push(place);
        }
        let plain = stays.len() == 1 && self.disabled.is_empty();
        let mut text = String::new();
        for (effect, places) in stays {
            let set = CellSet::new(world, |place| places.contains(&place));
            let here = || format!(" & ({})", self.robot.condition(&set).join(" | "));
            let here = if plain { String::new() } else { here() };
            let branch = Branch { shift: (0, 0), effect, weight: 1 };
            let command = format!("  [{}] {guard}{here} ->{};", self.action(), self.branches(&[branch]));
            text += &format!("{}\n", wrap(&command, "        "));
        }
        text
    }

    fn branches(&self, branches: &[Branch]) -> String {
        let total: u32 = branches.iter().map(|branch| branch.weight).sum();
        match branches {
            [only] => format!(" {}", self.updates(only)),
            _ => {
                let branch = |b: &Branch| format!("\n        {}/{total} : {}", b.weight, self.updates(b));
                branches.iter().map(branch).collect::<Vec<_>>().join(" +")
            }
        }
    }

    fn updates(&self, branch: &Branch) -> String {
        let robot = self.robot;
        let mut updates = Vec::new();
        for (stem, by) in [("r", branch.shift.0), ("c", branch.shift.1)] {
            if by != 0 {
                let name = robot.name(stem);
                updates.push(format!("({name}'={})", offset(&name, by)));
            }
        }
        let effect = branch.effect.as_ref();
        if robot.world.battery.is_some() {
            let b = robot.name("b");
            let charges = effect.is_some_and(|e| e.charges);
            updates.push(match (charges, robot.world.is_locked(Lock::Charger)) {
                (false, _) => format!("({b}'={b}-1)"),
                (true, false) => format!("({b}'=full)"),
                (true, true) => format!("({b}'={} ? full : {b}-1)", robot.lock(Lock::Charger)),
            });
        }
        for &lock in effect.map(|e| &e.opens[..]).unwrap_or_default() {
            let flag = robot.flag(lock);
            updates.push(match effect.and_then(|e| e.needs) {
                None => format!("({flag}'=true)"),
                Some(item) => format!("({flag}'={flag} | {})", robot.lock(Lock::Item(item))),
            });
        }
        if updates.is_empty() { "true".to_owned() } else { updates.join(" & ") }
    }
}

/// Returns a short name for the results of a move.
fn describe(world: &World, direction: Direction, branches: &[Branch], slips: &mut usize) -> String {
    let [only] = branches else {
        *slips += 1;
        return format!("slip_{slips}");
    };
    let moved = only.shift == direction.shift();
    match (&only.effect, moved) {
        (None, true) => "free".to_owned(),
        (None, false) => "blocked".to_owned(),
        (Some(effect), _) => format!("{}_{}", if moved { "to" } else { "at" }, places_with(world, effect)),
    }
}

/// Returns the position of a case: the plain step, then blocked moves, then moves with effects,
/// then slips.
fn order(branches: &[Branch], direction: Direction) -> usize {
    match branches {
        [only] if only.effect.is_none() => usize::from(only.shift != direction.shift()),
        [only] => 2 + usize::from(only.shift != direction.shift()),
        _ => 4,
    }
}

/// Returns the names of the items (or the charger) with an effect: `A_B`.
fn places_with(world: &World, effect: &Effect) -> String {
    let has = |place: &Place| world.effect(*place).as_ref() == Some(effect);
    let name = |place: Place| {
        let item = world.cell(place).item.filter(|_| !effect.opens.is_empty());
        let charger = effect.charges.then(|| "charger".to_owned());
        item.map(|i| world.items[i].name.to_string()).into_iter().chain(charger).collect::<Vec<_>>().join("_")
    };
    let names: BTreeSet<String> = world.places().filter(has).map(name).collect();
    names.into_iter().collect::<Vec<_>>().join("_")
}

pub(super) fn offset(name: &str, by: isize) -> String {
    match by {
        0 => name.to_owned(),
        _ => format!("{name}{by:+}"),
    }
}

pub(super) fn formula(name: &str, parts: &[String]) -> String {
    let all = if parts.is_empty() { "false".to_owned() } else { parts.join(" | ") };
    let line = format!("formula {name} = {all};\n");
    if line.len() <= 100 {
        return line;
    }
    let wrapped: Vec<String> = parts.iter().map(|part| wrap(part, "        ")).collect();
    format!("formula {name} =\n    {};\n", wrapped.join("\n  | "))
}

/// Returns the module of a moving obstacle, which takes a random step whenever a robot acts.
fn patrol_module(number: usize, patrol: &Patrol, robots: &[Robot]) -> String {
    let p = format!("p{number}");
    let Patrol { from, to } = patrol;
    let (first, last, track) = match patrol.is_vertical() {
        true => (from.row, to.row, format!("row of an obstacle in column {}", from.col)),
        false => (from.col, to.col, format!("column of an obstacle in row {}", from.row)),
    };
    let mut text =
        format!("\nmodule patrol{number}\n\n  {p} : [{first}..{last}] init {first};  // the {track}\n\n");
    for robot in robots {
        for direction in Direction::ALL {
            let action = robot.name(direction.name());
            text += &format!(
                "  [{action}] true -> 1/2 : ({p}'=max({p}-1,{first})) + 1/2 : ({p}'=min({p}+1,{last}));\n"
            );
        }
    }
    text + "\nendmodule\n"
}

/// Returns the labels: `"at_A"` says that a robot is in the cell of the available item A.
fn labels(world: &World, robots: &[Robot]) -> String {
    let mut text = "\n".to_owned();
    for (number, item) in world.items.iter().enumerate() {
        let cells = || world.places().filter(|&place| world.cell(place).item == Some(number));
        let places = robots.iter().flat_map(|robot| cells().map(|place| robot.place(place)));
        let places = places.collect::<Vec<_>>().join(" | ");
        let condition = match robots.first().filter(|_| world.is_locked(Lock::Item(number))) {
            Some(robot) => format!("({places}) & {}", robot.lock(Lock::Item(number))),
            None => places,
        };
        text += &wrap(&format!("label \"at_{}\" = {condition};\n", item.name), "    ");
    }
    text
}
