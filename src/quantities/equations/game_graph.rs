//! A game as the solvers see it: numbered states with owners, their choices, and exact probabilities.

use bitvec::vec::BitVec;
use meliora_base::exact::Ratio;
use meliora_engine::explicit::weighted::Fractions;
use meliora_model::Optimum;
use num_traits::{One, Zero};

use super::choices::Choices;
use super::narrow::Narrow;

/// The extremes that the players of a game look for; without a game, ours counts alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Goal {
    /// The extreme of our states.
    pub ours: Optimum,
    /// The extreme of those of the opponent.
    pub theirs: Optimum,
}

impl Goal {
    /// All choices look for the same extreme.
    pub fn all(optimum: Optimum) -> Self {
        Goal { ours: optimum, theirs: optimum }
    }

    /// We look for an extreme against an opponent who looks for the other one.
    pub fn against(ours: Optimum) -> Self {
        Goal { ours, theirs: opposite(ours) }
    }

    /// Returns the goal with both extremes exchanged: that of 1 minus a probability.
    pub fn opposite(self) -> Self {
        Goal { ours: opposite(self.ours), theirs: opposite(self.theirs) }
    }
}

/// Returns the other extreme.
pub(crate) fn opposite(optimum: Optimum) -> Optimum {
    if optimum == Optimum::Max { Optimum::Min } else { Optimum::Max }
}

/// A game on numbered states. Without an opponent, it is an MDP.
#[derive(Debug, Default)]
pub struct GameGraph {
    /// The choices of the states, and their successors.
    pub(crate) choices: Choices,
    /// Twice the number of the probability of each successor.
    pub(crate) weights: Narrow,
    pub(crate) fractions: Fractions,
    /// The states in which the opponent chooses; `None` if every state is ours.
    pub(crate) theirs: Option<BitVec>,
}

impl GameGraph {
    /// Returns the number of states.
    pub fn states(&self) -> usize {
        self.choices.first.len() - 1
    }

    /// Returns the states in which the greatest value is looked for.
    pub(crate) fn maximisers(&self, goal: Goal) -> BitVec {
        let ours = goal.ours == Optimum::Max;
        match &self.theirs {
            Some(theirs) if goal.ours != goal.theirs => theirs.iter().map(|theirs| *theirs != ours).collect(),
            _ => BitVec::repeat(ours, self.states()),
        }
    }

    /// Returns true if all states look for the same extreme under a goal.
    pub(crate) fn is_uniform(&self, goal: Goal) -> bool {
        goal.ours == goal.theirs || self.theirs.as_ref().is_none_or(|theirs| theirs.not_any())
    }

    /// Returns the successors of a choice with the numbers of their probabilities.
    pub(crate) fn edges(&self, choice: usize) -> impl Iterator<Item = (u32, u32)> + Clone {
        let edges = self.choices.start[choice] as usize..self.choices.start[choice + 1] as usize;
        edges.map(|at| (self.choices.to[at], self.weights.get(at) / 2))
    }
}

/// The rewards of a structure in a game.
#[derive(Debug, Default)]
pub struct Rewards {
    pub(crate) fractions: Fractions,
    /// The number of what each state earns, whatever is chosen there.
    pub(crate) of_state: Narrow,
    /// The number of what each choice earns, with the reward of its state.
    pub(crate) of_choice: Narrow,
}

impl Rewards {
    /// Returns rewards that depend on states alone: 1 in some states, 0 in the others.
    pub(crate) fn of_set(game: &GameGraph, set: &BitVec) -> Self {
        let mut rewards = Rewards::default();
        let numbers = [Ratio::zero(), Ratio::one()].map(|value| rewards.fractions.number(value));
        for state in 0..game.states() {
            let number = numbers[usize::from(set[state])];
            rewards.of_state.push(number);
            game.choices.of(state as u32).for_each(|_| rewards.of_choice.push(number));
        }
        rewards
    }

    /// Returns whether a choice earns nothing.
    pub(crate) fn is_free(&self, choice: usize) -> bool {
        Zero::is_zero(self.choice(choice))
    }

    /// Returns what a choice earns, with the reward of its state.
    pub(crate) fn choice(&self, choice: usize) -> &Ratio {
        &self.fractions.list()[self.of_choice.get(choice) as usize]
    }

    /// Returns what a state earns, whatever is chosen there.
    pub(crate) fn state(&self, state: usize) -> &Ratio {
        &self.fractions.list()[self.of_state.get(state) as usize]
    }
}
