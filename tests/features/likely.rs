//! Objectives that are achieved with the greatest probability: value iteration from below, written by
//! the book, finds the same number for the best strategy and for the one that is taken.

use std::collections::BTreeMap;
use std::sync::Arc;

use meliora::engine::Engine;
use meliora::model::State;
use meliora::planning::{FiniteMemoryStrategy, StrategyKind};
use meliora::quantities::{Achiever, ValuedRule};
use proptest::test_runner::Config;

use crate::Analysed;
use crate::coverage::draw_until;
use crate::random_case::{RandomCase, random_case};

type Numbers = BTreeMap<State, f64>;

/// Iterates v(s) = max over some actions of the mean of v, from 0, with 1 where the objective is sure.
fn iterated(of: &Analysed, sure: &[State], takes: &dyn Fn(&State, usize) -> bool) -> Numbers {
    let states = of.safe_states();
    let mut values: Numbers = states.iter().map(|s| (s.clone(), f64::from(sure.contains(s)))).collect();
    let open: Vec<&State> = states.iter().filter(|s| !sure.contains(s)).collect();
    loop {
        let mut change: f64 = 0.0;
        for &state in &open {
            let steps = of.program.steps(state).unwrap().into_iter().enumerate();
            let taken = steps.filter(|(action, _)| takes(state, *action));
            // Actions that may leave the requirements have a successor without a value.
            let mean = |step: &[(State, f64)]| step.iter().map(|(to, p)| Some(p * values.get(to)?)).sum();
            let best = taken.filter_map(|(_, step)| mean(&step.successors)).fold(0.0, f64::max);
            change = change.max(best - values[state]);
            values.insert(state.clone(), best);
        }
        if change < 1e-13 {
            return values;
        }
    }
}

/// Checks all states; returns how many have a probability between 0 and 1.
fn check(of: &Analysed, objective: usize) -> usize {
    let states = of.safe_states();
    let mut strategy = of.strategy(StrategyKind::Achieve, Some(objective));
    let rule = Achiever::compute(&of.analysis, &of.program, &states, strategy.objectives()).unwrap();
    let rule = Arc::new(rule);
    strategy.choose_by(Arc::clone(&rule) as _);
    let almost_sure = &of.analysis.outcomes().unwrap().get(objective).unwrap().almost_sure;
    let sure: Vec<State> =
        states.iter().filter(|s| of.analysis.engine().contains(almost_sure, s).unwrap()).cloned().collect();
    let picks = picks(&mut strategy, &states);
    let best = iterated(of, &sure, &|_, _| true);
    let own = iterated(of, &sure, &|state, action| picks.get(state) == Some(&action));
    let mut between = 0;
    for state in &states {
        let interval = rule.attained(state).unwrap().probability.interval;
        for found in [best[state], own[state]] {
            let is_near = interval.lower <= found + 1e-6 && found <= interval.upper + 1e-6;
            assert!(is_near, "{found} is not {interval:?} in {state:?}");
        }
        between += usize::from(interval.lower > 0.0 && interval.upper < 1.0);
    }
    between
}

/// The actions that the strategy takes, by their positions.
fn picks(strategy: &mut FiniteMemoryStrategy, states: &[State]) -> BTreeMap<State, usize> {
    let mut picks = BTreeMap::new();
    for state in states {
        let memory = strategy.start(state).unwrap();
        let at = strategy.explain(state, memory).unwrap();
        let permitted: Vec<usize> = (0..at.actions.len()).filter(|&a| at.actions[a].permitted).collect();
        assert!(memory.pursuit.is_some() || permitted == Vec::from_iter(at.pick), "{at:?}");
        picks.extend(at.pick.map(|pick| (state.clone(), pick)));
    }
    picks
}

#[test]
fn an_objective_that_is_not_sure_is_achieved_with_the_greatest_probability() {
    let config = Config { source_file: Some(file!()), ..crate::amount::random(200) };
    let enough = |between: &usize| *between > 40;
    draw_until(&config, &random_case(), enough, |case: RandomCase, between| {
        let [symbolic, explicit, _] = Analysed::all(&case);
        for of in [symbolic, explicit] {
            for objective in 0..of.analysis.preferences().objectives.len() {
                *between += check(&of, objective);
            }
        }
    });
}
