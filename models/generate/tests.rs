//! Tests that compare the generated texts with the worlds that they describe.

use std::collections::BTreeSet;

use proptest::prelude::*;

use super::cells::condition;
use super::world::{CellSet, Direction, Lock, Place, World};
use super::*;
use meliora_lang as lang;
use meliora_model::Program;

fn program(model: &str) -> Program {
    let source = SourceFile::new("model", model);
    let checked = lang::load(&source, &SourceFile::new("", ""));
    let checked = checked.unwrap_or_else(|e| panic!("{e}\n{model}"));
    assert!(checked.warnings.is_empty(), "{:?}\n{model}", checked.warnings);
    checked.program
}

fn parameters() -> impl Strategy<Value = Parameters> {
    let sizes = (1usize..13, 2usize..13, 1usize..6, 0usize..4, proptest::option::of(1u32..6));
    let shares = (0usize..50, 0usize..60, 0usize..3, 0usize..3, 0usize..3, any::<bool>());
    (sizes, shares).prop_map(
        |((rows, cols, items, locked, battery), (walls, slippery, one_way, disabled, patrols, lock))| {
            let all = Parameters::new(rows, cols, items);
            let locked = locked.min((items - 2 * all.forks).saturating_sub(1));
            Parameters {
                battery,
                locked,
                walls,
                slippery,
                one_way,
                disabled,
                patrols,
                locked_charger: lock,
                ..all
            }
        },
    )
}

/// Returns the possible states after a move according to the text, from one place with no flag set.
fn by_text(
    program: &Program,
    world: &World,
    from: Place,
    direction: Direction,
) -> Option<BTreeSet<Vec<i64>>> {
    let number = |n: usize| i64::try_from(n).unwrap();
    let state: Vec<i64> = program
        .variables
        .iter()
        .map(|variable| match variable.name.as_str() {
            "r" => number(from.row),
            "c" => number(from.col),
            "b" => i64::from(world.battery.unwrap()),
            // The start of an opponent.
            name if name.starts_with("opponent") => variable.initial.unwrap(),
            _ => 0,
        })
        .collect();
    step_to(program, &state, direction.name())
}

/// Returns the possible states after a step; `None` without this action.
fn step_to(program: &Program, state: &[i64], action: &str) -> Option<BTreeSet<Vec<i64>>> {
    let steps = program.steps(state).unwrap();
    let mut named = steps.into_iter().filter(|step| step.name == action);
    let step = named.next()?;
    assert!(named.next().is_none(), "two choices for one action");
    Some(step.successors.into_iter().map(|(to, _)| to.to_vec()).collect())
}

/// Returns these states according to the world: row, column, battery, then flags in the order of
/// declaration; with opponents, the turn of the first of them, battery, flags, row, column, then the
/// rows and columns of the opponents.
fn by_world(world: &World, from: Place, direction: Direction) -> Option<BTreeSet<Vec<i64>>> {
    let locks = world.locks();
    let ends = world.outcome_among(from, direction, &world.opponents)?.into_iter().map(|branch| {
        let to = from.moved(branch.shift).unwrap();
        let place = [to.row as i64, to.col as i64];
        let charged = world.cell(to).charger && !world.is_locked(Lock::Charger);
        let battery = world.battery.map(|full| i64::from(full) - i64::from(!charged));
        let item = world.cell(to).item.filter(|&i| !world.is_locked(Lock::Item(i)));
        let opened = item.map(|i| world.items[i].opens.clone()).unwrap_or_default();
        let flags = locks.iter().map(|lock| i64::from(opened.contains(lock)));
        let rest: Vec<i64> = battery.into_iter().chain(flags).collect();
        if world.opponents.is_empty() {
            return [&place[..], &rest].concat();
        }
        let opponents = world.opponents.iter().flat_map(|place| [place.row as i64, place.col as i64]);
        let turn = vec![world.opponents.len() as i64];
        [turn, rest, place.to_vec(), opponents.collect()].concat()
    });
    Some(ends.collect())
}

/// Checks the moves of each opponent at a place, if it is free, with a robot at another place.
fn opponents_move(program: &Program, world: &World, at: Place, robot: Place) {
    let count = world.opponents.len();
    for number in 0..count {
        let mut places = world.opponents.clone();
        places[number] = at;
        let others: BTreeSet<Place> = places.iter().copied().chain([robot]).collect();
        if others.len() <= count {
            continue;
        }
        let mut state: Vec<i64> =
            program.variables.iter().map(|variable| variable.initial.unwrap()).collect();
        let (first, turn) = (state.len() - 2 * count, (count - number) as i64);
        [state[first - 2], state[first - 1]] = [robot.row as i64, robot.col as i64];
        let after = |to: Place| {
            let mut state = state.clone();
            places.iter().enumerate().for_each(|(i, place)| {
                let place = if i == number { to } else { *place };
                [state[first + 2 * i], state[first + 2 * i + 1]] = [place.row as i64, place.col as i64];
            });
            state
        };
        let with_turn = |mut state: Vec<i64>, turn: i64| {
            state[0] = turn;
            state
        };
        let suffix = if count > 1 { (number + 1).to_string() } else { String::new() };
        let now = with_turn(after(at), turn);
        let next = |to: Place| BTreeSet::from([with_turn(after(to), turn - 1)]);
        for direction in Direction::ALL {
            let to = world.opponent_step(at, direction).filter(|to| !others.contains(to));
            let action = format!("opponent_{}{suffix}", direction.name());
            assert_eq!(step_to(program, &now, &action), to.map(next));
        }
        assert_eq!(step_to(program, &now, &format!("opponent_stay{suffix}")), Some(next(at)));
        assert_eq!(step_to(program, &now, "north"), None);
    }
}

proptest! {
    #![proptest_config(meliora_amount::random(150))]

    /// Every move from every cell has the results that the world says.
    #[test]
    fn the_text_moves_as_the_world(mut parameters in parameters(), seed in any::<u64>()) {
        parameters.patrols = 0;
        let Ok(world) = random::world(&parameters, &mut Draw::new(seed)) else { return Ok(()) };
        let program = program(&write::write(&world, "test"));
        for from in world.places() {
            for direction in Direction::ALL {
                prop_assert_eq!(by_text(&program, &world, from, direction), by_world(&world, from, direction));
            }
        }
    }

    /// Robots and opponents move as the world says, and block each other's cells.
    #[test]
    fn the_text_moves_as_the_world_with_opponents(
        mut parameters in parameters(), seed in any::<u64>(), opponents in 1usize..4,
    ) {
        (parameters.patrols, parameters.opponents, parameters.battery) = (0, opponents, Some(3));
        let Ok(world) = random::world(&parameters, &mut Draw::new(seed)) else { return Ok(()) };
        let program = program(&write::write(&world, "test"));
        prop_assert_eq!(program.players.as_ref().unwrap().list.len(), 1 + opponents);
        for from in world.places().filter(|place| !world.opponents.contains(place)) {
            for direction in Direction::ALL {
                prop_assert_eq!(by_text(&program, &world, from, direction), by_world(&world, from, direction));
            }
        }
        let open: Vec<Place> = world.places().filter(|&place| world.is_open(place)).collect();
        for &at in &open {
            let robot = open[(world.index(at) + seed as usize % 5) % open.len()];
            opponents_move(&program, &world, at, robot);
        }
    }

    /// All parameters give a model with preferences or a usage error, and the same seed gives the
    /// same texts.
    #[test]
    fn the_output_loads_and_is_reproducible(
        parameters in parameters(), robots in 1usize..4, seed in any::<u64>(), wild in 0usize..40,
        opponents in 0usize..3,
    ) {
        // A small share of the cases has a parameter out of bounds.
        let locked = if wild == 0 { 9 } else { parameters.locked };
        let parameters = Parameters { robots, locked, opponents, ..parameters };
        let choices = Choices { seed, ..Choices::default() };
        let generated = match gridworld(&parameters, &choices) {
            Err(Error::Usage(message)) => { prop_assert!(!message.is_empty()); return Ok(()) }
            other => other.unwrap(),
        };
        prop_assert_eq!(&generated, &gridworld(&parameters, &choices).unwrap());
        let program = program(&generated.model);
        let preferences = SourceFile::new("preferences", generated.preferences.as_str());
        prop_assert!(lang::load_preferences(&preferences, program).is_ok());
    }

    /// A condition is satisfied in the cells of the set, and only there.
    #[test]
    fn a_condition_holds_in_the_cells_of_its_set_alone(rows in 1usize..8, cols in 1usize..8, bits in proptest::collection::vec(any::<bool>(), 64)) {
        let set = CellSet { cols, members: bits[..rows * cols].to_vec() };
        let parts = condition(&set, "r", "c");
        prop_assume!(!set.is_empty());
        let text = format!(
            "mdp module m r : [0..{}]; c : [0..{}]; [a] {} -> true; [b] true -> true; endmodule",
            rows - 1, cols - 1, parts.join(" | "),
        );
        let program = program(&text);
        for (at, &member) in set.members.iter().enumerate() {
            let state = [(at / cols) as i64, (at % cols) as i64];
            let holds = program.steps(&state).unwrap().iter().any(|step| step.name == "a");
            prop_assert_eq!(holds, member, "{}", text);
        }
    }
}

#[test]
fn the_largest_of_the_family_is_quick_and_small() {
    let generated = gridworld(&Parameters::new(128, 128, 12), &Choices::default()).unwrap();
    assert!(generated.model.len() < 200_000, "{} bytes", generated.model.len());
    assert!(generated.model.lines().all(|line| line.len() < 250));
}
