//! The opponent of a game: who chooses in a state, and which choices it takes in simulated runs.

use crate::strategies::explain::{Action, Explanation};
use crate::strategies::finite_memory::FiniteMemoryStrategy;
use meliora_base::error::Result;
use meliora_base::random::Draw;
use meliora_engine::Engine;
use meliora_model::fault;
use meliora_model::players::Owner;
use meliora_model::step::Choice;

meliora_base::named! {
    /// The choices that the opponent takes in simulated runs.
    #[derive(Default)]
    pub enum Opponent {
        /// All enabled choices, each with the same probability.
        #[default]
        Random,
        /// The choice that keeps the next improvement, or the pursued objective, away longest; against a
        /// strategy that chooses by value, the choice that leaves the least of the value.
        Worst,
    }
}

impl Opponent {
    /// Returns the position of the action that the opponent takes in one of its states; `None` if the
    /// run ends there.
    pub(crate) fn pick(self, at: &Explanation, draw: &mut Draw) -> Option<usize> {
        if at.worst.is_none() && at.is_over() || at.actions.is_empty() {
            return None;
        }
        match self {
            Opponent::Random => Some(draw.below(at.actions.len())),
            Opponent::Worst if at.worst.is_some() => at.worst,
            Opponent::Worst => {
                let distance = |action: &Action| action.distance.unwrap_or(usize::MAX);
                let greatest = at.actions.iter().map(distance).max();
                at.actions.iter().position(|action| Some(distance(action)) == greatest)
            }
        }
    }
}

impl<E: Engine> FiniteMemoryStrategy<E> {
    /// Returns the player who chooses in a state; `None` if the model is not a game, and in deadlocks,
    /// which belong to nobody.
    ///
    /// # Errors
    /// A command has no meaning in the state.
    pub fn owner(&self, state: &[i64]) -> Result<Option<Owner>> {
        if self.program.players.is_none() {
            return Ok(None);
        }
        let choices = self.program.choices(state).map_err(|f| fault::error(&self.program, &f, state))?;
        Ok(choices.first().and_then(|(choice, _)| self.owner_of(choice)))
    }

    /// Returns the player to whom a choice belongs.
    pub(crate) fn owner_of(&self, choice: &Choice) -> Option<Owner> {
        let player = self.program.player_of_choice(choice)?;
        Some(Owner { player, ours: *self.whole.coalition().get(player)? })
    }
}
