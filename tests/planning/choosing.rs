//! Strategies that choose by value, as Markov chains with exact fractions: unfolded with their memory, they have the
//! values that were computed. Cases come from [`crate::planning::quantities`].

use std::collections::HashMap;

use meliora::planning::Memory;
use meliora::quantities::{Choose, Chooser, Exploration, ValuedRule};

use crate::common::prelude::*;
use crate::planning::loaded::Loaded;
use crate::planning::quantities::{chain, exact};
use crate::planning::worlds::World;

/// Returns the probability that a strategy makes its improvements from a state, and the expected
/// number of steps until the last one; 0 steps count where they are not certain.
fn evaluate<E: Engine>(strategy: &mut FiniteMemoryStrategy<E>, start: &State, k: usize) -> (Ratio, Ratio) {
    let first = (start.clone(), strategy.start(start).unwrap(), k);
    let mut nodes: Vec<(State, Memory, usize)> = vec![first.clone()];
    let mut index = HashMap::from([(first, 0)]);
    let mut rows = Vec::new();
    while rows.len() < nodes.len() {
        let (state, memory, left) = nodes[rows.len()].clone();
        let mut row = Vec::new();
        let at = strategy.explain(&state, memory).unwrap();
        if let Some(pick) = at.pick.filter(|_| left > 0) {
            assert!(at.actions[pick].permitted, "{state:?}: {} is not permitted", at.actions[pick].name);
            let step = strategy.program().exact_steps(&state).unwrap().swap_remove(pick);
            for ((to, p), shown) in step.successors.into_iter().zip(&at.actions[pick].successors) {
                let (next, improves) = strategy.after(memory, &state, &to).unwrap();
                assert_eq!((shown.next, shown.improves), (next, improves));
                let next = (to, next, left - usize::from(improves));
                let number = *index.entry(next.clone()).or_insert(nodes.len());
                if number == nodes.len() {
                    nodes.push(next);
                }
                row.push((number, p));
            }
        }
        rows.push(row);
    }
    let goal = |n: usize| nodes[n].2 == 0;
    let reaches = chain(&rows, |n| goal(n).then(Ratio::one), |_| Ratio::zero()).swap_remove(0);
    let cost = chain(&rows, |n| goal(n).then(Ratio::zero), |_| Ratio::one()).swap_remove(0);
    (reaches, cost)
}

/// Checks both strategies by value: each attains its promised value in every state.
pub(crate) fn check<E: Engine>(
    analysis: &Analysis<E>,
    world: &World,
    states: &[State],
    values: Values,
    label: &str,
) {
    let values = Arc::new(values);
    for choose in [Choose::Likely, Choose::Cheap] {
        let (aim, kind) = (choose.aim().unwrap(), choose.kind().unwrap());
        let chooser = Arc::new(Chooser::new(Arc::clone(&values), aim));
        let mut strategy = FiniteMemoryStrategy::new(analysis, &world.program, kind).unwrap();
        strategy.choose_by(Arc::clone(&chooser) as _);
        for state in states {
            let promised = chooser.attained(state).unwrap();
            let (reaches, cost) = evaluate(&mut strategy, state, promised.improvements);
            let name = choose.name();
            assert_eq!(reaches, exact(&promised.probability), "{name}, {label}, {state:?}");
            assert!(aim == Aim::Likely || promised.cost.is_some());
            if let Some(expected) = &promised.cost {
                assert_eq!(cost, exact(expected), "cost by {name}, {label}, {state:?}");
            }
        }
    }
}

#[test]
fn a_state_without_values_is_an_error() {
    let loaded = Loaded::new(
        "mdp module m x : [0..2] init 0; [] x<2 -> (x'=x+1); endmodule",
        "objective A = F x=2; empty = gain;",
    );
    let analysis = loaded.analyse(Safety::Action, None);
    let mut values = Values::new(ValueOptions { levels: 1, exact: false, within: None });
    let exploration = Exploration::new(values.options(), &analysis, &loaded.program, &Steps).unwrap();
    exploration.run(&mut values, &[vec![1]]).unwrap();
    values.solve(&*loaded.engine).unwrap();
    let kind = Choose::Likely.kind().unwrap();
    let mut strategy = FiniteMemoryStrategy::new(&analysis, &loaded.program, kind).unwrap();
    strategy.choose_by(Arc::new(Chooser::new(Arc::new(values), Aim::Likely)));
    let message = strategy.start(&[0]).unwrap_err().to_string();
    assert!(message.contains("the values of the state x=0 were not computed"), "{message}");
    assert!(strategy.start(&[1]).is_ok());
}
