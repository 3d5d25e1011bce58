//! Builds the engines that the arguments select, and warns of their states.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::{Arc, Mutex};

use meliora::supervise::lock;
use meliora_base::error::Error;
use meliora_engine::{
    AnyEngine, BySearch, Count, Engine, Guided, Order, OverAll, ProgressSink, Question, Racer, Selection,
    Settings, Storage, SymbolicEngine,
};
use meliora_model::predicate::Predicate;
use meliora_model::{Program, fault};
use meliora_question::check_start;
use meliora_report::Number;
use meliora_report::envelope::{Envelope, Findings};

use super::load::read;
use super::options::ModelArgs;
use super::progress::TerminalSink;
use super::supervise::Job;

/// Returns the settings of an engine.
///
/// # Errors
/// The file of `--order` cannot be read.
pub(super) fn settings(
    args: &ModelArgs,
    storage: Storage,
    sink: &Arc<TerminalSink>,
) -> Result<Settings, Error> {
    let order = match args.order.as_str() {
        "auto" => Order::Auto,
        "declared" => Order::Declared,
        file => Order::Text(read(Path::new(file))?),
    };
    Ok(Settings {
        scope: args.scope,
        storage,
        memory: args.memory(),
        order,
        threads: args.threads(),
        sink: Arc::clone(sink) as _,
        ..Settings::default()
    })
}

/// Builds the engine that the arguments select.
///
/// # Errors
/// The variable order is wrong, the model has no meaning in some state or no initial state, or a limit is
/// hit.
pub(super) fn engine(
    program: &Arc<Program>,
    args: &ModelArgs,
    storage: Storage,
    sink: &Arc<TerminalSink>,
) -> Result<Arc<AnyEngine>, Error> {
    match storage {
        Storage::Symbolic => Ok(Arc::new(AnyEngine::Symbolic(symbolic(program, args, sink)?))),
        Storage::Explicit => {
            started(AnyEngine::new(Arc::clone(program), settings(args, storage, sink)?)?, program)
        }
    }
}

/// The ways to answer a question before all states are known; see [`Question`].
pub(super) struct Early<'q, T> {
    pub(super) everywhere: Option<OverAll<'q, T>>,
    pub(super) guided: Option<(&'q Predicate, BySearch<'q, T>)>,
}

impl<T> Default for Early<'_, T> {
    fn default() -> Self {
        Early { everywhere: None, guided: None }
    }
}

/// A question of a command about a program.
pub(super) struct Request<'r, F: Findings, T> {
    pub(super) program: &'r Arc<Program>,
    pub(super) args: &'r ModelArgs,
    pub(super) selected: Selection,
    /// True if the answer lists the states anyway.
    pub(super) lists_states: bool,
    pub(super) early: Early<'r, T>,
    pub(super) answer: Answer<'r, F, T>,
}

/// Answers a question by an engine that knows all states. Several threads may do so at the same time, each with a report
/// of its own.
pub(super) type Answer<'r, F, T> =
    &'r (dyn Fn(&Job<Envelope<F>>, &Arc<AnyEngine>) -> Result<T, Error> + Sync);

/// Answers a question by the first of several ways to end, with the engine that the arguments select. The report shows
/// the partial results of the way that leads, and in the end those of the one that has the answer; `header` adds the
/// engine to it, and `built` the seconds until all states are known.
///
/// # Errors
/// The variable order is wrong, the model has no meaning in some state or no initial state; a limit; the errors of the
/// question.
pub(super) fn raced<F: Findings + Clone + Send, T: Send>(
    job: &Job<Envelope<F>>,
    request: &Request<'_, F, T>,
) -> Result<T, Error> {
    let Request { program, args, lists_states, .. } = *request;
    let settings = settings(args, request.selected.storage, &job.sink)?;
    let start = job.copy(&job.sink);
    let sinks: Mutex<BTreeMap<usize, Arc<TerminalSink>>> = Mutex::default();
    let begin = job.begin("build");
    job.sink.show(None);
    let by_states = |racer: &Racer, engine: AnyEngine| {
        let sink = Arc::clone(lock(&sinks).get(&racer.way).unwrap_or(&job.sink));
        let mut own = start.copy(&sink);
        if racer.leads {
            job.take(&start);
            job.sink.show(Some(&sink));
            own = job.with_sink(&sink);
        }
        own.end("build", begin, |r, s| r.time.add("build", s));
        own.update(|r| r.header.select(&racer.selection));
        let engine = started(engine, program)?;
        let found = (request.answer)(&own, &engine);
        found.map(|found| (found, Some(own)))
    };
    let everywhere = request.early.everywhere;
    let everywhere = everywhere.map(|ask| move |engine: &SymbolicEngine| Ok((ask(engine)?, None)));
    let guided = request.early.guided;
    let guided = guided.map(|(target, ask)| (target, move |search: Guided| Ok((ask(search)?, None))));
    let of_way = |way: usize| {
        let sink = Arc::new(job.sink.of_way(way));
        lock(&sinks).insert(way, Arc::clone(&sink));
        sink as Arc<dyn ProgressSink>
    };
    let question = Question {
        by_states: &by_states,
        everywhere: everywhere.as_ref().map(|ask| ask as _),
        guided: guided.as_ref().map(|(target, ask)| (*target, ask as _)),
        lists_states,
        sinks: Some(&of_way),
    };
    let mut selected = request.selected.clone();
    let (found, own) = selected.answer(program, settings, &question)?;
    match own {
        Some(own) => {
            job.take(&own);
            job.sink.show(Some(&own.sink));
        }
        None => {
            job.take(&start);
            job.end("build", begin, |r, s| r.time.add("build", s));
            job.update(|r| r.header.select(&selected));
        }
    }
    Ok(found)
}

/// Builds the symbolic engine, for commands that need decision diagrams.
///
/// # Errors
/// The errors of [`engine`].
pub(super) fn symbolic(
    program: &Arc<Program>,
    args: &ModelArgs,
    sink: &Arc<TerminalSink>,
) -> Result<Arc<SymbolicEngine>, Error> {
    let settings = settings(args, Storage::Symbolic, sink)?;
    started(SymbolicEngine::in_some_order(Arc::clone(program), settings)?, program)
}

/// Builds an engine for another program, of the same kind and with the settings of this one.
///
/// # Errors
/// The errors of [`engine`].
pub(super) fn like(engine: &AnyEngine, program: &Arc<Program>) -> Result<Arc<AnyEngine>, Error> {
    started(AnyEngine::new(Arc::clone(program), engine.settings().clone())?, program)
}

/// Returns the engine of a model that has an initial state.
fn started<E: Engine>(engine: E, program: &Program) -> Result<Arc<E>, Error> {
    check_start(&engine, program)?;
    Ok(Arc::new(engine))
}

/// Warns of deadlocks, of rounded probabilities, and of states in which a `dtmc` draws a command
/// uniformly.
///
/// # Errors
/// A limit is hit.
pub(super) fn warn_of_states<E: Engine>(
    sink: &TerminalSink,
    engine: &E,
    program: &Program,
    deadlocks: &Count,
    overlap: Option<&Predicate>,
) -> Result<(), Error> {
    if *deadlocks != Count::ZERO {
        let (count, plural) = counted(deadlocks);
        let what = if plural { "states are deadlocks: each" } else { "state is a deadlock: it" };
        let example = engine.list_states(&engine.deadlock_states(), 1)?.pop().unwrap_or_default();
        let (such_as, example) = (if plural { ", such as " } else { ": " }, program.show_state(&example));
        sink.warn(&format!("{count} {what} gets a self-loop{such_as}{example}"));
    }
    if let Some(state) = engine.rounded_state()
        && let Some((command, sum)) = program.rounded_in(state)
    {
        sink.warn_at(&[fault::rounded(program, command, sum, state)]);
    }
    let Some(overlap) = overlap else { return Ok(()) };
    let states = match engine.drawing_states() {
        Some(states) => states,
        None => engine.count(&engine.states_where(overlap)?)?,
    };
    if states != Count::ZERO {
        let (count, plural) = counted(&states);
        let what = if plural { "states" } else { "state" };
        sink.warn(&format!(
            "several commands are enabled in {count} {what} of this dtmc; one is drawn uniformly"
        ));
    }
    Ok(())
}

fn counted(count: &Count) -> (String, bool) {
    (Number(count.clone()).grouped(), *count != Count::from(1u32))
}
