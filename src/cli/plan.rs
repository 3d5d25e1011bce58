//! Shared by the commands about strategies: the engine and the levels.

use std::sync::Arc;

use meliora::Task;
use meliora_base::error::Error;
use meliora_engine::AnyEngine;
use meliora_question::race::{Early, Raced};
use meliora_report::envelope::{Envelope, Findings};

use super::engines;
use super::load;
use super::options::{EngineArgs, ModelArgs, PreferenceArgs};
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
    more: impl FnOnce(&mut Task) -> Result<T, Error>,
) -> Result<(Task, T), Error> {
    let read = || {
        let mut task = load::task(given.model, given.preferences, &job.sink)?;
        let more = more(&mut task)?;
        Ok((task, more))
    };
    let (task, more) = job.timed("parse", read, |r, s| r.time.add("parse", s))?;
    note(job, given, &task);
    Ok((task, more))
}

/// Adds the input to the report.
pub(super) fn note<F: Findings>(
    job: &Job<Envelope<F>>,
    Arguments { model, engine, .. }: Arguments<'_>,
    task: &Task,
) {
    job.update(|r| {
        r.header.read_both(&task.program, &task.preferences);
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
    task: &Task,
    answer: Answer<'_, F, T>,
) -> Result<T, Error> {
    let (program, selected) = (&task.program, engine.select(model));
    let settings = &engines::settings(model, selected.storage, &job.sink)?;
    let early = Early::default();
    Raced { program, settings, selected, lists_states: false, early, answer }.run(job)
}

/// Answers a question by an engine that knows all states. Several threads may do so at the same time, each with a report
/// of its own.
pub(super) type Answer<'r, F, T> =
    &'r (dyn Fn(&Job<Envelope<F>>, &Arc<AnyEngine>) -> Result<T, Error> + Sync);
