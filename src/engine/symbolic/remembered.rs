//! The last results of fixpoints.

use std::sync::{Mutex, MutexGuard, PoisonError};

use super::StateSet;

/// Number of results that are kept: about the number of objectives of a model.
const MOST_REMEMBERED: usize = 16;

/// The last results of one fixpoint, each with its operands.
pub(super) struct Remembered<Of>(Mutex<Vec<(Of, StateSet)>>);

impl<Of> Default for Remembered<Of> {
    fn default() -> Self {
        Remembered(Mutex::default())
    }
}

impl<Of: PartialEq> Remembered<Of> {
    fn known(&self) -> MutexGuard<'_, Vec<(Of, StateSet)>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns a result, if it is remembered.
    pub(super) fn recall(&self, of: &Of) -> Option<StateSet> {
        self.known().iter().find(|(known, _)| known == of).map(|(_, found)| found.clone())
    }

    /// Remembers a result.
    pub(super) fn remember(&self, of: Of, found: &StateSet) {
        let mut known = self.known();
        if known.len() >= MOST_REMEMBERED {
            known.remove(0);
        }
        known.push((of, found.clone()));
    }
}
