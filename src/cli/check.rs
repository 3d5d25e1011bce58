//! `meliora check`: levels of improvements, and permitted actions in the initial states.

use std::sync::Arc;

use clap::Args;
use meliora_base::error::Error;
use meliora_engine::explicit::bounds::is_never_true;
use meliora_engine::{Count, Engine, Scope};
use meliora_model::State;
use meliora_model::preference::Goal;
use meliora_planning::{Analysis, Event, Kind, Phase, Safety};
use meliora_quantities::all_states::MOST_STATES;
use meliora_report::CheckReport;
use meliora_report::check::LISTED;
use meliora_report::cycle::{Cycle, MOST};
use meliora_report::players::PlayerSummary;

use super::engines;
use super::exit::Status;
use super::load::Question;
use super::options::{EngineArgs, ModelArgs, PreferenceArgs, ShownArgs};
use super::plan::{self, Arguments};
use super::supervise::{Job, supervise};
use super::sweep::SweepArgs;

/// Compute from which states the prospects can improve, and how many times in a row (SASI, SPI)
///
/// Computes the regions of the objectives, the classes, the improvement MDP and the SASI and SPI
/// levels. Prints the ranks of the initial states and the actions that the strategies permit there.
#[derive(Debug, Clone, Args)]
#[command(after_help = "Examples:
  meliora check models/robot5x5.prism models/robot5x5.pref
  meliora check models/network.prism models/network.pref -c K=5,M=2 --safety prefix --json")]
pub(super) struct CheckArgs {
    #[command(flatten)]
    model: ModelArgs,
    #[command(flatten)]
    preferences: PreferenceArgs,

    /// Compute also which most preferred objectives one strategy achieves together, in the same path
    #[arg(long)]
    jointly: bool,

    #[command(flatten)]
    engine: EngineArgs,
    #[command(flatten)]
    sweep: SweepArgs,
    #[command(flatten)]
    shown: ShownArgs,
}

/// Runs the command.
///
/// # Errors
/// The input is wrong, or a limit is hit.
pub(super) fn run(args: CheckArgs) -> Result<Status, Error> {
    args.engine.validate(&args.model)?;
    let mut report = CheckReport::new(args.engine.header(args.preferences.header(&args.model)));
    report.levels = args.preferences.options().max_level.unwrap_or_default();
    let preferences = &args.preferences.preferences;
    if let Some(status) =
        args.sweep.run_preferences("check", &args.model, preferences, &report, &args.shown)?
    {
        return Ok(status);
    }
    let (limits, shown) = (args.model.limits(), args.shown.of(&args.model));
    supervise(report, limits, &shown, move |job| work(job, &args))
}

/// A report that contains the report of `check`.
pub(super) trait Checked: 'static {
    /// Returns the report of `check` so far.
    fn check(&mut self) -> &mut CheckReport;
}

impl Checked for CheckReport {
    fn check(&mut self) -> &mut CheckReport {
        self
    }
}

fn work(job: &Job<CheckReport>, args: &CheckArgs) -> Result<(), Error> {
    let given = Arguments { model: &args.model, preferences: &args.preferences, engine: &args.engine };
    let (question, ()) = plan::read(job, given, |question| {
        read(job, question);
        Ok(())
    })?;
    plan::raced(job, given, &question, &|job, engine| answered(job, engine, &question, args))
}

fn answered<E: Engine>(
    job: &Job<CheckReport>,
    engine: &Arc<E>,
    question: &Question,
    args: &CheckArgs,
) -> Result<(), Error> {
    let mut analysis = analyse(job, engine, question, &args.preferences)?;
    if args.shown.verbose > 0 && !args.shown.json {
        cycles(job, &analysis, question, LISTED)?;
        by_step(job, &analysis, LISTED)?;
    }
    if args.jointly {
        let mut hear = |event: Event<'_>| job.update(|r| r.result.add(event));
        job.timed("jointly", || analysis.run_jointly(&mut hear), |_, _| ())?;
        let initial = analysis.initial_prospects(&question.program, LISTED)?;
        job.update(|r| r.initial = initial);
    }
    gains(job, &analysis, question)
}

/// Adds the gains of the improvements of the initial states, if the model is small: the paths are searched state
/// by state.
fn gains<E: Engine>(
    job: &Job<CheckReport>,
    analysis: &Analysis<E>,
    question: &Question,
) -> Result<(), Error> {
    let small = analysis.result().counts.as_ref().is_some_and(|c| c.states <= Count::from(MOST_STATES));
    if !small {
        return Ok(());
    }
    let mut initial = Vec::new();
    job.update(|r| initial.clone_from(&r.initial));
    let find = || {
        for found in &mut initial {
            for (kind, plan) in [(Kind::Sasi, &mut found.sasi), (Kind::Spi, &mut found.spi)] {
                if let Some(plan) = plan {
                    plan.gains = analysis.gains(&question.program, kind, &found.state, MOST_STATES)?;
                }
            }
        }
        Ok(())
    };
    job.timed("gains", find, |_, _| ())?;
    job.update(|r| r.initial = initial);
    Ok(())
}

/// Adds the ranks of the first `most` initial states under `--safety action`, if the safety mode is another
/// one that never weakens: where they differ, several steps can lose more than any single step.
///
/// # Errors
/// A limit is hit.
pub(super) fn by_step<E: Engine, R: Checked>(
    job: &Job<R>,
    analysis: &Analysis<E>,
    most: usize,
) -> Result<(), Error> {
    if !analysis.options().safety.has_reference() {
        return Ok(());
    }
    let mut states = Vec::new();
    job.update(|r| states.extend(r.check().initial.iter().take(most).map(|initial| initial.state.clone())));
    let ranks = || analysis.ranks_under(Safety::Action, &states);
    let ranks = job.timed("by step", ranks, |_, _| ())?;
    job.update(|r| r.check().by_step = ranks);
    Ok(())
}

/// Adds what the model and the preferences say to the report.
pub(super) fn read<R: Checked>(job: &Job<R>, question: &Question) {
    let Question { program, preferences, .. } = question;
    job.update(|r| r.check().read(program, preferences.empty, preferences.history));
}

/// Runs all phases. Each phase adds its results to the report.
///
/// # Errors
/// A limit is hit, or a target has no value in some state.
pub(super) fn analyse<E: Engine, R: Checked>(
    job: &Job<R>,
    engine: &Arc<E>,
    question: &Question,
    args: &PreferenceArgs,
) -> Result<Analysis<E>, Error> {
    let mut analysis = Analysis::new(engine, &question.preferences, args.options());
    let mut checking = Checking { job, question, analysis: &mut analysis };
    checking.phase(Phase::Counts)?;
    checking.warn_of_states()?;
    checking.phase(Phase::Outcomes)?;
    checking.warn_of_empty_targets()?;
    checking.initial()?;
    checking.phase(Phase::Improvement)?;
    for phase in [Phase::Sasi, Phase::Spi] {
        let end = checking.phase(phase);
        // The partial results at a limit are shown, if they can be computed.
        let shown = checking.initial();
        end.and(shown)?;
    }
    Ok(analysis)
}

/// Adds the cycles behind the unbounded ranks of the first `most` initial states to the report.
///
/// # Errors
/// A limit is hit.
pub(super) fn cycles<E: Engine, R: Checked>(
    job: &Job<R>,
    analysis: &Analysis<E>,
    question: &Question,
    most: usize,
) -> Result<(), Error> {
    let mut states = Vec::new();
    job.update(|r| states.extend(r.check().initial.iter().take(most).map(|initial| initial.state.clone())));
    let find = || {
        let of = |state: &State| {
            let found = |kind| cycle(analysis, question, kind, state);
            Ok::<_, Error>(found(Kind::Sasi)?.or(found(Kind::Spi)?))
        };
        states.iter().map(of).collect::<Result<Vec<_>, _>>()
    };
    let cycles = job.timed("cycles", find, |_, _| ())?;
    job.update(|r| r.check().cycles = cycles);
    Ok(())
}

/// Returns the cycle behind an unbounded rank; `None` for other ranks, and if it is too long to be shown.
///
/// # Errors
/// A limit is hit.
pub(super) fn cycle<E: Engine>(
    analysis: &Analysis<E>,
    question: &Question,
    kind: Kind,
    state: &[i64],
) -> Result<Option<Cycle>, Error> {
    let found = analysis.lasso(&question.program, kind, state, MOST)?;
    Ok(found.map(|lasso| Cycle::new(&question.program, &question.preferences, kind, lasso)))
}

/// An analysis with the report that receives its results.
struct Checking<'a, E: Engine, R: Checked> {
    job: &'a Job<R>,
    question: &'a Question,
    analysis: &'a mut Analysis<E>,
}

impl<E: Engine, R: Checked> Checking<'_, E, R> {
    fn phase(&mut self, phase: Phase) -> Result<(), Error> {
        self.phases(&[phase])
    }

    fn phases(&mut self, phases: &[Phase]) -> Result<(), Error> {
        let job = self.job;
        let mut hear = |event: Event<'_>| {
            job.update(|r| {
                let r = r.check();
                r.result.add(event);
                super::phases::note(&mut r.time, event);
            });
        };
        let result = super::phases::run(self.analysis, phases, &job.sink, &mut hear);
        let usage = self.analysis.engine().usage();
        job.update(|r| r.check().used(usage));
        result
    }

    /// Adds the current results for the initial states to the report.
    fn initial(&mut self) -> Result<(), Error> {
        let list = || self.analysis.initial_prospects(&self.question.program, LISTED);
        let prospects = self.job.timed("initial states", list, |_, _| ())?;
        self.job.update(|r| r.check().initial = prospects);
        Ok(())
    }

    fn warn_of_states(&self) -> Result<(), Error> {
        match &self.analysis.result().counts {
            Some(counts) => {
                let engine = self.analysis.engine();
                let (question, sink) = (self.question, &self.job.sink);
                let overlap = question.overlap.as_ref();
                let players = PlayerSummary::all(&question.program, self.analysis.whole_engine())?;
                self.job.update(|r| r.check().players = players);
                engines::warn_of_states(sink, engine, &question.program, &counts.deadlocks, overlap)
            }
            None => Ok(()),
        }
    }

    fn warn_of_empty_targets(&self) -> Result<(), Error> {
        for found in &self.analysis.result().objectives {
            if found.target == Count::ZERO {
                let goal = &self.question.preferences.objectives[found.objective].goal;
                self.job.sink.warn(&self.why_empty(&found.name, goal)?);
            }
        }
        Ok(())
    }

    /// Says why no state satisfies the target of an objective.
    fn why_empty(&self, name: &str, goal: &Goal) -> Result<String, Error> {
        let whole = self.analysis.whole_engine();
        let Goal::Reach(target) = goal else {
            return Ok(format!("no strategy can guarantee the objective `{name}`"));
        };
        Ok(if is_never_true(&self.question.program, target) {
            format!("the target of objective `{name}` is false for all values that its variables can have")
        } else if !whole.is_empty(&whole.states_where(target)?)? {
            format!("the requirements exclude all states that satisfy the target of objective `{name}`")
        } else if whole.settings().scope == Scope::Reachable {
            format!("no path reaches a state that satisfies the target of objective `{name}`")
        } else {
            format!("no state satisfies the target of objective `{name}`")
        })
    }
}
