//! The expected reward of all steps, in all states of a game of one player.

use bitvec::vec::BitVec;

use super::at_nodes::Vector;
use super::components;
use super::reaching::{Collected, Reaching};
use super::sides::Sides;
use crate::equations::game_graph::{GameGraph, Goal, Rewards};
use crate::equations::meter::Meter;
use crate::equations::number::Number;
use crate::equations::part::Part;
use crate::equations::system::Quantity;
use meliora_base::error::Result;
use meliora_model::Optimum;

/// Rewards of all steps, in a game of one player.
pub(crate) struct Total<'a> {
    pub(crate) game: &'a GameGraph,
    pub(crate) rewards: &'a Rewards,
    /// The states after which nothing is earned.
    pub(crate) target: &'a BitVec,
    /// The choices that may be taken.
    pub(crate) allowed: &'a BitVec,
}

impl Total<'_> {
    /// Computes the values of all states.
    ///
    /// The greatest value is infinite where an end component with a positive reward can be reached, and 0 where no
    /// positive reward can. The least one is the reward until a state from which some strategy earns nothing more:
    /// infinite where none reaches these surely.
    ///
    /// # Errors
    /// A limit is reached before anything is known.
    pub(crate) fn values<N: Number>(&self, optimum: Optimum, meter: &mut Meter<'_>) -> Result<Vector<N>> {
        match optimum {
            Optimum::Max => self.greatest(meter),
            Optimum::Min => self.least(meter),
        }
    }

    fn greatest<N: Number>(&self, meter: &mut Meter<'_>) -> Result<Vector<N>> {
        let Total { game, rewards, target, allowed } = *self;
        let mut open: Vec<bool> = allowed.iter().by_vals().collect();
        for state in target.iter_ones() {
            open[game.choices.of(state as u32)].fill(false);
        }
        let recurs = components::end_components_of(&game.choices, open.clone(), meter)?.inside;
        let [mut earning, mut recurring] = [(); 2].map(|()| BitVec::repeat(false, game.states()));
        for state in 0..game.states() {
            let mut earns = game.choices.of(state as u32).filter(|&at| open[at] && !rewards.is_free(at));
            earning.set(state, earns.clone().next().is_some());
            recurring.set(state, earns.any(|choice| recurs[choice]));
        }
        let (every, left) = (BitVec::repeat(true, game.states()), !target.clone());
        let sides = Sides::new(&game.choices, &every, allowed, meter)?;
        let (infinite, earning) = (sides.positive(&recurring, &left), sides.positive(&earning, &left));
        let (end, inside) = (!earning, !infinite);
        Part::between(game, (&end, &inside), allowed, Some(rewards)).values(Quantity::Reward, meter)
    }

    fn least<N: Number>(&self, meter: &mut Meter<'_>) -> Result<Vector<N>> {
        let Total { game, rewards, allowed, .. } = *self;
        let (target, left) = (self.resting(), BitVec::repeat(true, game.states()));
        let goal = Goal::all(Optimum::Min);
        let collected = Collected::Until(rewards);
        Reaching { game, target: &target, left: &left, collected, goal }.alone(Optimum::Min, allowed, meter)
    }

    /// Returns the greatest set of states that are in the target, or that some choices without rewards need not leave.
    fn resting(&self) -> BitVec {
        let Total { game, rewards, target, allowed } = *self;
        let mut rest = BitVec::repeat(true, game.states());
        loop {
            let stays = |choice: usize, rest: &BitVec| {
                allowed[choice]
                    && rewards.is_free(choice)
                    && game.choices.successors(choice).iter().all(|&to| rest[to as usize])
            };
            let lost: Vec<usize> = rest
                .iter_ones()
                .filter(|&state| !target[state])
                .filter(|&state| !game.choices.of(state as u32).any(|choice| stays(choice, &rest)))
                .collect();
            if lost.is_empty() {
                return rest;
            }
            lost.into_iter().for_each(|state| rest.set(state, false));
        }
    }
}
