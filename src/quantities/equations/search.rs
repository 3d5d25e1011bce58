//! The search for the states that have equations, on the fly.

use super::codes::Codes;
use super::cost::Earned;
use super::meter::Meter;
use super::reached::{Growing, Reached};
use super::source::{Source, Stored, Walked};
use meliora_base::error::Result;
use meliora_engine::Engine;
use meliora_engine::membership::Membership;
use meliora_model::{Program, State};
use meliora_space::weighted::{Codec, Walker};

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
    /// Finds the states that some states reach. Cost: one evaluation of the commands per state, unless the engine keeps the
    /// probabilities of its choices.
    pub(crate) fn explored(&self, states: &[State], meter: &mut Meter<'_>) -> Result<Reached> {
        let (sets, codec) = (self.sets()?, Codec::new(self.program)?);
        match Stored::new(sets.numbers(), (self.program, &codec), self.cost.is_some()) {
            Some(mut stored) => self.grown(&mut stored, &codec, states, meter),
            None => Ok(self.walked_in(&*sets, states, meter)?.0),
        }
    }

    /// Does the same by the commands; returns the codes of the states, too.
    pub(crate) fn walked(&self, states: &[State], meter: &mut Meter<'_>) -> Result<(Reached, Codes)> {
        self.walked_in(&*self.sets()?, states, meter)
    }

    fn walked_in(
        &self,
        sets: &dyn Membership,
        states: &[State],
        meter: &mut Meter<'_>,
    ) -> Result<(Reached, Codes)> {
        let walker = Walker::new(self.program, &*self.engine.settings().sink)?;
        let mut walked = Walked::new(sets, &walker);
        let reached = self.grown(&mut walked, walker.codec(), states, meter)?;
        Ok((reached, walked.into_codes()))
    }

    fn sets(&self) -> Result<Box<dyn Membership + 'a>> {
        let (all, theirs) = (self.engine.all_states(), self.engine.theirs());
        let sets = [Some(&self.end), Some(&self.inside), Some(&all), theirs.as_ref()];
        self.engine.membership(&Vec::from_iter(sets.into_iter().flatten()))
    }

    fn grown(
        &self,
        source: &mut impl Source,
        codec: &Codec,
        states: &[State],
        meter: &mut Meter<'_>,
    ) -> Result<Reached> {
        let numbers = states.iter().map(|state| source.number(state, meter)).collect::<Result<Vec<_>>>()?;
        Growing::new(source, (codec, self.cost), (true, self.engine.is_game()), meter)?.run(source, &numbers)
    }
}
