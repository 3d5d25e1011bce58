//! The search for the levels of both kinds, next to each other.

use std::sync::Arc;

use super::classes::Classes;
use super::improvement::Improvement;
use super::levels::{End, Kind, Level, Levels};
use super::phases::Event;
use super::result::AnalysisResult;
use meliora_base::error::Result;
use meliora_engine::parallel::{self, Port, Portable};
use meliora_engine::{Count, Engine};

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

/// The classes and the improvement MDP.
struct Given<E: Engine> {
    classes: Arc<Classes<E>>,
    improvement: Arc<Improvement<E>>,
}

impl<E: Engine> Portable<E> for Given<E> {
    fn ported(&self, port: &mut Port<E>) -> Self {
        Given {
            classes: Arc::new(self.classes.ported(port)),
            improvement: Arc::new(self.improvement.ported(port)),
        }
    }
}

/// The levels found so far, with their sizes: of W_1, W_2, …, and last of the fixpoint if there is
/// one.
struct Counted<E: Engine> {
    levels: Levels<E>,
    counts: Vec<Count>,
}

impl<E: Engine> Portable<E> for Counted<E> {
    fn ported(&self, port: &mut Port<E>) -> Self {
        Counted { levels: self.levels.ported(port), counts: self.counts.clone() }
    }
}

/// Completes the levels of several kinds, next to each other if the engine has workers. Returns the
/// sizes of the levels that are known, last that of the fixpoint, and how the search ended.
///
/// The arenas of an improvement MDP with several of them are solved next to each other instead: see
/// [`super::levels::next_level`]. Nothing is done then, or without workers.
pub(crate) fn search<E: Engine, const N: usize>(
    engine: &E,
    classes: &Arc<Classes<E>>,
    improvement: &Arc<Improvement<E>>,
    max_level: Option<usize>,
    kinds: [&mut Levels<E>; N],
) -> ([Vec<Count>; N], Result<()>) {
    if improvement.arenas.len() > 1 || engine.workers() == 0 {
        return ([const { Vec::new() }; N], Ok(()));
    }
    let given = || Given { classes: Arc::clone(classes), improvement: Arc::clone(improvement) };
    let mut jobs = kinds
        .each_ref()
        .map(|levels| (given(), Counted { levels: parallel::same(&**levels), counts: Vec::new() }));
    let end = parallel::run(engine, &mut jobs, |engine, Given { classes, improvement }, found| {
        let Counted { levels, counts } = found;
        loop {
            for level in &levels.found[counts.len().min(levels.found.len())..] {
                counts.push(engine.count(&level.states)?);
            }
            if !levels.advance(engine, classes, improvement, max_level)? {
                break;
            }
        }
        if let (Some(End::Unbounded(fixpoint)), true) = (&levels.end, counts.len() == levels.found.len()) {
            counts.push(engine.count(&fixpoint.states)?);
        }
        Ok(())
    });
    let mut found = jobs.into_iter().map(|(_, found)| found);
    let counts = kinds.map(|levels| {
        let Some(Counted { levels: completed, counts }) = found.next() else { return Vec::new() };
        *levels = completed;
        counts
    });
    (counts, end)
}

/// Counts the new levels, adds them to the result and reports them to the listener.
pub(crate) fn count_levels<E: Engine>(
    engine: &E,
    levels: &Levels<E>,
    counted: &[Count],
    result: &mut AnalysisResult,
    listener: &mut dyn FnMut(Event<'_>),
) -> Result<()> {
    for at in result.levels(levels.kind).levels.len()..levels.found.len() {
        let count = count_of(engine, &levels.found[at], at, counted)?;
        result.tell(Event::Level(levels.kind, at + 1, &count), listener);
    }
    Ok(())
}

/// Returns the number of states of a level, which may have been counted.
pub(crate) fn count_of<E: Engine>(
    engine: &E,
    level: &Level<E>,
    at: usize,
    counted: &[Count],
) -> Result<Count> {
    counted.get(at).map_or_else(|| engine.count(&level.states), |count| Ok(count.clone()))
}
