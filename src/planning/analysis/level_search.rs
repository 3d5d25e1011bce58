//! The search for the levels of a kind, and their sizes.

use std::sync::Arc;

use super::levels::{Kind, Levels};
use super::phases::Event;
use super::result::AnalysisResult;
use meliora_base::error::Result;
use meliora_engine::Engine;

/// The search for the levels of one kind.
pub(crate) enum LevelSearch<E: Engine> {
    /// There may be more levels than these.
    Open(Levels<E>),
    /// All levels are known. Strategies share them.
    Ended(Arc<Levels<E>>),
}

impl<E: Engine> LevelSearch<E> {
    pub(crate) fn new(kind: Kind) -> Self {
        LevelSearch::Open(Levels::new(kind))
    }

    /// Returns the levels found so far.
    pub(crate) fn levels(&self) -> &Levels<E> {
        match self {
            LevelSearch::Open(levels) => levels,
            LevelSearch::Ended(levels) => levels,
        }
    }

    /// Returns the levels to which the search may add more.
    pub(crate) fn open(&mut self) -> Option<&mut Levels<E>> {
        match self {
            LevelSearch::Open(levels) => Some(levels),
            LevelSearch::Ended(_) => None,
        }
    }

    /// Ends the search if the levels are complete.
    pub(crate) fn close(&mut self) {
        if let LevelSearch::Open(levels) = self
            && levels.end.is_some()
        {
            let levels = std::mem::replace(levels, Levels::new(levels.kind));
            *self = LevelSearch::Ended(Arc::new(levels));
        }
    }
}

/// Counts the new levels, adds them to the result and reports them to the listener.
pub(crate) fn count_levels<E: Engine>(
    engine: &E,
    levels: &Levels<E>,
    result: &mut AnalysisResult,
    listener: &mut dyn FnMut(Event<'_>),
) -> Result<()> {
    for at in result.levels(levels.kind).levels.len()..levels.found.len() {
        let count = engine.count(&levels.found[at].states)?;
        result.tell(Event::Level(levels.kind, at + 1, &count), listener);
    }
    Ok(())
}
