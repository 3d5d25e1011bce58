//! The expected reward of all steps, in all states of an arena.

use bitvec::vec::BitVec;

use super::at_nodes::Vector;
use super::back::Back;
use super::components;
use super::reaching::Reaching;
use super::sides::Sides;
use crate::equations::arena::{Arena, Goal, Rewards};
use crate::equations::meter::Meter;
use crate::equations::number::Number;
use crate::equations::part::Part;
use crate::equations::system::Quantity;
use meliora_base::error::Result;
use meliora_base::exact::Ratio;
use meliora_model::Optimum;

/// Computes the values if all choices look for the same extreme.
///
/// The greatest value is infinite where an end component with a positive reward can be reached, and 0 where no positive
/// reward can. The least one is the reward until a state from which some strategy earns nothing more: infinite where
/// none reaches these surely.
///
/// # Errors
/// A limit is reached before anything is known.
pub(crate) fn values_of<N: Number>(
    arena: &Arena<'_>,
    rewards: &Rewards,
    optimum: Optimum,
    meter: &mut Meter<'_>,
) -> Result<Vector<N>> {
    let all = BitVec::repeat(true, arena.choices.start.len() - 1);
    if optimum == Optimum::Min {
        return least(arena, (rewards, &BitVec::repeat(false, arena.states())), &all, meter);
    }
    let found = components::end_components(&arena.choices, meter)?;
    let (mut earning, mut recurring) = ([(); 2]).map(|()| BitVec::repeat(false, arena.states())).into();
    for state in 0..arena.states() {
        for choice in arena.choices.of(state as u32).filter(|&choice| !rewards.is_free(choice)) {
            earning.set(state, true);
            if found.inside[choice] {
                recurring.set(state, true);
            }
        }
    }
    let every = BitVec::repeat(true, arena.states());
    let sides = Sides::new(&arena.choices, &every, &all, meter)?;
    let (infinite, earning) = (sides.positive(&recurring, &every), sides.positive(&earning, &every));
    let (end, inside) = (!earning, !infinite);
    Part::between(arena, (&end, &inside), &all, Some(rewards)).values(Quantity::Reward, meter)
}

/// Computes the values of a game, in which rewards end in the states of a set.
///
/// A strategy of the maximisers is changed only where another choice is better. If none is, its values against the best
/// answers solve the equations of both sides, whose least solution is the value. All numbers are fractions.
///
/// # Errors
/// A limit is reached before anything is known.
pub(crate) fn in_game<N: Number>(
    arena: &Arena<'_>,
    (rewards, target): (&Rewards, &BitVec),
    goal: Goal,
    meter: &mut Meter<'_>,
) -> Result<Vector<N>> {
    let back: Back<'_, Ratio> = Back::new(arena, goal, Some(rewards), meter)?;
    let mut strategy = BitVec::repeat(true, arena.choices.start.len() - 1);
    let take = |strategy: &mut BitVec, state: usize, pick: usize| {
        arena.choices.of(state as u32).for_each(|choice| strategy.set(choice, choice == pick));
    };
    let leaders: Vec<usize> = back.maximisers.iter_ones().filter(|&state| !target[state]).collect();
    for &state in &leaders {
        take(&mut strategy, state, arena.choices.of(state as u32).start);
    }
    loop {
        let found: Vector<Ratio> = least(arena, (rewards, target), &strategy, meter)?;
        found.end?;
        let finite: BitVec = found.values.iter().map(Option::is_some).collect();
        let x: Vec<Ratio> = found.values.iter().map(|x| x.clone().unwrap_or_default()).collect();
        let mut changed = false;
        for &state in leaders.iter().filter(|&&state| finite[state]) {
            meter.step()?;
            let is_finite =
                |choice: usize| arena.choices.successors(choice).iter().all(|&to| finite[to as usize]);
            let better = arena.choices.of(state as u32).find(|&choice| !is_finite(choice));
            let better = better.or_else(|| {
                let all = arena.choices.of(state as u32).map(|choice| (back.mean(choice, &x), choice));
                let best = all.reduce(|best, other| if other.0 > best.0 { other } else { best });
                best.filter(|(value, _)| *value > x[state]).map(|(_, choice)| choice)
            });
            if let Some(choice) = better {
                take(&mut strategy, state, choice);
                changed = true;
            }
        }
        if !changed {
            let values = found.values.iter().map(|x| x.as_ref().map(N::of)).collect();
            return Ok(Vector { values, end: Ok(()) });
        }
    }
}

/// Computes the least values among some choices, where rewards end in the states of a set.
fn least<N: Number>(
    arena: &Arena<'_>,
    (rewards, target): (&Rewards, &BitVec),
    allowed: &BitVec,
    meter: &mut Meter<'_>,
) -> Result<Vector<N>> {
    let target = resting(arena, (rewards, target), allowed);
    let left = BitVec::repeat(true, arena.states());
    let goal = Goal::all(Optimum::Min);
    let reaching = Reaching { arena, target: &target, left: &left, rewards: Some(rewards), goal };
    reaching.alone(Optimum::Min, allowed, meter)
}

/// Returns the greatest set of states that are in a set, or that some choices without rewards need not leave.
fn resting(arena: &Arena<'_>, (rewards, target): (&Rewards, &BitVec), allowed: &BitVec) -> BitVec {
    let mut rest = BitVec::repeat(true, arena.states());
    loop {
        let stays = |choice: usize, rest: &BitVec| {
            allowed[choice]
                && rewards.is_free(choice)
                && arena.choices.successors(choice).iter().all(|&to| rest[to as usize])
        };
        let lost: Vec<usize> = rest
            .iter_ones()
            .filter(|&state| !target[state])
            .filter(|&state| !arena.choices.of(state as u32).any(|choice| stays(choice, &rest)))
            .collect();
        if lost.is_empty() {
            return rest;
        }
        lost.into_iter().for_each(|state| rest.set(state, false));
    }
}
