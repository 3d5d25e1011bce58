//! The analysis that `meliora check` reports, with all that it finds about the initial states.

use std::sync::Arc;
use std::time::Duration;

use super::{Kept, Task, Work};
use meliora_base::error::{Error, Limit, Result};
use meliora_engine::{Count, Engine, Selection, Settings};
use meliora_model::{Program, State};
use meliora_planning::{Analysis, Event, Options, Phase, Safety};
use meliora_quantities::all_states::MOST_STATES;
use meliora_question::race::{Early, Raced};
use meliora_question::{Warning, warnings};
use meliora_report::check::LISTED;
use meliora_report::cycle::Cycle;
use meliora_report::envelope::Times;
use meliora_report::page::PageReport;
use meliora_report::players::PlayerSummary;
use meliora_report::{CheckReport, Header};

/// A report that contains the report of `check`.
pub trait HasCheck: 'static {
    /// Returns the report of `check` so far.
    fn check(&mut self) -> &mut CheckReport;
}

impl HasCheck for CheckReport {
    fn check(&mut self) -> &mut CheckReport {
        self
    }
}

impl HasCheck for PageReport {
    fn check(&mut self) -> &mut CheckReport {
        &mut self.check
    }
}

/// Findings of a check in addition to the levels and the prospects of the initial states.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Extras {
    /// The most preferred objectives that one strategy achieves together.
    pub jointly: bool,
    /// The cycles behind unbounded ranks, and the ranks under [`Safety::Action`].
    pub details: bool,
}

/// The result of [`Task::check`].
#[derive(Debug)]
pub struct CheckResult {
    /// The report, as far as it is known. It has no times.
    pub report: CheckReport,
    /// The warnings.
    pub warnings: Vec<Warning>,
    /// The limit that has ended the work before everything was known.
    pub limit: Option<Limit>,
}

impl Task {
    /// Does what `meliora check` does, by the first of several ways to end if `selected` is open: all phases, the
    /// prospects of the initial states, and warnings of states and of empty targets.
    ///
    /// # Errors
    /// The errors of [`Model::explore`](crate::Model::explore); a target has no value in some state. A limit leaves the
    /// results so far.
    pub fn check(
        &self,
        options: Options,
        extras: Extras,
        selected: Selection,
        settings: &Settings,
    ) -> Result<CheckResult> {
        let header = Header::of_engine(&self.program, settings.storage, settings.scope);
        let mut report = CheckReport::new(header.with_preferences(&self.source.name, options.safety));
        report.read(&self.program, self.preferences.empty, self.preferences.history);
        report.header.read_conditions(self.preferences.predicates());
        report.header.select(&selected);
        let kept = Kept::new(report, Arc::clone(&settings.sink));
        let by_states = |kept: &Kept<CheckReport>, engine: &_| check(kept, engine, self, options, extras);
        let (program, early) = (&self.program, Early::default());
        let raced = Raced { program, settings, selected, lists_states: false, early, answer: &by_states };
        let limit = match raced.run(&kept) {
            Ok(()) => None,
            Err(Error::Limit(limit)) => Some(limit),
            Err(error) => return Err(error),
        };
        let (report, warnings) = kept.known();
        Ok(CheckResult { report, warnings, limit })
    }
}

/// Runs all phases of an analysis and finds all that a check reports. The report has the results so far whenever a limit
/// ends the work.
///
/// # Errors
/// A limit is reached, or a target has no value in some state.
pub fn check<E: Engine>(
    work: &dyn Work<CheckReport>,
    engine: &Arc<E>,
    task: &Task,
    options: Options,
    extras: Extras,
) -> Result<()> {
    let mut analysis = analyse(work, engine, task, options)?;
    if extras.details {
        cycles(work, &analysis, &task.program, LISTED)?;
        by_step(work, &analysis, LISTED)?;
    }
    if extras.jointly {
        let mut hear = |event: Event<'_>| work.update(|r| r.result.add(event));
        work.timed("jointly", || analysis.run_jointly(&mut hear), |_, _| ())?;
        let initial = analysis.initial_prospects(&task.program, LISTED)?;
        work.update(|r| r.initial = initial);
    }
    gains(work, &analysis, task)
}

/// Runs all phases. Each phase adds its results to the report.
///
/// # Errors
/// A limit is reached, or a target has no value in some state.
pub fn analyse<E: Engine, R: HasCheck>(
    work: &dyn Work<R>,
    engine: &Arc<E>,
    task: &Task,
    options: Options,
) -> Result<Analysis<E>> {
    let mut analysis = Analysis::new(engine, &task.preferences, options);
    let analysing = Analysing { work, task };
    analysing.phase(&mut analysis, Phase::Counts)?;
    analysing.warn_of_states(&analysis)?;
    analysing.phase(&mut analysis, Phase::Outcomes)?;
    warnings::of_targets(&analysis, &task.program)?.into_iter().for_each(|warning| work.warn(warning));
    analysing.initial(&analysis)?;
    analysing.phase(&mut analysis, Phase::Improvement)?;
    for phase in [Phase::Sasi, Phase::Spi] {
        let end = analysing.phase(&mut analysis, phase);
        // The partial results at a limit are shown, if they can be computed.
        let shown = analysing.initial(&analysis);
        end.and(shown)?;
    }
    Ok(analysis)
}

/// Adds the cycles behind the unbounded ranks of the first `most` initial states to the report.
///
/// # Errors
/// A limit is reached.
pub fn cycles<E: Engine, R: HasCheck>(
    work: &dyn Work<R>,
    analysis: &Analysis<E>,
    program: &Arc<Program>,
    most: usize,
) -> Result<()> {
    let states = listed(work, most);
    let find = || states.iter().map(|state| Cycle::find(analysis, program, state)).collect();
    let cycles = work.timed("cycles", find, |_, _| ())?;
    work.update(|r| r.check().cycles = cycles);
    Ok(())
}

/// Adds the ranks of the first `most` initial states under [`Safety::Action`] to the report, if the safety mode is
/// another one that never weakens: where they differ, several steps can lose more than any single step.
///
/// # Errors
/// A limit is reached.
pub fn by_step<E: Engine, R: HasCheck>(
    work: &dyn Work<R>,
    analysis: &Analysis<E>,
    most: usize,
) -> Result<()> {
    if !analysis.options().safety.has_reference() {
        return Ok(());
    }
    let states = listed(work, most);
    let ranks = work.timed("by step", || analysis.ranks_under(Safety::Action, &states), |_, _| ())?;
    work.update(|r| r.check().by_step = ranks);
    Ok(())
}

/// Returns the first initial states of the report.
fn listed<R: HasCheck>(work: &dyn Work<R>, most: usize) -> Vec<State> {
    let mut states = Vec::new();
    work.update(|r| states.extend(r.check().initial.iter().take(most).map(|initial| initial.state.clone())));
    states
}

/// Adds the gains of the improvements of the initial states, if the model is small: the paths are searched state
/// by state.
fn gains<E: Engine>(work: &dyn Work<CheckReport>, analysis: &Analysis<E>, task: &Task) -> Result<()> {
    let small = analysis.result().counts.as_ref().is_some_and(|c| c.states <= Count::from(MOST_STATES));
    if !small {
        return Ok(());
    }
    let mut initial = Vec::new();
    work.update(|r| initial.clone_from(&r.initial));
    let find = || initial.iter_mut().try_for_each(|own| analysis.add_gains(&task.program, own, MOST_STATES));
    work.timed("gains", find, |_, _| ())?;
    work.update(|r| r.initial = initial);
    Ok(())
}

/// Analyses a task with these phases for the levels, without a report.
///
/// # Errors
/// A limit is reached, or a target has no value in some state.
pub fn levels<E: Engine, R>(
    work: &dyn Work<R>,
    engine: &Arc<E>,
    task: &Task,
    options: Options,
    levels: &[Phase],
) -> Result<Analysis<E>> {
    let mut analysis = Analysis::new(engine, &task.preferences, options);
    let all = [&[Phase::Outcomes, Phase::Improvement], levels].concat();
    run_phases(work, &mut analysis, &all, &mut |_| ())?;
    Ok(analysis)
}

/// Runs phases. `listener` receives the events, with the times of the work.
///
/// # Errors
/// A limit is reached, or a target has no value in some state.
pub fn run_phases<E: Engine, R>(
    work: &dyn Work<R>,
    analysis: &mut Analysis<E>,
    phases: &[Phase],
    listener: &mut dyn FnMut(Event<'_>),
) -> Result<()> {
    analysis.run_phases(phases, &mut |event| match event {
        Event::Part(phase, part) => work.part(phase.name(), part),
        Event::Finished(phase, _) => {
            let seconds = work.end(phase.name());
            listener(Event::Finished(phase, Duration::from_secs_f64(seconds)));
        }
        event => listener(event),
    })
}

/// Notes the time of a phase. Counting is a part of building.
pub fn note_time(time: &mut Times, event: Event<'_>) {
    if let Event::Finished(phase, took) = event {
        let name = if phase == Phase::Counts { "build" } else { phase.name() };
        time.add(name, took.as_secs_f64());
    }
}

/// A task with the report that receives the results of its analysis.
struct Analysing<'a, R> {
    work: &'a dyn Work<R>,
    task: &'a Task,
}

impl<R: HasCheck> Analysing<'_, R> {
    fn phase<E: Engine>(&self, analysis: &mut Analysis<E>, phase: Phase) -> Result<()> {
        let mut hear = |event: Event<'_>| {
            self.work.update(|r| {
                let r = r.check();
                r.result.add(event);
                note_time(&mut r.time, event);
            });
        };
        let result = run_phases(self.work, analysis, &[phase], &mut hear);
        let usage = analysis.engine().usage();
        self.work.update(|r| r.check().used(usage));
        result
    }

    /// Adds the current results for the initial states to the report.
    fn initial<E: Engine>(&self, analysis: &Analysis<E>) -> Result<()> {
        let list = || analysis.initial_prospects(&self.task.program, LISTED);
        let prospects = self.work.timed("initial states", list, |_, _| ())?;
        self.work.update(|r| r.check().initial = prospects);
        Ok(())
    }

    fn warn_of_states<E: Engine>(&self, analysis: &Analysis<E>) -> Result<()> {
        let Some(counts) = &analysis.result().counts else { return Ok(()) };
        let Task { program, overlap, .. } = self.task;
        let players = PlayerSummary::all(program, analysis.whole_engine())?;
        self.work.update(|r| r.check().players = players);
        let found = warnings::of_states(analysis.engine(), program, &counts.deadlocks, overlap.as_ref())?;
        found.into_iter().for_each(|warning| self.work.warn(warning));
        Ok(())
    }
}
