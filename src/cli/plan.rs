//! Shared by the commands about strategies: the engine and the levels.

use std::sync::Arc;

use meliora_base::error::Error;
use meliora_engine::{AnyEngine, Engine};
use meliora_model::Program;
use meliora_model::preference::ObjectiveSet;
use meliora_planning::{Analysis, FiniteMemoryStrategy, Kind, Phase, StrategyKind};
use meliora_question::race::{Early, Raced};
use meliora_report::envelope::{Envelope, Findings};

use super::engines;
use super::load::{self, Question};
use super::options::{EngineArgs, ModelArgs, PreferenceArgs};
use super::phases;
use super::progress::TerminalSink;
use super::supervise::Job;

/// The arguments for model, preferences and engine.
#[derive(Clone, Copy)]
pub(super) struct Arguments<'a> {
    pub(super) model: &'a ModelArgs,
    pub(super) preferences: &'a PreferenceArgs,
    pub(super) engine: &'a EngineArgs,
}

/// Reads the model and the preferences, then `more` of the arguments.
///
/// # Errors
/// The input is wrong.
pub(super) fn read<F: Findings, T>(
    job: &Job<Envelope<F>>,
    given: Arguments<'_>,
    more: impl FnOnce(&mut Question) -> Result<T, Error>,
) -> Result<(Question, T), Error> {
    let read = || {
        let mut question = load::question(given.model, given.preferences, &job.sink)?;
        let more = more(&mut question)?;
        Ok((question, more))
    };
    let (question, more) = job.timed("parse", read, |r, s| r.time.add("parse", s))?;
    note(job, given, &question);
    Ok((question, more))
}

/// Adds the input to the report.
pub(super) fn note<F: Findings>(
    job: &Job<Envelope<F>>,
    Arguments { model, engine, .. }: Arguments<'_>,
    question: &Question,
) {
    job.update(|r| {
        r.header.read_both(&question.program, &question.preferences);
        r.header.select(&engine.select(model));
    });
}

/// Answers a question by the engine that the arguments select, the first of several ways to end; see [`Raced::run`].
///
/// # Errors
/// The errors of [`Raced::run`]; the file of `--order` cannot be read.
pub(super) fn raced<F: Findings + Clone + Send, T: Send>(
    job: &Job<Envelope<F>>,
    Arguments { model, engine, .. }: Arguments<'_>,
    question: &Question,
    answer: Answer<'_, F, T>,
) -> Result<T, Error> {
    let (program, selected) = (&question.program, engine.select(model));
    let settings = &engines::settings(model, selected.storage, &job.sink)?;
    let early = Early::default();
    Raced { program, settings, selected, lists_states: false, early, answer }.run(job)
}

/// Answers a question by an engine that knows all states. Several threads may do so at the same time, each with a report
/// of its own.
pub(super) type Answer<'r, F, T> =
    &'r (dyn Fn(&Job<Envelope<F>>, &Arc<AnyEngine>) -> Result<T, Error> + Sync);

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
    objectives: &ObjectiveSet,
) -> Result<FiniteMemoryStrategy<E>, Error> {
    let missing = || Error::Usage(format!("the levels of {levels} are not known"));
    FiniteMemoryStrategy::of_kind(analysis, program, kind, levels, objectives.iter())?.ok_or_else(missing)
}
