//! `meliora strategy`: the actions that a strategy permits, with reasons.

use std::path::PathBuf;
use std::sync::{Arc, Mutex};

use clap::Args;
use meliora::commands::check::levels;
use meliora::commands::listed;
use meliora::commands::strategies::{Explaining, StrategyOptions, refuse_more};
use meliora::supervise::lock;
use meliora_base::error::Error;
use meliora_engine::{Algebra, Engine};
use meliora_model::{Program, State};
use meliora_planning::{Phase, Scheduler, StrategyKind};
use meliora_question::strategies::MOST_STATES;
use meliora_report::state::StateReport;
use meliora_report::{StrategyReport, Style, Written, strategy_table};

use super::by_name::by_name;
use super::choose::{ChooseArgs, Prepared};
use super::exit::Status;
use super::files::{Pieces, Target};
use super::node_policy::NodePolicyWriter;
use super::objective_policy::{OfObjective, policy_of};
use super::options::{EngineArgs, ModelArgs, PreferenceArgs, ShownArgs};
use super::plan::{self, Arguments};

use super::policy_file::optional_with_policy;
use super::supervise::{Job, supervise};
use super::terminal;

/// Explain which actions a strategy permits in a state, and why
///
/// Prints for each state its most preferred objectives, its ranks, every enabled action with its
/// successors, and the reason why the strategy permits the action or not. In a game, a state of the
/// opponent has all its actions, with what each of them leads to.
#[derive(Debug, Clone, Args)]
#[command(mut_arg("preferences", optional_with_policy))]
#[command(after_help = "Examples:
  meliora strategy models/robot5x5.prism models/robot5x5.pref --rank 1 --limit 20 --csv states.csv
  meliora strategy models/drone.prism models/drone.pref --choose likely")]
pub(super) struct StrategyArgs {
    #[command(flatten)]
    model: ModelArgs,
    #[command(flatten)]
    preferences: PreferenceArgs,

    /// Write the strategy of the initial states, or of all with --all, as a policy that `verify` checks and `simulate`
    /// runs. If it achieves one target (--objective NAME, or `goal`): a list of rules, in the format of `reach
    /// --policy`; without PREFS, the objectives are those of the planning problem. Else: nodes with memory, as JSON
    #[arg(long, value_name = "FILE", conflicts_with_all = ["at", "rank", "csv", "dot"])]
    policy: Option<PathBuf>,

    /// Permitted actions that a policy takes [default: progress]
    #[arg(long, value_parser = by_name::<Scheduler>(), requires = "policy")]
    scheduler: Option<Scheduler>,

    #[command(flatten)]
    choose: ChooseArgs,

    /// State to explain, such as r=2,c=2 or r=2,c=*; variables left out have their initial value, `*` is
    /// any value (repeatable) [default: the initial states]
    #[arg(long, value_name = "STATE", conflicts_with = "rank", allow_hyphen_values = true)]
    at: Vec<String>,

    /// Explain all states of this rank: a number, or `unbounded`
    #[arg(long, value_name = "K", value_parser = rank)]
    rank: Option<RankChoice>,

    /// Explain all states of the scope, with all memories that paths from them may have: the whole
    /// strategy, as a table that other programs can follow
    #[arg(long, conflicts_with_all = ["at", "rank", "dot"])]
    all: bool,

    /// Maximum number of states to list; with --dot, of nodes; with --all, of states with memory, of which
    /// none is left out [default: 1000; with --all, 1000000]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    limit: Option<u32>,

    /// Write one line of comma-separated values per state and action to this file; `-` is standard output
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,

    /// Print the paths under the permissive strategy as a graph in the DOT language
    #[arg(long, conflicts_with_all = ["json", "csv"])]
    dot: bool,

    #[command(flatten)]
    engine: EngineArgs,
    #[command(flatten)]
    shown: ShownArgs,
}

impl StrategyArgs {
    /// Returns the maximum number of states.
    fn limit(&self) -> usize {
        self.limit.map_or(if self.all { 1_000_000 } else { 1000 }, |limit| limit as usize)
    }
}

/// The rank to list.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum RankChoice {
    Exactly(usize),
    Unbounded,
}

fn rank(text: &str) -> Result<RankChoice, String> {
    match text {
        "unbounded" => Ok(RankChoice::Unbounded),
        _ => text.parse().map(RankChoice::Exactly).map_err(|_| "expected a number or `unbounded`".to_owned()),
    }
}

/// Runs the command.
///
/// # Errors
/// The input is wrong, or a limit is hit.
pub(super) fn run(args: StrategyArgs) -> Result<Status, Error> {
    if let Some(policy) = args.policy.clone() {
        return write_policy(args, policy);
    }
    args.engine.validate(&args.model)?;
    args.choose.validate()?;
    let kind = args.choose.kind(StrategyKind::Sasi)?;
    let header = args.engine.header(args.preferences.header(&args.model));
    let report = StrategyReport::of_kind(header, kind, args.choose.shown());
    let inputs = args.preferences.inputs(&args.model);
    let csv = Target::maybe(args.csv.as_deref(), &inputs)?;
    let (limits, shown) = (args.model.limits(), args.shown.with_csv(csv.as_ref())?);
    supervise(report, limits, &shown, move |job| work(job, &args, kind, csv.as_ref()))
}

/// Writes a list of rules if one achieves the objective, else a policy with memory.
fn write_policy(args: StrategyArgs, policy: PathBuf) -> Result<Status, Error> {
    let left = Arc::new(Mutex::new(None));
    let is_plain = !args.all && args.scheduler.is_none() && args.choose.may_be_rules();
    let limit = args.limit.map_or(MOST_STATES, |limit| limit as usize);
    let StrategyArgs { model, preferences, choose, engine, shown, .. } = args;
    let kind = choose.kind_of_policy()?;
    if is_plain {
        let achieving = OfObjective {
            model: model.clone(),
            preferences: preferences.clone(),
            objective: choose.objective().map(str::to_owned),
            engine,
            left: Arc::clone(&left),
        };
        match policy_of(achieving, policy.clone(), &shown) {
            Err(_) if lock(&left).is_some() => {}
            end => return end,
        }
    }
    let task = lock(&left).take();
    let scheduler = args.scheduler.unwrap_or(Scheduler::Progress);
    NodePolicyWriter { model, preferences, choose, engine, kind, scheduler, all: args.all, limit, policy }
        .write(task, &shown)
}

fn work(
    job: &Job<StrategyReport>,
    args: &StrategyArgs,
    kind: StrategyKind,
    csv: Option<&Target>,
) -> Result<(), Error> {
    let given = Arguments { model: &args.model, preferences: &args.preferences, engine: &args.engine };
    let prepared = args.choose.prepared(job, given, &args.at, kind, |_| Ok(()))?;
    let Prepared { task, wanted, at } = &prepared;
    let (engine, states, analysis) = plan::raced(job, given, task, &|job, engine| {
        let states = at.states(&**engine, &task.program, args.limit(), &|text| job.sink.warn(text))?;
        if args.all {
            // Levels may take much longer than counting.
            refuse_more(&engine.count(&engine.all_states())?, args.limit())?;
        }
        let analyse = || levels(job, engine, task, args.preferences.options(), &[Phase::Sasi, Phase::Spi]);
        let analysis = job.timed("levels", analyse, |r, s| r.time.add("levels", s))?;
        Ok((Arc::clone(engine), states, analysis))
    })?;
    let strategy = wanted.strategy(&analysis, &task.program)?;
    let choosing = args.choose.shown();
    let explaining = Explaining { task, analysis: &analysis, strategy, choosing, chooser: None };
    let answer = || answer(job, args, (explaining, wanted), states, csv);
    job.timed("answer", answer, |r, s| r.time.add("answer", s))?;
    job.update(|r| r.used(engine.usage()));
    Ok(())
}

/// Explains the states that are asked for; `given` are those of `--at`.
fn answer<E: Engine>(
    job: &Job<StrategyReport>,
    args: &StrategyArgs,
    (mut explaining, wanted): (Explaining<'_, E>, &StrategyOptions),
    given: Vec<State>,
    csv: Option<&Target>,
) -> Result<(), Error> {
    let states = if args.at.is_empty() { found(job, args, &explaining)? } else { given };
    let (analysis, program) = (explaining.analysis, &explaining.task.program);
    let attach = || wanted.attach(analysis, program, &states, &mut explaining.strategy);
    explaining.chooser = job.timed("values", attach, |r, s| args.choose.count(&mut r.time, s))?;
    if args.dot {
        let (dot, is_complete) = explaining.graph(&states, args.limit())?;
        if !is_complete {
            let limit = args.limit();
            job.sink.warn(&format!("the graph ends after {limit} nodes; a larger `--limit` shows more"));
        }
        job.update(|r| r.drawing = Some(dot));
        return Ok(());
    }
    let mut output = Output::begin(job, args, csv, program)?;
    if args.all {
        explaining.everywhere(&states, args.limit(), &mut |state| output.add(state))?;
    } else {
        // In a list of states, and next to lines that are printed as soon as they are known, induced models are left out.
        let unfold = args.rank.is_none() && !csv.is_some_and(Target::is_stdout);
        for state in states {
            job.sink.check()?;
            output.add(&explaining.state(&state, unfold)?)?;
        }
    }
    output.finish()
}

/// Returns all states of the scope, those of the requested rank, or else the initial states, up to the limit.
fn found<E: Engine>(
    job: &Job<StrategyReport>,
    args: &StrategyArgs,
    Explaining { analysis, strategy, .. }: &Explaining<'_, E>,
) -> Result<Vec<State>, Error> {
    let (whole, engine) = (analysis.whole_engine(), analysis.engine());
    let (engine, set) = match args.rank {
        _ if args.all => (whole, whole.all_states()),
        None => (engine, engine.initial_states()),
        Some(RankChoice::Unbounded) => (engine, strategy.states_of_rank(None)?),
        Some(RankChoice::Exactly(k)) => (engine, strategy.states_of_rank(Some(k))?),
    };
    let (states, count) = listed(engine, &set, args.limit(), &|text| job.sink.note(text))?;
    job.update(|r| r.asked = Some(count.into()));
    Ok(states)
}

/// The receivers of the states: a table, and the text, the JSON report or neither.
struct Output<'a> {
    job: &'a Job<StrategyReport>,
    lines: Option<Pieces<'a>>,
    rest: Rest,
}

/// The receiver of the states in addition to a table.
#[derive(Clone, Copy, PartialEq)]
enum Rest {
    /// The report, as text in this style or as JSON.
    Report(Option<Style>),
    /// Standard output, as text in this style: a whole strategy need not be in memory.
    Printed(Style),
    /// None: the table stands for the report.
    Table,
}

impl<'a> Output<'a> {
    fn begin(
        job: &'a Job<StrategyReport>,
        args: &StrategyArgs,
        csv: Option<&'a Target>,
        program: &Program,
    ) -> Result<Self, Error> {
        let mut lines = csv.map(Target::pieces).transpose()?;
        if let Some(lines) = &mut lines {
            lines.push(&strategy_table::csv_heading(program, args.all))?;
        }
        let rest = match (args.shown.json, csv) {
            (true, _) => Rest::Report(None),
            (false, Some(csv)) if csv.is_stdout() || args.all => Rest::Table,
            (false, None) if args.all => Rest::Printed(terminal::stdout_style()),
            (false, _) => Rest::Report(Some(terminal::stdout_style())),
        };
        let place = match (&rest, csv) {
            (Rest::Printed(_), _) => Written::Text,
            (_, Some(csv)) if csv.is_regular() => Written::File,
            _ => Written::Lines,
        };
        job.update(|r| (r.whole, r.place) = (args.all, place));
        if let Rest::Printed(style) = rest {
            let mut head = String::new();
            job.update(|r| head = r.head(style));
            terminal::print(&head)?;
        }
        Ok(Output { job, lines, rest })
    }

    /// Adds a state.
    ///
    /// # Errors
    /// A destination cannot be written; nobody reads the only one.
    fn add(&mut self, state: &StateReport<'_>) -> Result<(), Error> {
        if let Some(lines) = &mut self.lines {
            lines.push(&strategy_table::csv_rows(state))?;
        }
        match self.rest {
            Rest::Report(style) => self.job.update(|r| r.push(state, style)),
            Rest::Printed(style) => {
                terminal::print(&StrategyReport::state_text(state, style))?;
                self.job.update(|r| r.written += 1);
            }
            Rest::Table => self.job.update(|r| r.written += 1),
        }
        let is_unread = match self.rest {
            Rest::Report(_) => false,
            Rest::Printed(_) => terminal::is_closed(),
            Rest::Table => self.lines.as_ref().is_some_and(Pieces::is_closed),
        };
        if is_unread { Err(terminal::unread()) } else { Ok(()) }
    }

    fn finish(self) -> Result<(), Error> {
        self.lines.map_or(Ok(()), Pieces::finish)
    }
}
