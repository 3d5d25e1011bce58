//! Quantities are facts about levels, and the same by each engine.

use meliora::model::State;
use meliora::planning::{Kind, Rank, Safety, StrategyKind};
use meliora::quantities::{Aim, Bounds, Earned, ValueOptions, Values};
use proptest::prelude::*;

use crate::random_case::{REWARDS, RandomCase, random_case};
use crate::{Analysed, settings};

/// The greatest number of improvements that is checked.
const LEVELS: usize = 2;

fn solved(of: &Analysed) -> Values {
    let mut values = Values::new(ValueOptions { levels: LEVELS, exact: false, within: None });
    let structure = &of.program.rewards[of.program.reward_structure(Some(REWARDS)).unwrap()];
    let costs = Earned { program: &of.program, structure };
    values.explore(&of.analysis, &of.program, &of.safe_states(), &costs).unwrap();
    values.solve(of.analysis.engine()).unwrap();
    values
}

fn at_least(of: &Analysed, kind: Kind, state: &State, k: usize) -> bool {
    match of.analysis.rank(kind, state).unwrap() {
        Rank::Finite(n) | Rank::AtLeast(n) => n >= k,
        Rank::Unbounded => true,
    }
}

fn overlap(what: &str, one: &Bounds, other: &Bounds) {
    let (a, b) = (one.interval, other.interval);
    assert!(a.lower <= b.upper && b.lower <= a.upper, "{what}: {a:?} {b:?}");
}

fn check(case: &RandomCase) {
    let (program, preferences) = case.load();
    let [settings, explicit, _] = settings(case);
    let analysed = |settings, safety| Analysed::new((&program, &preferences), settings, safety);
    let one = analysed(settings.clone(), case.safety);
    let other = analysed(explicit, case.safety);
    // Under `transition`, a step that may weaken may also fail.
    let strict = (case.safety == Safety::Transition).then(|| analysed(settings.clone(), Safety::Action));
    let strict = strict.as_ref().unwrap_or(&one);
    let (values, others) = (solved(&one), solved(&other));
    let mut strategy = one.strategy(StrategyKind::Spi, None);
    for state in one.safe_states() {
        let memory = strategy.start(&state).unwrap();
        let actions = strategy.explain(&state, memory).unwrap().actions;
        let (node, same) = (values.start(&state).unwrap(), others.start(&state).unwrap());
        for k in 1..=LEVELS {
            let p = values.probability(node, k);
            overlap("P", &p, &others.probability(same, k));
            let (possible, sure) =
                (at_least(&one, Kind::Spi, &state, k), at_least(strict, Kind::Sasi, &state, k));
            let p = p.interval;
            let at = format!("P_{k} in {state:?}: {p:?}");
            assert_eq!((p.lower > 0.0, p.upper > 0.0), (possible, possible), "{at}");
            assert_eq!((p.lower == 1.0, p.upper == 1.0), (sure, sure), "{at}");
            for choice in values.choices(node, k, Aim::Likely) {
                assert!(actions[choice.position].kept, "a choice that is not kept has a value in {state:?}");
            }
            let costs = [values.cost(node, k), others.cost(same, k)];
            assert_eq!(costs.each_ref().map(Option::is_some), [sure, sure], "{at}");
            if let [Some(c), Some(d)] = &costs {
                overlap("C", c, d);
            }
        }
        overlap("N", &values.number(node), &others.number(same));
    }
}

proptest! {
    #![proptest_config(crate::amount::random(100))]

    #[test]
    fn levels_say_where_probabilities_are_positive_and_one(case in random_case()) {
        check(&case);
    }
}
