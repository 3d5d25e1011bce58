//! The last results of fixpoints.

use std::sync::{Mutex, MutexGuard, PoisonError};

use super::StateSet;

/// Number of results that are kept: about the number of objectives of a model.
const MOST_REMEMBERED: usize = 16;

/// The states that can reach a target by all choices.
#[derive(Clone)]
pub(super) struct Reaching {
    pub(super) states: StateSet,
    /// True if they were found by layers.
    pub(super) by_layers: bool,
}

/// The last results of one fixpoint, each with its operands.
pub(super) struct Remembered<Of, Found>(Mutex<Vec<(Of, Found)>>);

impl<Of, Found> Default for Remembered<Of, Found> {
    fn default() -> Self {
        Remembered(Mutex::default())
    }
}

impl<Of: PartialEq, Found: Clone> Remembered<Of, Found> {
    fn known(&self) -> MutexGuard<'_, Vec<(Of, Found)>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns a result, if it is remembered.
    pub(super) fn recall(&self, of: &Of) -> Option<Found> {
        self.known().iter().find(|(known, _)| known == of).map(|(_, found)| found.clone())
    }

    /// Remembers a result.
    pub(super) fn remember(&self, of: Of, found: Found) {
        let mut known = self.known();
        if known.len() >= MOST_REMEMBERED {
            known.remove(0);
        }
        known.push((of, found));
    }
}
