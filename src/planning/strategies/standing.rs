//! The standing of states under a strategy: their class and their rank, which can be remembered.

use std::sync::{Mutex, PoisonError};

use ahash::AHashMap;

use super::finite_memory::FiniteMemoryStrategy;
use crate::analysis::levels::Rank;
use meliora_base::error::Result;
use meliora_engine::Engine;
use meliora_model::State;
use meliora_model::preference::ObjectiveSet;

/// The class and the rank of a state.
#[derive(Debug, Clone, Copy)]
struct Standing {
    /// The position of the class; `None` for unsafe states and outside the scope.
    class: Option<usize>,
    rank: Rank,
}

/// The standings of states that were asked for.
#[derive(Default)]
pub(crate) struct Standings(Mutex<AHashMap<State, Standing>>);

impl<E: Engine> FiniteMemoryStrategy<E> {
    /// Remembers the class and the rank of each state from now on, or forgets them: a state is a successor of
    /// many others, and to find its class takes a membership test per class.
    pub(crate) fn remember(&mut self, on: bool) {
        self.standings = on.then(Standings::default);
    }

    /// Returns MP(s); empty outside the scope.
    ///
    /// # Errors
    /// The errors of [`Engine::contains`].
    pub fn most_preferred(&self, state: &[i64]) -> Result<ObjectiveSet> {
        let class = self.class_of(state)?;
        Ok(class.map_or_else(ObjectiveSet::new, |class| self.classes.list[class].most_preferred.clone()))
    }

    /// Returns whether no strategy keeps the requirements from a state of the scope: the state
    /// belongs to no class.
    ///
    /// # Errors
    /// The errors of [`Engine::contains`].
    pub fn is_unsafe(&self, state: &[i64]) -> Result<bool> {
        Ok(self.class_of(state)?.is_none())
    }

    /// Returns rank(s) = max { k : s ∈ W_k }; see [`Levels::rank`](crate::analysis::levels::Levels::rank).
    ///
    /// # Errors
    /// The errors of [`Engine::contains`].
    pub fn rank(&self, state: &[i64]) -> Result<Rank> {
        match &self.standings {
            None => self.levels.rank(&*self.engine, state),
            Some(known) => Ok(self.standing(known, state)?.rank),
        }
    }

    /// Returns the position of the class of a state; `None` for unsafe states and outside the scope.
    pub(crate) fn class_of(&self, state: &[i64]) -> Result<Option<usize>> {
        match &self.standings {
            None => self.classes.of(&*self.engine, state),
            Some(known) => Ok(self.standing(known, state)?.class),
        }
    }

    fn standing(&self, known: &Standings, state: &[i64]) -> Result<Standing> {
        let mut known = known.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(&found) = known.get(state) {
            return Ok(found);
        }
        let engine = &*self.engine;
        let found =
            Standing { class: self.classes.of(engine, state)?, rank: self.levels.rank(engine, state)? };
        known.insert(state.to_vec(), found);
        Ok(found)
    }
}
