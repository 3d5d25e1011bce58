//! The four regions of games against all memoryless strategies of both sides.

use meliora::engine::regions::{Which, holds};
use meliora::model::property::{Bound, Strategies};
use proptest::prelude::*;

use super::raw::{Enforced, Raw, Won, program};
use super::{settings, some_game, thresholds};
use crate::common::prelude::*;

/// Returns the regions as one entry per state of the raw game, whose states have these values.
fn found<E: Engine>(engine: &E, target: &Predicate, values: &[Vec<i64>]) -> Regions<Won> {
    let found = regions(engine, &engine.states_where(target).unwrap()).unwrap();
    found.map(|x| values.iter().map(|state| engine.contains(&x, state).unwrap()).collect())
}

fn expected([us, them]: [Enforced; 2]) -> Regions<Won> {
    Regions {
        pmax_one: us.surely,
        pmax_positive: us.possibly,
        pmin_one: them.surely,
        pmin_positive: them.possibly,
    }
}

fn exchanged(of: &Regions<Won>) -> Regions<Won> {
    let Regions { pmax_one, pmax_positive, pmin_one, pmin_positive } = of.clone();
    Regions {
        pmax_one: pmin_one,
        pmax_positive: pmin_positive,
        pmin_one: pmax_one,
        pmin_positive: pmax_positive,
    }
}

/// Checks that one known region decides a property only as all of them do.
fn one_region_decides<E: Engine>(engine: &E, target: &Predicate) {
    let all = regions(engine, &engine.states_where(target).unwrap()).unwrap().map(Some);
    for which in Which::ALL {
        let mut known = Regions::default();
        *known.get_mut(which) = all.get(which).clone();
        for strategies in [Strategies::Some, Strategies::All] {
            for bound in [Bound::One, Bound::Positive, Bound::BelowOne, Bound::Zero] {
                let truth = |known| holds(engine, (strategies, bound), known).unwrap();
                if let Some(found) = truth(&known) {
                    assert_eq!(Some(found), truth(&all), "{which:?} alone: {strategies:?} {bound:?}");
                }
            }
        }
    }
}

/// Checks an engine: the default coalition, the opponent's view, and both sides together.
fn check<E: Engine>(engine: &E, target: &Predicate, values: &[Vec<i64>], expected: &Regions<Won>, of: &Raw) {
    assert_eq!(found(engine, target, values), *expected, "{of:?}");
    one_region_decides(engine, target);
    let other = engine.with_coalition(&[false, true]).unwrap();
    assert_eq!(found(&other, target, values), exchanged(expected), "the opponent of {of:?}");
    let again = other.with_coalition(&[true, false]).unwrap();
    assert_eq!(found(&again, target, values), *expected, "back to {of:?}");
}

fn explicit(program: &Arc<Program>) -> ExplicitEngine {
    ExplicitEngine::new(Arc::clone(program), settings(Scope::All, Thresholds::default())).unwrap()
}

fn symbolic(program: &Arc<Program>, thresholds: Thresholds) -> SymbolicEngine {
    SymbolicEngine::new(Arc::clone(program), settings(Scope::All, thresholds)).unwrap()
}

fn target_of(program: &Program) -> Predicate {
    program.predicate(program.labels[0].1)
}

/// Checks a game with both engines, written in two ways.
fn check_all(raw: &Raw, target: &[bool], thresholds: &[Thresholds]) {
    let expected = expected(raw.enforced(target));
    let inside: Vec<usize> = (0..raw.len()).filter(|&s| target[s]).collect();
    let any = |of: &dyn Fn(usize) -> String| inside.iter().map(|&s| of(s)).collect::<Vec<_>>().join(" | ");
    let label = |condition: String| format!("label \"t\" = false | {condition};\n");
    let one = raw.text() + &label(any(&|s| format!("x={s}")));
    let two = raw.labelled_text() + &label(any(&|s| format!("(h={} & l={})", s / 2, s % 2)));
    let values = |of: fn(usize) -> Vec<i64>| (0..raw.len()).map(of).collect::<Vec<_>>();
    let plain = values(|s| vec![s as i64]);
    let split = values(|s| vec![(s / 2) as i64, (s % 2) as i64]);
    for (text, values) in [(one, plain), (two, split)] {
        let text = if inside.is_empty() { text.replace("false | ", "false") } else { text };
        let program = Arc::new(program(&text));
        let target = target_of(&program);
        check(&explicit(&program), &target, &values, &expected, raw);
        for &thresholds in thresholds {
            check(&symbolic(&program, thresholds), &target, &values, &expected, raw);
        }
    }
}

/// Every game of two states and a target: one or two choices per state, each with any successors.
#[test]
fn all_games_of_a_family() {
    let sets: Vec<Vec<usize>> =
        (1..8usize).map(|bits| (0..3).filter(|s| bits >> s & 1 == 1).collect()).collect();
    let mut options: Vec<Vec<Vec<usize>>> = sets.iter().map(|set| vec![set.clone()]).collect();
    for (i, a) in sets.iter().enumerate() {
        options.extend(sets[i + 1..].iter().map(|b| vec![a.clone(), b.clone()]));
    }
    let mut number = 0usize;
    for first in &options {
        for second in &options {
            for owners in 0..4 {
                let theirs = vec![owners & 1 == 1, owners & 2 == 2, false];
                let raw = Raw { theirs, choices: vec![first.clone(), second.clone(), vec![vec![2]]] };
                number += 1;
                if !takes(number) {
                    continue;
                }
                let symbolic = if number.is_multiple_of(16) { &thresholds()[..1] } else { &[][..] };
                check_all(&raw, &[false, false, true], symbolic);
            }
        }
    }
    assert_eq!(number, 28 * 28 * 4);
}

proptest! {
    #![proptest_config(meliora_amount::random(400))]

    #[test]
    fn random_games(raw in some_game(6, 3), bits in 0u8..64) {
        let target: Vec<bool> = (0..raw.len()).map(|s| bits >> s & 1 == 1).collect();
        check_all(&raw, &target, &thresholds());
    }
}

/// A settings that no test changes.
#[test]
fn the_other_side_of_an_mdp_has_no_states() {
    let program = program("mdp module m x : [0..1]; [] true -> (x'=1-x); endmodule");
    let engine = ExplicitEngine::new(Arc::new(program), Settings::default()).unwrap();
    assert!(engine.theirs().is_none() && engine.exchanged().unwrap().is_none());
    assert!(engine.with_coalition(&[true]).is_err() && engine.player_states().is_empty());
}

#[test]
fn a_repeated_search_finds_the_same() {
    let text = "smg player us [up], [down] endplayer player them [stay], [go] endplayer
        module m t : [0..1]; x : [0..7];
            [up] t=0 & x<7 -> 0.5: (x'=x+1) & (t'=1) + 0.5: (t'=1);
            [down] t=0 & x>0 -> (x'=x-1) & (t'=1);
            [stay] t=1 -> (t'=0);
            [go] t=1 & x>4 -> (x'=x-1) & (t'=0);
        endmodule
        label \"t\" = x=4;";
    let program = Arc::new(program(text));
    let engine = symbolic(&program, Thresholds::default());
    let target = engine.states_where(&target_of(&program)).unwrap();
    let reached = |engine: &SymbolicEngine| {
        let found = engine.can_reach(&target, &engine.all_choices(), &[]).unwrap();
        engine.count(&found).unwrap()
    };
    let first = reached(&engine);
    assert_eq!(reached(&engine), first);
    // The other side has results of its own.
    let other = engine.with_coalition(&[false, true]).unwrap();
    assert_ne!(reached(&other), first);
}
