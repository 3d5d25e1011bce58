//! The last results of backward reachability by all choices.

use std::sync::{MutexGuard, PoisonError};

use super::{StateSet, SymbolicEngine};

/// Number of results of backward reachability that are kept: about the number of objectives of a
/// model.
const MOST_REMEMBERED: usize = 16;

impl SymbolicEngine {
    fn reaching(&self) -> MutexGuard<'_, Vec<(StateSet, StateSet)>> {
        self.reaching.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns the states that can reach a target by all choices, if they are remembered.
    pub(super) fn recall(&self, target: &StateSet) -> Option<StateSet> {
        self.reaching().iter().find(|(t, _)| t.0 == target.0).map(|(_, found)| found.clone())
    }

    /// Remembers the states that can reach a target by all choices.
    pub(super) fn remember(&self, target: &StateSet, found: &StateSet) {
        let mut known = self.reaching();
        if known.len() >= MOST_REMEMBERED {
            known.remove(0);
        }
        known.push((target.clone(), found.clone()));
    }
}
