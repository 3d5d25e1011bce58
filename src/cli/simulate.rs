//! `meliora simulate`: random runs under a strategy.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;
use meliora::Task;
use meliora::commands::check::levels;
use meliora::commands::listed;
use meliora::commands::strategies::{Runs, opponent};
use meliora_base::error::Error;
use meliora_engine::Engine;
use meliora_model::Program;
use meliora_planning::tally::Trace;
use meliora_planning::{Opponent, Scheduler, Setup, StrategyKind};
use meliora_report::SimulateReport;
use meliora_report::policy_report::PolicyRuns;
use meliora_report::simulate_csv::{RunLines, RunStart};

use super::by_name::by_name;
use super::choose::{ChooseArgs, Prepared, validate_scheduler};
use super::exit::Status;
use super::files::{Pieces, Target};
use super::options::{EngineArgs, ModelArgs, PreferenceArgs, ShownArgs};
use super::plan::{self, Arguments};
use super::policy_file::{PolicyFile, optional_with_policy};
use super::supervise::{Job, supervise};
use super::terminal;

/// Simulate random runs under a strategy and count improvements, achievements and weakenings
///
/// The strategy chooses the actions, and the probabilities of the model choose the successors. In a
/// game, `--opponent` chooses the actions of the other side.
/// After each improvement a run continues at the level of the new state. The default, a plan, makes
/// all guaranteed improvements and then achieves a most preferred objective.
#[derive(Debug, Clone, Args)]
#[command(mut_arg("preferences", optional_with_policy))]
#[command(after_help = "Examples:
  meliora simulate models/robot5x5.prism models/robot5x5.pref
  meliora simulate models/robot5x5.prism models/robot5x5.pref --kind spi --scheduler permissive --seed 7")]
pub(super) struct SimulateArgs {
    #[command(flatten)]
    model: ModelArgs,
    #[command(flatten)]
    preferences: PreferenceArgs,

    /// Run this policy from the initial states: a file that `strategy --policy` has written for PREFS; or one that
    /// `reach --policy` or a planner for FOND problems has written, until it reaches the goal: PREFS is left out.
    /// For `multi(…)`, a strategy is drawn for each run
    #[arg(long, value_name = "FILE", conflicts_with_all = ["at", "csv", "statistics", "opponent"])]
    policy: Option<PathBuf>,

    /// Goal of the policy [default: the goal of the planning problem]
    #[arg(long, value_name = "EXPR", requires = "policy", allow_hyphen_values = true)]
    target: Option<String>,

    #[command(flatten)]
    choose: ChooseArgs,

    /// Permitted actions that runs take
    #[arg(long, value_parser = by_name::<Scheduler>(), default_value = Scheduler::Progress.name())]
    scheduler: Scheduler,

    /// Choices of the opponent of a game [default: random]
    #[arg(long, value_parser = by_name::<Opponent>())]
    opponent: Option<Opponent>,

    /// Number of runs
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = clap::value_parser!(u64).range(1..))]
    runs: u64,

    /// Stop a run after this number of steps (at most 1000000)
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = clap::value_parser!(u64).range(1..=MOST_STEPS))]
    steps: u64,

    /// Seed of the random numbers: the same seed gives the same runs
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,

    /// State where runs start, such as r=2,c=2 or r=2,c=*; variables left out have their initial
    /// value, `*` is any value (repeatable) [default: the initial states]
    #[arg(long, value_name = "STATE", allow_hyphen_values = true)]
    at: Vec<String>,

    /// Maximum number of initial states, and of states for an `--at` with `*`, where runs start
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = clap::value_parser!(u32).range(1..))]
    limit: u32,

    /// Write the runs to this file as comma-separated values, one line per step: the state entered, the
    /// action, and events such as improvements; `-` is standard output
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,

    /// Write to this file how many runs made each number of improvements, and the steps until then, as
    /// comma-separated values; `-` is standard output
    #[arg(long, value_name = "FILE")]
    statistics: Option<PathBuf>,

    #[command(flatten)]
    engine: EngineArgs,
    #[command(flatten)]
    shown: ShownArgs,
}

/// Upper bound of `--steps`. A run is kept in memory until it ends.
const MOST_STEPS: u64 = 1_000_000;

impl SimulateArgs {
    /// Runs a policy.
    fn follow(&self, policy: &Path) -> Result<Status, Error> {
        let preferences = &self.preferences.preferences;
        let following = PolicyFile {
            policy: policy.to_owned(),
            preferences: (!preferences.as_os_str().is_empty()).then(|| preferences.clone()),
            coalition: self.model.coalition.clone(),
            model: self.model.model.clone(),
            constants: self.model.constants(),
            bounds: self.model.bounds(),
            target: self.target.clone(),
            limits: self.model.limits(),
        };
        let runs = PolicyRuns { runs: self.runs, limit: self.steps, seed: self.seed, ..Default::default() };
        following.simulate(runs, &self.shown)
    }

    fn setup(&self) -> Setup {
        Setup { scheduler: self.scheduler, runs: self.runs, steps: self.steps, seed: self.seed }
    }
}

/// Runs the command.
///
/// # Errors
/// The input is wrong, or a limit is hit.
pub(super) fn run(args: SimulateArgs) -> Result<Status, Error> {
    if let Some(policy) = &args.policy {
        return args.follow(policy);
    }
    args.engine.validate(&args.model)?;
    args.choose.validate()?;
    validate_scheduler(args.choose.choose, args.scheduler)?;
    let kind = args.choose.kind(StrategyKind::Plan)?;
    let header = args.engine.header(args.preferences.header(&args.model));
    let report = SimulateReport::of_setup(header, kind, args.choose.shown(), args.setup());
    let inputs = args.preferences.inputs(&args.model);
    let target = |file: &Option<PathBuf>| Target::maybe(file.as_deref(), &inputs);
    let (csv, statistics) = (target(&args.csv)?, target(&args.statistics)?);
    if [&csv, &statistics].iter().all(|target| target.as_ref().is_some_and(Target::is_stdout)) {
        let message = "`--csv` and `--statistics` cannot both be on standard output; give one a file";
        return Err(Error::Usage(message.to_owned()));
    }
    let printed = [&csv, &statistics].into_iter().flatten().find(|target| target.is_stdout());
    let (limits, shown) = (args.model.limits(), args.shown.with_csv(printed)?);
    supervise(report, limits, &shown, move |job| {
        let program = work(job, &args, kind, csv.as_ref())?;
        let Some(statistics) = &statistics else { return Ok(()) };
        let mut lines = String::new();
        job.update(|r| lines = r.statistics(&program));
        statistics.write(&lines)
    })
}

fn work(
    job: &Job<SimulateReport>,
    args: &SimulateArgs,
    kind: StrategyKind,
    csv: Option<&Target>,
) -> Result<Arc<Program>, Error> {
    let given = Arguments { model: &args.model, preferences: &args.preferences, engine: &args.engine };
    let check = |program: &Program| {
        let opponent = opponent(program, args.opponent)?;
        job.update(|r| r.opponent = opponent);
        Ok(())
    };
    let prepared = args.choose.prepared(job, given, &args.at, kind, check)?;
    simulate(job, given, &prepared, args, csv)?;
    Ok(prepared.task.program)
}

fn simulate(
    job: &Job<SimulateReport>,
    given: Arguments<'_>,
    Prepared { task, wanted, at }: &Prepared,
    args: &SimulateArgs,
    csv: Option<&Target>,
) -> Result<(), Error> {
    let limit = args.limit as usize;
    let (engine, starts, analysis) = plan::raced(job, given, task, &|job, engine| {
        let starts = if at.is_empty() {
            listed(&**engine, &engine.initial_states(), limit, &|text| job.sink.note(text))?.0
        } else {
            at.states(&**engine, &task.program, limit, &|text| job.sink.warn(text))?
        };
        let analyse = || levels(job, engine, task, args.preferences.options(), wanted.phases());
        let analysis = job.timed("levels", analyse, |r, s| r.time.add("levels", s))?;
        Ok((Arc::clone(engine), starts, analysis))
    })?;
    let mut strategy = wanted.strategy(&analysis, &task.program)?;
    let attach = || wanted.attach(&analysis, &task.program, &starts, &mut strategy);
    let chooser = job.timed("values", attach, |r, s| args.choose.count(&mut r.time, s))?;
    let (setup, opponent) = (args.setup(), args.opponent.unwrap_or_default());
    // The text tells whether other improvements are possible where none is guaranteed.
    let runs = Runs { task, analysis: &analysis, chooser, setup, opponent, advises: !args.shown.json };
    let mut table = Table::begin(task, csv, args.statistics.as_deref())?;
    let all = || {
        runs.run(job, &mut strategy, &starts, &mut |from, trace| table.add(from, trace))?;
        table.finish()
    };
    job.timed("answer", all, |r, s| r.time.add("answer", s))?;
    job.update(|r| r.used(engine.usage()));
    Ok(())
}

/// The lines of the runs, if they are asked for.
struct Table<'a> {
    lines: RunLines<'a>,
    out: Option<Pieces<'a>>,
    /// True if the lines are the only result.
    is_alone: bool,
}

impl<'a> Table<'a> {
    fn begin(task: &'a Task, csv: Option<&'a Target>, statistics: Option<&Path>) -> Result<Self, Error> {
        let lines = RunLines { program: &task.program, preferences: &task.preferences };
        let mut out = csv.map(Target::pieces).transpose()?;
        if let Some(out) = &mut out {
            out.push(&lines.heading())?;
        }
        let is_alone = csv.is_some_and(Target::is_stdout) && statistics.is_none();
        Ok(Table { lines, out, is_alone })
    }

    fn add(&mut self, start: &RunStart<'_>, trace: &Trace) -> Result<(), Error> {
        let Some(out) = &mut self.out else { return Ok(()) };
        out.push(&self.lines.rows(start, trace))?;
        if self.is_alone && out.is_closed() { Err(terminal::unread()) } else { Ok(()) }
    }

    fn finish(self) -> Result<(), Error> {
        self.out.map_or(Ok(()), Pieces::finish)
    }
}
