//! The class-wise computation against the literal doubled MDP.

use meliora::engine::Count;
use meliora::model::preference::Empty;
use meliora::planning::levels::End;
use meliora::planning::{Analysis, Kind, Levels, Options, Rank, Safety};
use proptest::prelude::*;

use crate::generate::case;
use crate::literal::{Literal, Set};
use crate::tiny::Tiny;
use crate::{Case, EMPTIES, SAFETIES, analyse};

/// W_1, W_2, … with the empty or repeated last level, as [`Literal::levels`] has them.
fn sets(levels: &Levels<Tiny>) -> Vec<Set> {
    let set = |x: &Vec<bool>| (0..x.len()).filter(|&s| x[s]).collect::<Set>();
    let mut all: Vec<Set> = levels.found.iter().map(|l| set(&l.states)).collect();
    match &levels.end {
        Some(End::Empty) => all.push(Set::new()),
        Some(End::Unbounded(level)) => all.push(set(&level.states)),
        Some(End::Cut) | None => panic!("not finished"),
    }
    all
}

fn compare(case: &Case) {
    let engine = case.engine();
    for empty in EMPTIES {
        let preferences = case.preferences(&engine, empty);
        let literal = Literal::new(case, empty);
        for safety in SAFETIES {
            let analysis = analyse(&engine, &preferences, safety);
            for kind in [Kind::Sasi, Kind::Spi] {
                let found = sets(analysis.levels(kind));
                assert_eq!(found, literal.levels(kind, safety), "{kind} {safety} {empty}");
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
    }
}

fn classes(case: &Case) {
    let engine = case.engine();
    for empty in EMPTIES {
        let preferences = case.preferences(&engine, empty);
        let literal = Literal::new(case, empty);
        let analysis = analyse(&engine, &preferences, Safety::Action);
        let classes = analysis.classes().unwrap();
        for (s, mp) in literal.mp.iter().enumerate() {
            let class = &classes.list[classes.of(&engine, &[s as i64]).unwrap().unwrap()];
            assert_eq!(class.most_preferred.iter().collect::<Set>(), *mp);
            for (t, to) in literal.mp.iter().enumerate() {
                let weakens = literal.weakens(mp, to);
                assert_eq!(class.worse[t], weakens);
                assert_eq!(class.better[t], !weakens && literal.improves(mp, to));
            }
        }
        let total: Count = analysis.result().classes.iter().flatten().map(|c| c.states.clone()).sum();
        assert_eq!(total, Count::from(literal.mp.len()));
    }
}

fn cut(case: &Case, safety: Safety) {
    let engine = case.engine();
    let preferences = case.preferences(&engine, Empty::Bottom);
    let whole = analyse(&engine, &preferences, safety);
    let options = Options { safety, max_level: Some(1) };
    let mut cut = Analysis::new(&engine, &preferences, options);
    cut.run(&mut |_| ()).unwrap();
    for kind in [Kind::Sasi, Kind::Spi] {
        for s in 0..case.mdp.0.len() as i64 {
            let (rank, least) = (
                whole.levels(kind).rank(&engine, &[s]).unwrap(),
                cut.levels(kind).rank(&engine, &[s]).unwrap(),
            );
            match rank {
                // An empty first level ends the search before it is cut.
                Rank::Finite(0) => assert_eq!(least, Rank::Finite(0)),
                _ => assert_eq!(least, Rank::AtLeast(1)),
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1500))]

    #[test]
    fn levels_and_sizes_are_those_of_the_doubled_mdp(case in case(7)) {
        compare(&case);
    }

    #[test]
    fn classes_are_the_values_of_mp(case in case(6)) {
        classes(&case);
    }

    #[test]
    fn a_cut_search_knows_only_a_lower_bound(case in case(6)) {
        SAFETIES.iter().for_each(|&safety| cut(&case, safety));
    }
}
