//! The four regions against all memoryless strategies, each an induced Markov chain.

use meliora::engine::regions::{Which, deciding, holds};
use meliora::model::property::{Bound, Strategies};
use proptest::prelude::*;

use crate::common::graphs::{bottom_components, reached};
use crate::common::prelude::*;
use crate::planning::generate::case;
use crate::planning::literal::Set;
use crate::planning::tiny::{Mdp, Tiny};
use crate::planning::{Case, analyse};

/// All ways to fix one choice per state.
fn memoryless(mdp: &Mdp) -> Vec<Vec<Vec<usize>>> {
    let mut chains: Vec<Vec<Vec<usize>>> = vec![Vec::new()];
    for choices in &mdp.0 {
        let longer = |chain: &Vec<Vec<usize>>| {
            let chain = chain.clone();
            choices.iter().map(move |c| chain.iter().cloned().chain([c.clone()]).collect::<Vec<_>>())
        };
        chains = chains.iter().flat_map(longer).collect();
    }
    chains
}

/// (Pmax = 1, Pmax > 0, Pmin = 1, Pmin > 0) by enumeration.
fn enumerated(mdp: &Mdp, target: &Set) -> [Set; 4] {
    let mut result = [Set::new(), Set::new(), (0..mdp.0.len()).collect(), (0..mdp.0.len()).collect()];
    for chain in memoryless(mdp) {
        for s in 0..mdp.0.len() {
            let possible = reached(&chain, s, target).iter().any(|t| target.contains(t));
            let ends = bottom_components(&chain, s, target);
            let sure = ends.iter().all(|end| end.iter().any(|t| target.contains(t)));
            for (region, holds) in result[..2].iter_mut().zip([sure, possible]) {
                if holds {
                    region.insert(s);
                }
            }
            for (region, holds) in result[2..].iter_mut().zip([sure, possible]) {
                if !holds {
                    region.remove(&s);
                }
            }
        }
    }
    result
}

fn compare(case: &Case) {
    let engine = case.engine();
    let preferences = case.preferences(&engine, Empty::Bottom);
    let analysis = analyse(&engine, &preferences, Safety::Action);
    for (i, target) in case.targets.iter().enumerate() {
        let expected = enumerated(&case.mdp, &target.iter().copied().collect());
        let r = regions(&*engine, &engine.states_where(&engine.target(i)).unwrap()).unwrap();
        assert_eq!([&r.pmax_one, &r.pmax_positive, &r.pmin_one, &r.pmin_positive], expected.each_ref());
        each_region_alone(&engine, engine.states_where(&engine.target(i)).unwrap(), &r);
        known_regions_decide_what_all_of_them_do(&*engine, &r);
        let outcome = analysis.outcomes().unwrap().get(i).unwrap();
        assert_eq!([&outcome.almost_sure, &outcome.positive], [&expected[0], &expected[1]]);
    }
}

/// A region that is asked for first is the same as the one among all.
fn each_region_alone(engine: &Tiny, target: Set, all: &Regions<Set>) {
    for which in Which::ALL {
        let mut search = RegionSearch::of_target(engine, target.clone());
        let order = search.order(&[which]);
        assert_eq!(order.last(), Some(&which));
        assert_eq!(search.region(which).unwrap(), *all.get(which), "{which:?}");
        let known: Vec<Which> = Which::ALL.into_iter().filter(|w| search.known().get(*w).is_some()).collect();
        assert!(known.len() == order.len() && known.iter().all(|which| order.contains(which)), "{order:?}");
    }
}

/// Some regions decide a property as all four do, or not at all; the one that it needs decides it.
fn known_regions_decide_what_all_of_them_do<E: Engine>(engine: &E, all: &Regions<E::States>) {
    for strategies in [Strategies::All, Strategies::Some] {
        for bound in [Bound::One, Bound::Positive, Bound::BelowOne, Bound::Zero] {
            let question = (strategies, bound);
            let whole = holds(engine, question, &all.clone().map(Some)).unwrap();
            assert!(whole.is_some());
            for subset in 0..16 {
                let mut known = Regions::default();
                for (at, which) in Which::ALL.into_iter().enumerate() {
                    *known.get_mut(which) = (subset >> at & 1 == 1).then(|| all.get(which).clone());
                }
                let is_needed = known.get(deciding(strategies, bound).0).is_some();
                let found = holds(engine, question, &known).unwrap();
                assert!(
                    found == whole || (found.is_none() && !is_needed),
                    "{question:?} {subset}: {found:?}"
                );
            }
        }
    }
}

proptest! {
    #![proptest_config(crate::common::amount::random(600))]

    #[test]
    fn regions_are_those_of_all_memoryless_strategies(case in case(5)) {
        compare(&case);
    }
}

#[test]
fn a_smaller_target_starts_from_the_larger_ones_region() {
    // 0 -> {1, 2}; 1 and 2 are sinks: the larger target is sure, the smaller is not.
    let mdp = Mdp::new(vec![vec![vec![1, 2]], vec![], vec![]]);
    let case = Case { mdp, targets: vec![vec![1], vec![1, 2], vec![1], vec![]], statements: Vec::new() };
    compare(&case);
}
