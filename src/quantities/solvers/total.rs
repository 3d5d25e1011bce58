//! The expected reward of all steps, in all states of an arena whose choices look for the same extreme.

use bitvec::vec::BitVec;

use super::components;
use super::reaching::{Reaching, Vector};
use super::sides::Sides;
use crate::equations::arena::{Arena, Goal, Rewards};
use crate::equations::meter::Meter;
use crate::equations::number::Number;
use crate::equations::part::Part;
use crate::equations::system::Quantity;
use meliora_base::error::Result;
use meliora_model::Optimum;

/// Computes the values.
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
    let choices = arena.choices.start.len() - 1;
    let all = BitVec::repeat(true, choices);
    if optimum == Optimum::Min {
        let target = resting(arena, rewards);
        let left = BitVec::repeat(true, arena.states());
        let goal = Goal::all(optimum);
        let reaching = Reaching { arena, target: &target, left: &left, rewards: Some(rewards), goal };
        return reaching.alone(optimum, &all, meter);
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

/// Returns the greatest set of states that choices without rewards need not leave.
fn resting(arena: &Arena<'_>, rewards: &Rewards) -> BitVec {
    let mut rest = BitVec::repeat(true, arena.states());
    loop {
        let stays = |choice: usize, rest: &BitVec| {
            rewards.is_free(choice) && arena.choices.successors(choice).iter().all(|&to| rest[to as usize])
        };
        let lost: Vec<usize> = rest
            .iter_ones()
            .filter(|&state| !arena.choices.of(state as u32).any(|choice| stays(choice, &rest)))
            .collect();
        if lost.is_empty() {
            return rest;
        }
        lost.into_iter().for_each(|state| rest.set(state, false));
    }
}
