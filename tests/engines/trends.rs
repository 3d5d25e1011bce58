//! Engines with only the falling or the rising edges, against the reference with only these edges.

use std::cmp::Ordering;
use std::sync::Arc;

use meliora::advanced::symbolic::Thresholds;
use meliora::engine::{Engine, Settings, SymbolicEngine};
use meliora::model::trend::Trend;
use meliora::model::{Program, State, VarId};
use proptest::prelude::*;

use crate::common::agreement;
use crate::common::brute::{Brute, Set};
use crate::common::random_program::{random_predicate, random_program};
use crate::explicit::numbers;

/// Compares two states by the first variable of the order in which they differ.
fn compare(order: &[VarId], s: &State, t: &State) -> Ordering {
    let of = |s: &State| order.iter().map(|v| s[v.index()]).collect::<Vec<_>>();
    of(s).cmp(&of(t))
}

fn has_trend(order: &[VarId], trend: Trend, s: &State, t: &State) -> bool {
    let wanted = match trend {
        Trend::Falling => Ordering::Less,
        Trend::Rising => Ordering::Greater,
    };
    compare(order, t, s) == wanted
}

/// The reference with only the edges of a trend.
fn reference(program: &Program, order: &[VarId], trend: Trend) -> Brute {
    let mut brute = Brute::new(program, Settings::default().scope).unwrap();
    let states = brute.states.clone();
    for pair in &mut brute.pairs {
        let from = &states[pair.state];
        pair.successors.retain(|&to| has_trend(order, trend, from, &states[to]));
    }
    brute
}

/// The states that are reached from X.
fn reached(brute: &Brute, x: &Set) -> Set {
    let next = x | &brute.post(&brute.choices_in(&brute.all_choices(), x));
    if next == *x { next } else { reached(brute, &next) }
}

fn listed(brute: &Brute, x: &Set) -> Vec<State> {
    x.iter().map(|&s| brute.states[s].clone()).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(150))]

    #[test]
    fn every_operation_is_that_of_the_reference_with_fewer_edges(
        of in numbers(160),
        first in numbers(20),
        second in numbers(20),
        keys in proptest::collection::vec(any::<u16>(), 16),
    ) {
        let mut program = random_program(&of, false);
        let predicates = [random_predicate(&mut program, &first), random_predicate(&mut program, &second)];
        let program = Arc::new(program);
        let mut order: Vec<VarId> = program.variable_ids().collect();
        order.sort_by_key(|v| keys.get(v.index()).copied());
        for relations_per_bit in [0, Thresholds::default().relations_per_bit] {
            let thresholds = Thresholds { relations_per_bit, ..Thresholds::default() };
            let settings = Settings { memory: 64 << 20, thresholds, ..Settings::default() };
            let whole = SymbolicEngine::new(program.clone(), settings).unwrap();
            for trend in Trend::ALL {
                let brute = reference(&program, &order, trend);
                let engine = whole.with_trend(&order, trend).unwrap();
                agreement::check(&engine, &program, &brute, &predicates);
                for predicate in predicates {
                    let found = engine.reached_from(&whole.states_where(predicate).unwrap()).unwrap();
                    let expected = reached(&brute, &brute.states_where(&program, predicate));
                    prop_assert_eq!(whole.list_states(&found, usize::MAX).unwrap(), listed(&brute, &expected));
                }
            }
        }
    }

    #[test]
    fn variables_that_drift_most_come_first(of in numbers(160)) {
        let program = Arc::new(random_program(&of, false));
        let settings = Settings { memory: 64 << 20, ..Settings::default() };
        let order = SymbolicEngine::new(program.clone(), settings).unwrap().by_drift().unwrap();
        let drift = |v: &VarId| {
            let [falling, rising] = Trend::ALL.map(|trend| {
                let brute = reference(&program, &[*v], trend);
                brute.count_transitions(&brute.all_choices(), &brute.all_states())
            });
            falling.abs_diff(rising)
        };
        prop_assert!(order.is_sorted_by_key(|v| std::cmp::Reverse(drift(v))), "{:?}", order);
        prop_assert_eq!(order.len(), program.variables.len());
    }
}
