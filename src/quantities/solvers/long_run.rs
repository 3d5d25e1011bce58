//! The long-run average reward of a Markov chain, by its bottom components.
//!
//! In a bottom component, the average is the reward until a state is entered again, divided by the number of steps until
//! then. Both come from one elimination of all other states, without subtraction.

use super::at_nodes::Vector;
use super::components;
use super::eliminate::{self, Row};
use super::solve::solved;
use crate::equations::game_graph::{GameGraph, Rewards};
use crate::equations::graph::NONE;
use crate::equations::meter::{Meter, Stop};
use crate::equations::number::{Interval, Number};
use crate::equations::part::Part;
use crate::equations::solution::Solution;
use crate::equations::system::Quantity;
use bitvec::vec::BitVec;
use meliora_base::error::{Error, Limit, Result};

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
    let exits = averages.len() as u32;
    (exits..).zip(nodes.iter_mut().filter(|node| **node == NONE)).for_each(|(next, node)| *node = next);
    let all = BitVec::repeat(true, game.states());
    let nothing = Rewards::of_set(game, &BitVec::repeat(false, game.states()));
    let part = Part { game, nodes, exits, allowed: &all, rewards: Some(&nothing) };
    let graph = part.graph(meter)?;
    let mut below = Solution::new(graph.nodes(), |node| node < exits, None, meter)?;
    (0..).zip(&averages).for_each(|(node, average)| below.set(node, average.clone()));
    let (solution, end) = solved::<N>(&graph, Quantity::Reward, Some(&below), meter)?;
    let end = if N::EXACT { Ok(end?) } else { end };
    let value = |(state, &node): (usize, &u32)| match averages.get(node as usize) {
        _ if !gains[state] => Some(N::zero()),
        Some(average) => Some(average.clone()),
        None => {
            let anything = N::rounded(Interval { lower: 0.0, upper: f64::INFINITY });
            solution.get(node).cloned().or(anything)
        }
    };
    Ok(Vector { values: part.nodes.iter().enumerate().map(value).collect(), end })
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
        for (to, weight) in game.edges(state as usize) {
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
    for (to, weight) in game.edges(last as usize) {
        if let Some(values) = values.get(place[to as usize] as usize) {
            let p = fraction(weight);
            sum = sum.plus(&p.times(&values[0]));
            steps = steps.plus(&p.times(&values[1]));
        }
    }
    others.iter().for_each(|&state| place[state as usize] = NONE);
    Ok(sum.over(&steps))
}
