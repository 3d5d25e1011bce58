//! The search for the states that have equations, on the fly.

use super::cost::Earned;
use super::meter::Meter;
use super::reached::{Growing, Reached};
use meliora_base::error::Result;
use meliora_engine::Engine;
use meliora_model::{Program, State};
use meliora_space::weighted::Walker;

/// A search for the states that have equations.
pub(crate) struct Search<'a, E: Engine> {
    pub(crate) engine: &'a E,
    pub(crate) program: &'a Program,
    /// The states where the path ends: with the probability 1, or without further reward.
    pub(crate) end: E::States,
    /// The states in which the path continues; it fails where it leaves them.
    pub(crate) inside: E::States,
    pub(crate) cost: Option<Earned<'a>>,
}

impl<'a, E: Engine> Search<'a, E> {
    /// Compiles the program.
    pub(crate) fn walker(&self) -> Result<Walker<'a>> {
        Walker::new(self.program, &*self.engine.settings().sink)
    }

    /// Finds the states that some states reach.
    pub(crate) fn explored(
        &self,
        states: &[State],
        walker: &Walker<'_>,
        meter: &mut Meter<'_>,
    ) -> Result<Reached> {
        let all = self.engine.all_states();
        let theirs = self.engine.theirs();
        let sets = [Some(&self.end), Some(&self.inside), Some(&all), theirs.as_ref()];
        let sets: Vec<&E::States> = sets.into_iter().flatten().collect();
        let parts = self.engine.membership(&sets)?;
        let is_game = theirs.is_some();
        Growing::new(&*parts, is_game, walker.codec(), self.cost, meter)?.run(states, &mut *walker.walk())
    }
}
