//! The long-run average reward of a Markov chain, by its bottom components.
//!
//! In a bottom component, the average is the reward until a state is entered again, divided by the number of steps until
//! then. Both come from one elimination of all other states, without subtraction.

use super::components;
use super::eliminate::{self, Row};
use super::reaching::{Vector, value_at};
use crate::equations::game_graph::{GameGraph, Goal, Rewards};
use crate::equations::graph::NONE;
use crate::equations::meter::{Meter, Stop};
use crate::equations::number::Number;
use crate::equations::solution::{Rest, Solution};
use crate::equations::system::{Quantity, Sets, System};
use bitvec::vec::BitVec;
use meliora_base::error::{Error, Limit, Result};
use meliora_model::Optimum;

/// Computes the averages of all states.
///
/// # Errors
/// Some state has several choices; a limit is reached before anything is known.
pub(crate) fn values<N: Number>(
    game: &GameGraph,
    rewards: &Rewards,
    meter: &mut Meter<'_>,
) -> Result<Vector<N>> {
    if game.choices.start.len() != game.choices.first.len() {
        let what = "averages over the long run are supported for models of type dtmc: some states here have several choices";
        return Err(Error::Usage(what.to_owned()));
    }
    meter.take(game.states() * (components::SEARCH + 12))?;
    let found = game.choices.components(0..game.states() as u32, |_| true);
    let mut nodes = vec![NONE; game.states()];
    let (mut averages, mut place): (Vec<N>, _) = (Vec::new(), vec![NONE; game.states()]);
    // The states from which a component with another average than 0 is reachable: the others have exactly 0. A
    // component comes after those that it can reach.
    let mut gains = BitVec::<usize>::repeat(false, game.states());
    for component in found.iter() {
        let has_gain = if is_bottom(game, component, &mut nodes, averages.len() as u32) {
            averages.push(average::<N>(game, rewards, component, &mut place, meter)?);
            averages.last().is_some_and(|average| !average.is_zero())
        } else {
            let gains =
                |&state: &u32| game.choices.successors(state as usize).iter().any(|&to| gains[to as usize]);
            component.iter().any(gains)
        };
        component.iter().for_each(|&state| gains.set(state as usize, has_gain));
    }
    let nowhere = BitVec::repeat(false, game.states());
    let mut averaged = Solution::new(
        game.states(),
        |state| nodes[state as usize] != NONE,
        Rest::ones(game.states(), &|_| false),
        meter,
    )?;
    for (state, &node) in (0..).zip(&nodes).filter(|(_, node)| **node != NONE) {
        averaged.set(state, averages[node as usize].clone());
    }
    let sets = Sets {
        open: (0..game.states()).map(|state| nodes[state] == NONE && gains[state]).collect(),
        ones: nowhere,
        permitted: BitVec::repeat(true, game.choices_in_all()),
    };
    let fractions: Vec<N> = game.fractions().iter().map(N::of).collect();
    let asked = (Quantity::Reward, Goal::all(Optimum::Max));
    let system =
        System { closed: Some(&averaged), ..System::of_sets((game, &sets), asked, None, &fractions) };
    let mut solution = system.start(meter)?;
    let end = system.solve(&mut solution, meter);
    let end = if N::EXACT { Ok(end?) } else { end };
    let value = |(state, &node): (usize, &u32)| match averages.get(node as usize) {
        _ if !gains[state] => Some(N::zero()),
        Some(average) => Some(average.clone()),
        None => value_at(&solution, state as u32, f64::INFINITY),
    };
    Ok(Vector { values: nodes.iter().enumerate().map(value).collect(), end })
}

/// Returns whether a component is never left; then its states get the number `exit`.
pub(crate) fn is_bottom(game: &GameGraph, component: &[u32], nodes: &mut [u32], exit: u32) -> bool {
    component.iter().for_each(|&state| nodes[state as usize] = exit);
    let stays =
        |&state: &u32| game.choices.successors(state as usize).iter().all(|&to| nodes[to as usize] == exit);
    let is_bottom = component.iter().all(stays);
    if !is_bottom {
        component.iter().for_each(|&state| nodes[state as usize] = NONE);
    }
    is_bottom
}

/// Returns the average reward of a bottom component.
fn average<N: Number>(
    game: &GameGraph,
    rewards: &Rewards,
    component: &[u32],
    place: &mut [u32],
    meter: &mut Meter<'_>,
) -> Result<N> {
    let Some((&last, others)) = component.split_last() else { return Ok(N::zero()) };
    others.iter().zip(0..).for_each(|(&state, at)| place[state as usize] = at);
    let fraction = |weight: u32| N::of(&game.fractions.list()[weight as usize]);
    let gain = |state: u32| N::of(rewards.choice(state as usize));
    let row = |&state: &u32| {
        let mut row = Row { edges: Vec::new(), escape: N::zero(), constant: vec![gain(state), N::one()] };
        for (to, weight) in game.outcomes(state as usize) {
            match place[to as usize] {
                _ if to == state => {}
                NONE => row.escape = row.escape.plus(&fraction(weight)),
                at => row.edges.push((at, fraction(weight))),
            }
        }
        row.edges.sort_unstable_by_key(|edge| edge.0);
        row
    };
    let mut left = usize::MAX;
    let values = eliminate::solve(others.iter().map(row).collect(), &mut left, meter);
    let values = values.map_err(|stop| match stop {
        Stop::Limit(error) => error,
        _ => Limit::Size { what: "the average of a component has no value".to_owned() }.into(),
    })?;
    let [mut sum, mut steps] = [gain(last), N::one()];
    for (to, weight) in game.outcomes(last as usize) {
        if let Some(values) = values.get(place[to as usize] as usize) {
            let p = fraction(weight);
            sum = sum.plus(&p.times(&values[0]));
            steps = steps.plus(&p.times(&values[1]));
        }
    }
    others.iter().for_each(|&state| place[state as usize] = NONE);
    Ok(sum.over(&steps))
}
