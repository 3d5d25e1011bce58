//! Shared by the commands about strategies: the engine, the requested states, and the levels.

use std::sync::Arc;

use meliora_engine::{AnyEngine, Engine, Scope};
use meliora_lang as lang;
use meliora_model::error::{Diagnostic, Error, SourceFile};
use meliora_model::{Program, State, VarId};
use meliora_planning::{Analysis, FiniteMemoryStrategy, Kind, Phase, StrategyKind};
use meliora_report::envelope::{Envelope, Findings};

use super::load::{self, Question};
use super::options::{EngineArgs, ModelArgs, PreferenceArgs};
use super::phases;
use super::progress::TerminalSink;
use super::supervise::Job;

/// The arguments for model, preferences and engine.
#[derive(Clone, Copy)]
pub(super) struct Subject<'a> {
    pub(super) model: &'a ModelArgs,
    pub(super) preferences: &'a PreferenceArgs,
    pub(super) engine: &'a EngineArgs,
}

/// Reads the model and the preferences, then `more` of the arguments, and explores the model with
/// the engine that the arguments select.
///
/// # Errors
/// The input is wrong, or a limit is hit.
pub(super) fn prepared<F: Findings, T>(
    job: &Job<Envelope<F>>,
    Subject { model, preferences, engine }: Subject<'_>,
    more: impl FnOnce(&mut Question) -> Result<T, Error>,
) -> Result<(Question, Arc<AnyEngine>, T), Error> {
    let read = || {
        let mut question = load::question(model, preferences, &job.sink)?;
        let more = more(&mut question)?;
        Ok((question, more))
    };
    let (question, more) = job.timed("parse", read, |r, s| r.time.add("parse", s))?;
    let selected = engine.select([&*question.program], model);
    job.update(|r| {
        r.header.read_both(&question.program, &question.preferences);
        r.header.select(&selected);
    });
    let build = || load::engine(&question.program, model, selected.storage, &job.sink);
    let engine = job.timed("build", build, |r, s| r.time.add("build", s))?;
    Ok((question, engine, more))
}

/// Reads `--at`.
///
/// # Errors
/// A state is wrong. All errors of all states are reported together.
pub(super) fn states(program: &Program, texts: &[String]) -> Result<Vec<State>, Error> {
    let (mut states, mut wrong) = (Vec::new(), Vec::new());
    for text in texts {
        match lang::parse_state(&SourceFile::new("--at", text.as_str()), program) {
            Ok(state) => states.push(state),
            Err(Error::Input(diagnostics)) => wrong.extend(diagnostics),
            Err(error) => return Err(error),
        }
    }
    if wrong.is_empty() { Ok(states) } else { Err(Error::Input(wrong)) }
}

/// Refuses states outside of the scope.
///
/// # Errors
/// A state is not in the scope.
pub(super) fn in_scope<E: Engine>(
    engine: &E,
    program: &Program,
    args: &ModelArgs,
    texts: &[String],
    states: &[State],
) -> Result<(), Error> {
    let all = engine.all_states();
    let mut wrong = Vec::new();
    for (text, state) in texts.iter().zip(states) {
        if engine.contains(&all, state)? {
            continue;
        }
        let source = SourceFile::new("--at", text.as_str());
        let diagnostic = Diagnostic::new(&source, 0..text.len(), "no path reaches this state");
        wrong.push(match (&program.monitors, args.scope) {
            (Some(monitors), _) => diagnostic.help(at_the_start(program, &monitors.variables)),
            (None, Scope::Reachable) => diagnostic.help("`--scope all` accepts every valuation as a state"),
            (None, Scope::All) => diagnostic,
        });
    }
    if wrong.is_empty() { Ok(()) } else { Err(Error::Input(wrong)) }
}

/// Returns the advice for a state that no path reaches with these values of the monitors.
fn at_the_start(program: &Program, monitors: &[VarId]) -> String {
    let names =
        monitors.iter().map(|at| format!("`{}`", program.variables[at.index()].name)).collect::<Vec<_>>();
    format!("leave out {}: their values are then those at the start of a path", names.join(", "))
}

/// Runs the analysis with these phases for the levels.
///
/// # Errors
/// A limit is hit, or a target has no value in some state.
pub(super) fn analysis<E: Engine>(
    engine: &Arc<E>,
    question: &Question,
    args: &PreferenceArgs,
    levels: &[Phase],
    sink: &TerminalSink,
) -> Result<Analysis<E>, Error> {
    let mut analysis = Analysis::new(engine, &question.preferences, args.options());
    let all = [&[Phase::Outcomes, Phase::Improvement], levels].concat();
    phases::run(&mut analysis, &all, sink, &mut |_| ())?;
    Ok(analysis)
}

/// Returns the strategy of an analysis whose levels are known.
///
/// # Errors
/// [`Error::Usage`] if the levels are not known; a limit is hit.
pub(super) fn finite_memory<E: Engine>(
    analysis: &Analysis<E>,
    program: &Arc<Program>,
    kind: StrategyKind,
    levels: Kind,
    objective: Option<usize>,
) -> Result<FiniteMemoryStrategy<E>, Error> {
    let missing = || Error::Usage(format!("the levels of {levels} are not known"));
    FiniteMemoryStrategy::of_kind(analysis, program, kind, levels, objective)?.ok_or_else(missing)
}
