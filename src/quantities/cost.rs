//! Costs of choices.

use num_traits::One;

use crate::error::Result;
use crate::model::exact::Ratio;
use crate::model::rewards::RewardStructure;
use crate::model::step::Choice;
use crate::model::{Program, State};

/// A cost for each step: what a choice costs in a state, at least 0.
///
/// For a reward structure, this is the sum of its state rewards in the state and of its transition
/// rewards for the action of the choice.
pub trait Cost {
    /// Returns the cost of a choice in a state.
    ///
    /// # Errors
    /// The cost is negative or has no value in this state.
    fn of(&self, state: &State, choice: &Choice) -> Result<Ratio>;
}

/// The number of steps: every step costs 1.
#[derive(Debug, Clone, Copy, Default)]
pub struct Steps;

impl Cost for Steps {
    fn of(&self, _: &State, _: &Choice) -> Result<Ratio> {
        Ok(Ratio::one())
    }
}

/// The rewards of a reward structure.
#[derive(Debug, Clone, Copy)]
pub struct Earned<'p> {
    /// The model.
    pub program: &'p Program,
    /// One of its reward structures.
    pub structure: &'p RewardStructure,
}

impl Cost for Earned<'_> {
    fn of(&self, state: &State, choice: &Choice) -> Result<Ratio> {
        self.program.reward(self.structure, state, choice)
    }
}
