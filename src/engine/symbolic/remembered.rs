//! The last results of backward reachability by all choices.

use std::sync::{MutexGuard, PoisonError};

use super::{StateSet, SymbolicEngine};

/// Number of results of backward reachability that are kept: about the number of objectives of a
/// model.
const MOST_REMEMBERED: usize = 16;

/// The states that can reach a target by all choices.
#[derive(Clone)]
pub(super) struct Reaching {
    target: StateSet,
    pub(super) states: StateSet,
    /// True if they were found by layers.
    pub(super) by_layers: bool,
}

impl SymbolicEngine {
    fn reaching(&self) -> MutexGuard<'_, Vec<Reaching>> {
        self.reaching.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns the states that can reach a target by all choices, if they are remembered.
    pub(super) fn recall(&self, target: &StateSet) -> Option<Reaching> {
        self.reaching().iter().find(|known| known.target.0 == target.0).cloned()
    }

    /// Remembers the states that can reach a target by all choices, which were found last.
    pub(super) fn remember(&self, target: &StateSet, states: &StateSet) {
        let mut known = self.reaching();
        if known.len() >= MOST_REMEMBERED {
            known.remove(0);
        }
        let (target, states) = (target.clone(), states.clone());
        known.push(Reaching { target, states, by_layers: self.store.reached_by_layers() });
    }
}
