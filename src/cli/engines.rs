//! Builds the engines that the arguments select, and warns of their states.

use std::path::Path;
use std::sync::Arc;

use meliora_base::error::Error;
use meliora_engine::{AnyEngine, Count, Engine, Order, Settings, Storage, SymbolicEngine};
use meliora_model::Program;
use meliora_model::predicate::Predicate;
use meliora_question::{race, warnings};

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
        threads: args.threads(),
        sink: Arc::clone(sink) as _,
        ..Settings::default()
    })
}

/// Builds the engine that the arguments select.
///
/// # Errors
/// The errors of [`race::built`]; the file of `--order` cannot be read.
pub(super) fn engine(
    program: &Arc<Program>,
    args: &ModelArgs,
    storage: Storage,
    sink: &Arc<TerminalSink>,
) -> Result<Arc<AnyEngine>, Error> {
    race::built(program, settings(args, storage, sink)?)
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
    race::symbolic(program, settings(args, Storage::Symbolic, sink)?)
}

/// Warns of states; see [`warnings::of_states`].
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
    let all = warnings::of_states(engine, program, deadlocks, overlap)?;
    all.into_iter().for_each(|warning| sink.tell(warning));
    Ok(())
}
