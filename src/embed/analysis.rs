//! The type of an analysis for other programs.

use std::ops::{Deref, DerefMut};

use meliora_planning as planning;

/// An analysis under preferences, with an engine that is selected at run time. It has all methods
/// of [`planning::Analysis`], and methods for owned sets, strategies and reports.
pub struct Analysis {
    inner: planning::Analysis,
    /// See [`super::Exploration`].
    pub(super) named: Option<Vec<bool>>,
}

impl From<planning::Analysis> for Analysis {
    fn from(inner: planning::Analysis) -> Self {
        Analysis { inner, named: None }
    }
}

impl Deref for Analysis {
    type Target = planning::Analysis;

    fn deref(&self) -> &planning::Analysis {
        &self.inner
    }
}

impl DerefMut for Analysis {
    fn deref_mut(&mut self) -> &mut planning::Analysis {
        &mut self.inner
    }
}
