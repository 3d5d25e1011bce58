//! The rest of an exploration, for the explicit engine, of states that diagrams know.

use std::sync::Arc;

use super::engine::Engine;
use super::explicit::{ExplicitEngine, Exploration};
use super::settings::{Settings, Storage};
use super::symbolic::SymbolicEngine;
use meliora_base::error::{Error, Limit, Result};

/// The exploration by the explicit engine.
pub(super) struct Rest {
    /// The states explored so far, if there are any.
    pub(super) exploration: Option<Box<Exploration>>,
    /// The settings of the engine.
    pub(super) settings: Settings,
    /// The number of states.
    pub(super) states: usize,
}

impl Rest {
    /// Explores the rest of the states that diagrams know; `None` if they do not fit the memory left, of which these
    /// have used some.
    ///
    /// # Errors
    /// A limit of the whole work.
    pub(super) fn explore(self, symbolic: &SymbolicEngine, used: u64) -> Result<Option<ExplicitEngine>> {
        match self.engine(symbolic, used) {
            Err(Error::Limit(Limit::Memory { .. } | Limit::Size { .. } | Limit::States(_))) => Ok(None),
            engine => engine.map(Some),
        }
    }

    fn engine(self, symbolic: &SymbolicEngine, used: u64) -> Result<ExplicitEngine> {
        let memory = self.settings.memory.saturating_sub(used);
        let mut exploration = match self.exploration {
            Some(mut exploration) => {
                exploration.set_memory(memory);
                *exploration
            }
            None => {
                let settings = Settings { memory, storage: Storage::Explicit, ..self.settings };
                Exploration::new(Arc::clone(symbolic.program()), settings)?
            }
        };
        if !exploration.has_begun() {
            // Diagrams know the states in which paths begin. The search for them may take much longer.
            let start = symbolic.beginnings()?.unwrap_or_else(|| symbolic.all_states());
            exploration.begin_with(&symbolic.list_states(&start, usize::MAX)?)?;
        }
        exploration.expect(self.states);
        ExplicitEngine::explored(exploration)
    }
}
