//! A question as a race of ways to its answer, each with results of its own.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

use crate::start::check_start;
use meliora_base::error::Result;
use meliora_base::sync::lock;
use meliora_engine::{
    AnyEngine, BySearch, Guided, OverAll, ProgressSink, RacedQuestion, Racer, Selection, Settings, Storage,
    SymbolicEngine,
};
use meliora_model::Program;
use meliora_model::predicate::Predicate;

/// Work whose results are kept before it ends. Each way of a race has results of its own.
pub trait Job: Sized + Send + Sync {
    /// Returns a job that begins with the results of this one.
    #[must_use]
    fn copy(&self) -> Self;

    /// Returns a job for a way, which begins with the results of this one.
    #[must_use]
    fn of_way(&self, _way: usize) -> Self {
        self.copy()
    }

    /// Returns the sink of the progress.
    fn sink(&self) -> Arc<dyn ProgressSink>;

    /// Hears that the search for all states begins.
    fn begin(&self) {}

    /// Hears that it has ended, with the engine that was selected.
    fn built(&self, _selection: &Selection) {}

    /// Lets the results of this job be those of a way from now on. Returns the job of the way.
    #[must_use]
    fn leave_to(&self, way: Self) -> Self;

    /// Takes the results of another job, and shows its progress.
    fn take(&self, other: &Self);
}

/// The ways to answer a question before all states are known; see [`RacedQuestion`].
pub struct Early<'q, T> {
    /// Over all valuations.
    pub everywhere: Option<OverAll<'q, T>>,
    /// By a guided search for the target.
    pub guided: Option<(&'q Predicate, BySearch<'q, T>)>,
}

impl<T> Default for Early<'_, T> {
    fn default() -> Self {
        Early { everywhere: None, guided: None }
    }
}

/// A question about a program.
pub struct Raced<'r, J, T> {
    /// The program.
    pub program: &'r Arc<Program>,
    /// The settings of the engines. Their sink and their storage are those of the job and of the selection.
    pub settings: &'r Settings,
    /// The engine.
    pub selected: Selection,
    /// True if the answer lists the states anyway.
    pub lists_states: bool,
    /// The answers before all states are known.
    pub early: Early<'r, T>,
    /// The answer by an engine that knows all states. Several threads may ask at the same time, each with a job of its own.
    pub answer: &'r (dyn Fn(&J, &Arc<AnyEngine>) -> Result<T> + Sync),
}

impl<J: Job, T: Send> Raced<'_, J, T> {
    /// Answers the question by the first of several ways to end. The job shows the partial results of the way that leads,
    /// and in the end those of the one that has the answer.
    ///
    /// # Errors
    /// The variable order is wrong, the model has no meaning in some state or no initial state; a limit; the errors of
    /// the question.
    pub fn run(&self, job: &J) -> Result<T> {
        let start = job.copy();
        let jobs: Mutex<BTreeMap<usize, J>> = Mutex::default();
        job.begin();
        let by_states = |racer: &Racer, engine: AnyEngine| {
            let own = lock(&jobs).remove(&racer.way).unwrap_or_else(|| start.of_way(racer.way));
            let own = if racer.leads {
                job.take(&start);
                job.leave_to(own)
            } else {
                own
            };
            own.built(&racer.selection);
            let found = (self.answer)(&own, &started(engine, self.program)?);
            found.map(|found| (found, Some(own)))
        };
        let everywhere = self.early.everywhere;
        let everywhere = everywhere.map(|ask| move |engine: &SymbolicEngine| Ok((ask(engine)?, None)));
        let guided = self.early.guided;
        let guided = guided.map(|(target, ask)| (target, move |search: Guided| Ok((ask(search)?, None))));
        let of_way = |way: usize| {
            let own = start.of_way(way);
            let sink = own.sink();
            lock(&jobs).insert(way, own);
            sink
        };
        let question = RacedQuestion {
            by_states: &by_states,
            everywhere: everywhere.as_ref().map(|ask| ask as _),
            guided: guided.as_ref().map(|(target, ask)| (*target, ask as _)),
            lists_states: self.lists_states,
            sinks: Some(&of_way),
        };
        let mut selected = self.selected.clone();
        let settings =
            Settings { sink: job.sink(), storage: selected.storage, ..Settings::clone(self.settings) };
        let (found, own) = selected.answer(self.program, settings, &question)?;
        match own {
            Some(own) => job.take(&own),
            None => {
                job.take(&start);
                job.built(&selected);
            }
        }
        Ok(found)
    }
}

/// Builds the engine of some settings, with diagrams in the first of several orders that fits.
///
/// # Errors
/// The variable order is wrong, the model has no meaning in some state or no initial state; a limit is reached.
pub fn built(program: &Arc<Program>, settings: Settings) -> Result<Arc<AnyEngine>> {
    match settings.storage {
        Storage::Symbolic => Ok(Arc::new(AnyEngine::Symbolic(symbolic(program, settings)?))),
        Storage::Explicit => started(AnyEngine::new(Arc::clone(program), settings)?, program),
    }
}

/// Builds the symbolic engine; see [`built`].
///
/// # Errors
/// The errors of [`built`].
pub fn symbolic(program: &Arc<Program>, settings: Settings) -> Result<Arc<SymbolicEngine>> {
    started(SymbolicEngine::in_some_order(Arc::clone(program), settings)?, program)
}

/// Returns the engine of a model that has an initial state.
///
/// # Errors
/// The model has none; a limit is reached.
pub fn started<E: meliora_engine::Engine>(engine: E, program: &Program) -> Result<Arc<E>> {
    check_start(&engine, program)?;
    Ok(Arc::new(engine))
}
