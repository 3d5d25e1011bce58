//! `meliora reach`: the four qualitative regions of a target, or of a temporal formula.

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use meliora::reach::{Asking, Target, Under};
use meliora_engine::regions::{self, Step, Which};
use meliora_engine::{Count, Engine};
use meliora_model::error::Error;
use meliora_model::expr::ExprId;
use meliora_planning::temporal;
use meliora_quantities::answer::PRECISION;
use meliora_report::ReachReport;
use meliora_report::reach::Share;

use super::exit::Status;
use super::load::{self, Asked, Stated};
use super::options::{EngineArgs, ModelArgs, ShownArgs};
use super::properties;
use super::supervise::{Job, supervise};
use super::sweep::{self, SweepArgs};

/// Compute from which states a target is reached, or a temporal formula satisfied, surely or
/// possibly
#[derive(Debug, Clone, Args)]
#[command(group = clap::ArgGroup::new("question").required(true))]
pub(super) struct ReachArgs {
    #[command(flatten)]
    model: ModelArgs,

    /// Target: an expression over the model's variables, such as 'x = 3 & "goal"'; see --property
    /// for other questions
    #[arg(long, value_name = "EXPR", group = "question", allow_hyphen_values = true)]
    target: Option<String>,

    /// Property to check in the initial states, such as 'P>=1 [ F "goal" ]', 'Pmax=? [ G F a ]' or
    /// 'R{"cost"}min=? [ F "goal" ]' (repeatable)
    #[arg(long, value_name = "PROPERTY", group = "question")]
    property: Vec<String>,

    /// PRISM property file: answers the supported properties, and gives a reason for the others
    #[arg(long, value_name = "FILE", group = "question")]
    properties: Option<PathBuf>,

    /// Check only the property with this name
    #[arg(long, value_name = "NAME", requires = "properties")]
    only: Option<String>,

    /// Formula G p that no path may violate; only strategies that surely keep it count (repeatable)
    #[arg(long, value_name = "FORMULA", allow_hyphen_values = true)]
    require: Vec<String>,

    /// Largest width of a value, absolute for probabilities, relative above 1 for rewards
    #[arg(long, value_name = "X", default_value_t = PRECISION, value_parser = super::options::precision)]
    precision: f64,

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
pub(super) fn run(args: ReachArgs) -> Result<Status, Error> {
    args.engine.validate(&args.model)?;
    if let Some(status) = args.sweep.run(&args.model, &[], sweep::Job::Reach, &args.shown)? {
        return Ok(status);
    }
    if let Some(file) = args.properties {
        let ReachArgs { model, engine, only, require, precision, shown, .. } = args;
        let questions = properties::Questions { model, engine, file, only, require, precision };
        return properties::run(questions, &shown);
    }
    if args.property.len() > 1 {
        let ReachArgs { model, engine, property, require, precision, shown, .. } = args;
        return properties::several(model, engine, (property, require, precision), &shown);
    }
    let asked = args.target.as_ref().or(args.property.first()).cloned().unwrap_or_default();
    let header = args.engine.header(args.model.header());
    let report = ReachReport::of_expression(header, &asked);
    let (limits, shown) = (args.model.limits(), args.shown.of(&args.model));
    supervise(report, limits, &shown, move |job| work(job, &args))
}

fn work(job: &Job<ReachReport>, args: &ReachArgs) -> Result<(), Error> {
    let read =
        || load::asked(&args.model, args.target.as_deref(), (&args.property, &args.require), &job.sink);
    let asked = job.timed("parse", read, |r, s| r.time.add("parse", s))?;
    let Some(Stated { asking, .. }) = asked.questions.first() else { return Ok(()) };
    let program = asking.goal.program(&asked.program);
    let mut selected = args.engine.select([&**program], &args.model);
    job.update(|r| {
        r.header.read(&asked.program);
        r.header.select(&selected);
    });
    let build = || load::engine_for(&[asking], program, &args.model, &mut selected, &job.sink);
    let engine = job.timed("build", build, |r, s| r.time.add("build", s))?;
    job.update(|r| r.header.select(&selected));
    answer(job, &*engine, &asked, asking, args.precision)
}

/// Computes the four regions. Each is added to the report as soon as it is known.
fn answer<E: Engine>(
    job: &Job<ReachReport>,
    engine: &E,
    asked: &Asked,
    asking: &Asking,
    precision: f64,
) -> Result<(), Error> {
    let played = asking.played(engine)?;
    let engine = played.as_ref().unwrap_or(engine);
    let under = Under::new(engine, &asked.program, &asking.goal)?;
    // Counting is a part of building.
    let count = || under.counts(&asking.goal);
    let counts = job.timed("count", count, |r, s| r.time.add("build", s))?;
    load::warn_of_states(&job.sink, engine, &asked.program, &counts.deadlocks, asked.overlap)?;
    job.update(|r| (r.counts, r.escape) = (Some(counts), under.escape.clone()));
    let engine = under.engine();
    let judged = asking.goal.judged(engine)?;
    let mut search = Search { job, engine, judged, start: Instant::now() };
    let found = match &asking.goal.target {
        Target::States(target) => {
            let states = search.target(*target)?;
            regions::regions_by_step(engine, &states, &mut |step| search.hear(step))?
        }
        Target::Formula(condition) => {
            temporal::regions_by_step(engine, condition, &mut |step| search.hear(step))?
        }
    };
    let answered = || under.answer(asking, &asked.program, &found, precision);
    let answer = job.timed("value", answered, |r, s| {
        if asking.question.is_some() {
            r.time.add("value", s);
        }
    })?;
    job.update(|r| {
        (r.holds, r.value, r.no_value) = (answer.holds, answer.value, answer.no_value);
        if asking.question.is_some() {
            r.list_property();
        }
    });
    answer.end
}

/// Returns the name of a region as a phase.
fn phase(which: Which) -> &'static str {
    match which {
        Which::PmaxPositive => "Pmax > 0",
        Which::PmaxOne => "Pmax = 1",
        Which::PminPositive => "Pmin > 0",
        Which::PminOne => "Pmin = 1",
    }
}

struct Search<'a, E: Engine> {
    job: &'a Job<ReachReport>,
    engine: &'a E,
    /// The states whose paths are judged: with monitors, the states where these are fresh.
    judged: E::States,
    /// The time at which the search for the present region began.
    start: Instant,
}

impl<E: Engine> Search<'_, E> {
    /// Returns the states of a target and adds their number to the report.
    fn target(&self, target: ExprId) -> Result<E::States, Error> {
        let states = self.engine.states_where(target)?;
        let size = self.engine.count(&states)?;
        if size == Count::ZERO {
            self.job.sink.warn("no state satisfies the target");
        }
        self.job.update(|r| r.target = Some(size.into()));
        Ok(states)
    }

    /// Adds the judged states of each region to the report.
    fn hear(&mut self, step: Step<'_, E::States>) -> Result<(), Error> {
        let (which, states) = match step {
            Step::Begun(which) => {
                self.start = self.job.begin(phase(which));
                return Ok(());
            }
            Step::Found(which, states) => (which, states),
        };
        let judged = self.engine.intersection(states, &self.judged)?;
        self.job.end(phase(which), self.start, |r, s| r.time.add(which.name(), s));
        let size = self.engine.count(&judged)?;
        let share = self.share(&judged)?;
        self.job.update(|r| {
            *r.sizes.get_mut(which) = Some(size.into());
            *r.initial.get_mut(which) = Some(share);
            r.memory.peak_nodes = self.engine.usage().peak_nodes;
        });
        Ok(())
    }

    /// Returns how many of the initial states are in the set: all, some or none.
    fn share(&self, states: &E::States) -> Result<Share, Error> {
        let initial = self.engine.initial_states();
        let inside = self.engine.intersection(&initial, states)?;
        if self.engine.same(&inside, &initial)? {
            return Ok(Share::All);
        }
        Ok(if self.engine.is_empty(&inside)? { Share::None } else { Share::Some })
    }
}
