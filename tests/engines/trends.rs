//! Engines with only the falling or the rising edges, against the reference with only these edges.

use std::cmp::Ordering;

use meliora::advanced::symbolic::Side;
use meliora::model::trend::{Digit, Trend};
use proptest::prelude::*;

use crate::common::agreement;
use crate::common::brute::Set;
use crate::common::prelude::*;
use crate::engines::explicit::numbers;

/// Returns whether the first variable of the order in which two states differ says that a step has the trend.
fn has_trend(program: &Program, order: &[Digit], trend: Trend, s: &State, t: &State) -> bool {
    let value = |d: &Digit, s: &State| {
        let turned = d.reversed != (d.steady && trend == Trend::Rising);
        let own = s[d.variable.index()];
        let place = d
            .values
            .iter()
            .position(|&offset| offset as i64 == own - program.variables[d.variable.index()].low);
        let number = place.map_or(own, |place| place as i64);
        if turned { -number } else { number }
    };
    let of = |s: &State| order.iter().map(|digit| value(digit, s)).collect::<Vec<_>>();
    let wanted = match trend {
        Trend::Falling => Ordering::Less,
        Trend::Rising => Ordering::Greater,
    };
    of(t).cmp(&of(s)) == wanted
}

/// The reference with only the edges of a trend.
fn reference(program: &Program, order: &[Digit], trend: Trend) -> Brute {
    let mut brute = Brute::new(program, Settings::default().scope).unwrap();
    let states = brute.states.clone();
    for pair in &mut brute.pairs {
        let from = &states[pair.state];
        pair.successors.retain(|&to| has_trend(program, order, trend, from, &states[to]));
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
    #![proptest_config(meliora_amount::random(150))]

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
        let key = |digit: &Digit| keys.get(digit.variable.index()).copied().unwrap_or_default();
        let mut order: Vec<Digit> = program.variable_ids().map(Digit::natural).collect();
        order.sort_by_key(key);
        for digit in &mut order {
            (digit.reversed, digit.steady) = (key(digit) & 1 == 1, key(digit) & 2 == 2);
            let own = &program.variables[digit.variable.index()];
            let mut values = Vec::from_iter(0..=own.high.abs_diff(own.low));
            values.sort_by_key(|value| (value + 1) * u64::from(key(digit) >> 3) % 7);
            if key(digit) & 4 == 4 {
                digit.values = values;
            }
        }
        for relations_per_bit in [0, Thresholds::default().relations_per_bit] {
            let thresholds = Thresholds { relations_per_bit, ..Thresholds::default() };
            let settings = Settings { memory: 64 << 20, thresholds, ..Settings::default() };
            let whole = SymbolicEngine::new(program.clone(), settings).unwrap();
            for trend in Trend::ALL {
                let brute = reference(&program, &order, trend);
                let engine = whole.with_trend(&order, trend).unwrap();
                agreement::check(&engine, &program, &brute, &predicates);
                for predicate in predicates {
                    let found = engine.reached_from(&whole.states_where(&program.predicate(predicate)).unwrap()).unwrap();
                    let expected = reached(&brute, &brute.states_where(&program, predicate));
                    prop_assert_eq!(whole.list_states(&found, usize::MAX).unwrap(), listed(&brute, &expected));
                }
            }
        }
    }

    #[test]
    fn digits_that_few_transitions_make_greater_come_first(of in numbers(160)) {
        let program = Arc::new(random_program(&of, false));
        let settings = Settings { memory: 64 << 20, ..Settings::default() };
        let order = SymbolicEngine::new(program.clone(), settings).unwrap().falling_order(Side::We).unwrap();
        prop_assert_eq!(order.len(), program.variables.len());
        // The numbers of transitions that keep the digits before, and make this one greater or smaller.
        let key = |before: &[Digit], digit: &Digit| {
            let digit = Digit { steady: false, ..digit.clone() };
            let [falling, rising] = Trend::ALL.map(|trend| {
                let of = |order: &[Digit]| {
                    let brute = reference(&program, order, trend);
                    brute.count_transitions(&brute.all_choices(), &brute.all_states())
                };
                of(&[before, std::slice::from_ref(&digit)].concat()) - of(before)
            });
            (rising, std::cmp::Reverse(falling))
        };
        for (at, digit) in order.iter().enumerate() {
            let own = key(&order[..at], digit);
            prop_assert!(own.0 <= own.1.0, "{:?}", order);
            prop_assert_eq!(digit.steady, own.0 == 0, "{:?}", order);
            for other in &order[at..] {
                let turned = Digit { reversed: !other.reversed, ..other.clone() };
                prop_assert!(own <= key(&order[..at], other).min(key(&order[..at], &turned)), "{:?}", order);
            }
        }
    }
}
