//! Classes, levels and strategies against the literal definitions: the doubled MDP, and the chains that
//! strategies induce.

use meliora::planning::levels::End;
use proptest::prelude::*;

use crate::common::prelude::*;
use crate::planning::generate::case;
use crate::planning::literal::{Literal, Set};
use crate::planning::tiny::Tiny;
use crate::planning::{Case, analyse, strategies};

/// W_1, W_2, … with the empty or repeated last level, as [`Literal::levels`] has them.
fn sets(levels: &Levels<Tiny>) -> Vec<Set> {
    let mut all: Vec<Set> = levels.found.iter().map(|l| l.states.clone()).collect();
    match &levels.end {
        Some(End::Empty) => all.push(Set::new()),
        Some(End::Unbounded(level)) => all.push(level.states.clone()),
        Some(End::Cut) | None => panic!("not finished"),
    }
    all
}

fn check(case: &Case) {
    let engine = case.engine();
    for &empty in Empty::ALL {
        let preferences = case.preferences(&engine, empty);
        let literal = Literal::new(case, empty);
        for &safety in Safety::ALL {
            let analysis = analyse(&engine, &preferences, safety);
            check_classes(&analysis, &literal);
            check_levels(&analysis, &literal);
            strategies::check(&analysis, &literal);
            if safety.never_weakens() {
                strategies::check_kept(&analysis, &literal);
            }
            check_cut(&engine, &preferences, &analysis);
        }
    }
}

fn check_levels(analysis: &Analysis<Tiny>, literal: &Literal<'_>) {
    let safety = analysis.options().safety;
    for kind in [Kind::Sasi, Kind::Spi] {
        let found = sets(analysis.levels(kind));
        assert_eq!(found, literal.levels(kind, safety), "{kind} {safety}");
    }
    let unbounded = analysis.levels(Kind::Sasi).unbounded().is_some();
    assert!(!unbounded || safety == Safety::Transition, "unbounded SASI under {safety}");
    if safety == Safety::Prefix {
        assert_eq!(analysis.result().improvement, None);
    } else {
        let sizes = analysis.result().improvement.clone().unwrap();
        let (states, transitions) = literal.sizes(safety);
        assert_eq!((sizes.states, sizes.transitions.clone()), (states.into(), transitions.into()));
        let total = analysis.result().counts.clone().unwrap().transitions;
        assert_eq!(sizes.dropped, total - sizes.transitions / 2u32);
    }
}

fn check_classes(analysis: &Analysis<Tiny>, literal: &Literal<'_>) {
    let (engine, classes) = (analysis.engine(), analysis.classes().unwrap());
    for (s, mp) in literal.mp.iter().enumerate() {
        let class = &classes.list[classes.of(engine, &[s as i64]).unwrap().unwrap()];
        assert_eq!(class.most_preferred.iter().collect::<Set>(), *mp);
        for (t, to) in literal.mp.iter().enumerate() {
            let weakens = literal.weakens(mp, to);
            assert_eq!(class.worse.contains(&t), weakens);
            assert_eq!(class.better.contains(&t), !weakens && literal.improves(mp, to));
        }
    }
    let total: Count = analysis.result().classes.iter().flatten().map(|c| c.states.clone()).sum();
    assert_eq!(total, Count::from(literal.mp.len()));
}

/// Checks that a search that is cut after the first level knows a lower bound.
fn check_cut(engine: &Arc<Tiny>, preferences: &Arc<Preferences>, whole: &Analysis<Tiny>) {
    let options = Options { max_level: Some(1), ..whole.options() };
    let cut = finished(engine, preferences, options);
    for kind in [Kind::Sasi, Kind::Spi] {
        for s in engine.all_states().into_iter().map(|s| s as i64) {
            let [rank, least] =
                [whole, &cut].map(|analysis| analysis.levels(kind).rank(&**engine, &[s]).unwrap());
            match rank {
                // An empty first level ends the search before it is cut.
                Rank::Finite(0) => assert_eq!(least, Rank::Finite(0)),
                _ => assert_eq!(least, Rank::AtLeast(1)),
            }
        }
    }
}

proptest! {
    #![proptest_config(crate::common::amount::random(800))]

    #[test]
    fn classes_levels_and_strategies_are_those_of_the_definitions(case in case(7)) {
        check(&case);
    }
}
