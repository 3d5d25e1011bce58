//! Shields by value against their definition: the value after each action over all pairs of pure strategies, the actions
//! that a threshold permits, and tables that contradict themselves.

use std::fmt::Write;

use meliora::engine::Selection;
use meliora::question::shield::Threshold;
use num_traits::FromPrimitive;
use proptest::collection::vec;
use proptest::prelude::*;

use super::values::{Action, against};
use crate::common::prelude::*;

/// A game: who chooses in each state, and the choices with their successors, all equally likely.
type World = Vec<(bool, Vec<Vec<usize>>)>;

fn world() -> impl Strategy<Value = World> {
    let state = |game| (proptest::bool::weighted(game), vec(vec(0..4_usize, 1..4), 1..3));
    prop_oneof![vec(state(0.0), 4), vec(state(0.4), 4)]
}

/// A change of a table, with the fault that it is.
type Change = (&'static str, fn(&mut Shield));

/// The question: the optimum, the number of steps, and the threshold in sixths.
type Asked = (bool, Option<u64>, u8, bool);

fn asked() -> impl Strategy<Value = Asked> {
    (any::<bool>(), prop_oneof![Just(None), (1..4_u64).prop_map(Some)], 0..7_u8, any::<bool>())
}

fn text(world: &World) -> String {
    let is_game = world.iter().any(|(theirs, _)| *theirs);
    let mut commands = String::new();
    let mut players = [String::new(), String::new()];
    for (s, (theirs, choices)) in world.iter().enumerate() {
        for (a, next) in choices.iter().enumerate() {
            let branches: Vec<_> = next.iter().map(|t| format!("1/{}:(s'={t})", next.len())).collect();
            let _ = writeln!(commands, "[c{s}{a}] s={s} -> {};", branches.join("+"));
            let _ = write!(players[usize::from(*theirs)], ",[c{s}{a}]");
        }
    }
    let names = |at: usize| players[at].trim_start_matches(',').to_owned();
    let (kind, players) = match is_game {
        false => ("mdp", String::new()),
        true => ("smg", format!("player us {} endplayer player them {} endplayer", names(0), names(1))),
    };
    format!(
        "{kind} {players} module m s : [0..3]; {commands} endmodule init true endinit label \"bad\" = s=3;"
    )
}

fn shield(world: &World, (maximises, steps, sixths, relative): Asked) -> Shield {
    let property = match (maximises, steps) {
        (true, None) => "Pmax=? [ G !\"bad\" ]".to_owned(),
        (true, Some(steps)) => format!("Pmax=? [ G<={steps} !\"bad\" ]"),
        (false, None) => "Pmin=? [ F \"bad\" ]".to_owned(),
        (false, Some(steps)) => format!("Pmin=? [ F<={steps} \"bad\" ]"),
    };
    let is_game = world.iter().any(|(theirs, _)| *theirs);
    let property = if is_game { format!("<<us>> {property}") } else { property };
    let threshold = Threshold::parse(&format!("{sixths}/6"), relative).unwrap();
    let engine = Selection { storage: Storage::Explicit, reason: None, is_open: false };
    let model = Model::parse(text(world), "").unwrap();
    model.shield(&property, Some(threshold), 100, engine, Settings::default()).unwrap()
}

fn mean(next: &[usize], x: &[Ratio]) -> Ratio {
    next.iter().map(|&t| x[t].clone()).sum::<Ratio>() / Ratio::from_integer(next.len().into())
}

/// The probability of the bad event after each action.
fn literal(world: &World, steps: Option<u64>) -> Vec<Vec<Ratio>> {
    let x = match steps {
        None => {
            let p = |next: &Vec<usize>| Ratio::new(1.into(), next.len().into());
            let of = |s: usize, next: &Vec<usize>| -> Action {
                match s {
                    3 => (Ratio::one(), Vec::new()),
                    _ => (Ratio::zero(), next.iter().map(|&t| (t, p(next))).collect()),
                }
            };
            let actions: Vec<Vec<Action>> = world
                .iter()
                .enumerate()
                .map(|(s, (_, choices))| choices.iter().map(|next| of(s, next)).collect())
                .collect();
            let theirs: Vec<bool> = world.iter().map(|(theirs, _)| *theirs).collect();
            against(&actions, &theirs, false).into_iter().map(Option::unwrap).collect()
        }
        Some(steps) => (1..steps).fold(indicator(), |x, _| {
            let value = |(s, (theirs, choices)): (usize, &(bool, Vec<Vec<usize>>))| {
                let all = choices.iter().map(|next| mean(next, &x));
                match (s, theirs) {
                    (3, _) => Ratio::one(),
                    (_, true) => all.max().unwrap(),
                    (_, false) => all.min().unwrap(),
                }
            };
            world.iter().enumerate().map(value).collect()
        }),
    };
    let of_state = |(s, (_, choices)): (usize, &(bool, Vec<Vec<usize>>))| {
        let after = |next: &Vec<usize>| if s == 3 { Ratio::one() } else { mean(next, &x) };
        choices.iter().map(after).collect()
    };
    world.iter().enumerate().map(of_state).collect()
}

fn indicator() -> Vec<Ratio> {
    (0..4).map(|s| if s == 3 { Ratio::one() } else { Ratio::zero() }).collect()
}

proptest! {
    #![proptest_config(meliora_amount::random(200))]

    #[test]
    fn the_permitted_actions_are_those_of_the_definition(world in world(), asked in asked()) {
        let (maximises, steps, sixths, relative) = asked;
        let found = shield(&world, asked);
        prop_assert_eq!(found.fault(), None);
        let threshold = Ratio::new(sixths.into(), 6.into());
        for (s, all) in literal(&world, steps).into_iter().enumerate() {
            let (node, theirs) = (&found.nodes[s], world[s].0);
            prop_assert_eq!((&node.state, node.theirs), (&vec![s as i64], theirs));
            let safeties: Vec<Ratio> = all.iter().map(|bad| Ratio::one() - bad).collect();
            let best = safeties.iter().max().unwrap();
            let least = if relative { best * &threshold } else { threshold.clone() };
            for (a, safety) in safeties.iter().enumerate() {
                let action = &node.actions[a];
                prop_assert_eq!(&found.actions[action.action], &format!("c{s}{a}"));
                let [low, high] = action.value.unwrap().map(|x| Ratio::from_f64(x).unwrap());
                let value = if maximises { safety.clone() } else { Ratio::one() - safety };
                prop_assert!(low <= value && value <= high, "{s} {a}: {value} in [{low}, {high}]");
                let permitted = theirs || safety >= &least || best < &least && safety == best;
                prop_assert_eq!(action.permitted, permitted, "{} {}: {} of {}", s, a, safety, best);
            }
            prop_assert!(theirs || &safeties[node.pick] == best);
            prop_assert!(theirs || node.secure == (best >= &least));
        }
    }

    /// A table in which one action is permitted or forbidden against its values is refused.
    #[test]
    fn a_table_that_permits_other_actions_than_its_values_say_is_refused(world in world(), asked in asked()) {
        let (_, steps, sixths, relative) = asked;
        let (found, threshold) = (shield(&world, asked), Ratio::new(sixths.into(), 6.into()));
        for (s, all) in literal(&world, steps).iter().enumerate() {
            let best = Ratio::one() - all.iter().min().unwrap();
            let least = if relative { &best * &threshold } else { threshold.clone() };
            for (a, bad) in all.iter().enumerate() {
                // Bounds do not tell equal numbers apart.
                let safety = Ratio::one() - bad;
                if safety == least || best < least && safety == best && a != found.nodes[s].pick {
                    continue;
                }
                let mut changed = found.clone();
                changed.nodes[s].actions[a].permitted ^= true;
                prop_assert!(changed.fault().is_some(), "{} {}", s, a);
            }
        }
    }
}

/// A table of one fixed game, changed in one place at a time.
#[test]
fn a_table_with_impossible_values_is_refused() {
    let world: World = vec![
        (false, vec![vec![1, 3], vec![1, 1, 3]]),
        (true, vec![vec![1], vec![2]]),
        (false, vec![vec![2]]),
        (false, vec![vec![3]]),
    ];
    let found = shield(&world, (false, None, 3, false));
    assert_eq!(found.fault(), None);
    let changes: [Change; 9] = [
        ("no value between 0 and 1", |t| t.nodes[0].actions[0].value = None),
        ("no value between 0 and 1", |t| t.nodes[0].actions[0].value = Some([0.5, 0.4])),
        ("does not lie between those of its successors", |t| t.nodes[1].actions[1].value = Some([0.2, 0.2])),
        ("are said to miss the threshold", |t| t.nodes[2].secure = false),
        ("the threshold is not between 0 and 1", |t| t.rule.as_mut().unwrap().threshold = 1.5),
        ("neither sure nor impossible", |t| t.nodes[0].decided = true),
        ("another action is better", |t| t.nodes[0].pick = 0),
        ("values without a rule", |t| {
            t.rule = None;
            t.kind = "sasi".to_owned();
        }),
        ("improvements or objectives are promised", |t| t.nodes[2].ahead = None),
    ];
    for (message, change) in changes {
        let mut changed = found.clone();
        change(&mut changed);
        let fault = changed.fault().unwrap_or_else(|| panic!("{message}: no fault"));
        assert!(fault.contains(message), "{message}: {fault}");
    }
}
