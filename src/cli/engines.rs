//! Builds the engines that the arguments select, and warns of their states.

use std::path::Path;
use std::sync::Arc;

use meliora::reach::check_start;
use meliora_base::error::Error;
use meliora_engine::{
    AnyEngine, Count, Decision, Engine, Initially, Order, Selection, Settings, Storage, SymbolicEngine,
};
use meliora_model::predicate::Predicate;
use meliora_model::{Program, fault};
use meliora_report::Number;

use super::load::read;
use super::options::ModelArgs;
use super::progress::TerminalSink;

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
    started(AnyEngine::new(Arc::clone(program), settings(args, storage, sink)?)?, program)
}

/// Builds the engine for some work, and updates the selection. Numbers list the states anyway.
///
/// # Errors
/// The errors of [`engine`].
pub(super) fn engine_for(
    program: &Arc<Program>,
    args: &ModelArgs,
    selected: &mut Selection,
    lists_states: bool,
    sink: &Arc<TerminalSink>,
) -> Result<Arc<AnyEngine>, Error> {
    started(selected.build(program, settings(args, selected.storage, sink)?, lists_states)?, program)
}

/// Answers a question about the initial states before all states are known, or builds the engine for it; see
/// [`Selection::decide`].
///
/// # Errors
/// The errors of [`engine`] and of the question.
pub(super) fn decided<T>(
    program: &Arc<Program>,
    args: &ModelArgs,
    selected: &mut Selection,
    question: &Initially<'_, T>,
    sink: &Arc<TerminalSink>,
) -> Result<Decision<T, Arc<AnyEngine>>, Error> {
    match selected.decide(program, settings(args, selected.storage, sink)?, question)? {
        Decision::Built(engine) => started(engine, program).map(Decision::Built),
        Decision::Answered(answer) => Ok(Decision::Answered(answer)),
        Decision::Guided(guided) => Ok(Decision::Guided(guided)),
    }
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
    started(SymbolicEngine::new(Arc::clone(program), settings(args, Storage::Symbolic, sink)?)?, program)
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
