//! `meliora strategy`: the actions that a strategy permits, with reasons.

use std::path::PathBuf;
use std::sync::{Arc, Mutex};

use clap::Args;
use meliora::supervise::lock;
use meliora_base::error::{Error, Limit};
use meliora_engine::{Algebra, Count, Engine};
use meliora_model::{Program, State};
use meliora_planning::induced_model::{Node, Unfolding};
use meliora_planning::{
    Analysis, FiniteMemoryStrategy, InducedModel, Kind, Phase, Rank, Scheduler, StrategyKind,
};
use meliora_quantities::ValuedRule;
use meliora_quantities::cost::Costs;
use meliora_question::strategies::MOST_STATES;
use meliora_report::choose::Attains;
use meliora_report::reason::Words;
use meliora_report::state::{Place, StateReport};
use meliora_report::{Number, StrategyReport, Style, Written, strategy_table};

use super::at;
use super::by_name::by_name;
use super::check;
use super::choose::{ChooseArgs, Prepared};
use super::exit::Status;
use super::files::{Pieces, Target};
use super::load::Question;
use super::node_policy::NodePolicyWriter;
use super::objective_policy::{OfObjective, policy_of};
use super::options::{EngineArgs, ModelArgs, PreferenceArgs, ShownArgs};
use super::plan::{self, Arguments};

use super::policy_file::optional_with_policy;
use super::supervise::{Job, supervise};
use super::terminal;

/// Maximum number of nodes of the induced model that the text lists.
const MOST_NODES: usize = 60;

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
    rank: Option<Asked>,

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
enum Asked {
    Exactly(usize),
    Unbounded,
}

fn rank(text: &str) -> Result<Asked, String> {
    match text {
        "unbounded" => Ok(Asked::Unbounded),
        _ => text.parse().map(Asked::Exactly).map_err(|_| "expected a number or `unbounded`".to_owned()),
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
    let question = lock(&left).take();
    let scheduler = args.scheduler.unwrap_or(Scheduler::Progress);
    NodePolicyWriter { model, preferences, choose, engine, kind, scheduler, all: args.all, limit, policy }
        .write(question, &shown)
}

fn work(
    job: &Job<StrategyReport>,
    args: &StrategyArgs,
    kind: StrategyKind,
    csv: Option<&Target>,
) -> Result<(), Error> {
    let given = Arguments { model: &args.model, preferences: &args.preferences, engine: &args.engine };
    let prepared = args.choose.prepared(job, given, &args.at, kind, |_| Ok(()))?;
    let Prepared { question, at, costs, .. } = &prepared;
    let (engine, states, analysis) = plan::raced(job, given, question, &|job, engine| {
        let states = at.states(&**engine, &question.program, args.model.scope, args.limit(), &job.sink)?;
        if args.all {
            // Levels may take much longer than counting.
            refuse_more(&engine.count(&engine.all_states())?, args.limit())?;
        }
        let both = [Phase::Sasi, Phase::Spi];
        let levels = || plan::analysis(engine, question, &args.preferences, &both, &job.sink);
        let analysis = job.timed("levels", levels, |r, s| r.time.add("levels", s))?;
        Ok((Arc::clone(engine), states, analysis))
    })?;
    let strategy = args.choose.strategy(&analysis, &question.program, kind)?;
    let mut answering =
        Answering { job, question, args, csv, analysis: &analysis, strategy, costs, chooser: None };
    job.timed("answer", || answering.answer(states), |r, s| r.time.add("answer", s))?;
    job.update(|r| r.used(engine.usage()));
    Ok(())
}

/// Refuses a scope with more states than the limit.
///
/// # Errors
/// [`Limit::Size`] with the number of states.
fn refuse_more(count: &Count, limit: usize) -> Result<(), Error> {
    if *count <= Count::from(limit) {
        return Ok(());
    }
    let grouped = Number(count.clone()).grouped();
    let what = format!(
        "the scope has {grouped} states, more than `--limit {limit}`; `--limit {count}` or more covers all"
    );
    Err(Limit::Size { what }.into())
}

/// An analysis with the report that receives its results.
struct Answering<'a, E: Engine> {
    job: &'a Job<StrategyReport>,
    question: &'a Question,
    args: &'a StrategyArgs,
    csv: Option<&'a Target>,
    analysis: &'a Analysis<E>,
    strategy: FiniteMemoryStrategy<E>,
    costs: &'a Costs,
    /// The decision rule of the strategy, if it depends on values.
    chooser: Option<Arc<dyn ValuedRule>>,
}

impl<'a, E: Engine> Answering<'a, E> {
    fn answer(&mut self, given: Vec<State>) -> Result<(), Error> {
        let states = match self.args.at.is_empty() {
            _ if self.args.all => self.everywhere()?,
            true => self.found()?,
            false => given,
        };
        let choose = &self.args.choose;
        let attach =
            || choose.attach(self.analysis, self.costs, &self.question.program, &states, &mut self.strategy);
        self.chooser = self.job.timed("values", attach, |r, s| choose.count(&mut r.time, s))?;
        if self.args.dot {
            return self.draw(&states);
        }
        let mut output = Output::begin(self.job, self.args, self.csv, &self.question.program)?;
        if self.args.all {
            self.unfold(&states, &mut output)?;
        } else {
            for state in states {
                self.job.sink.check()?;
                output.add(&self.state(&state)?)?;
            }
        }
        output.finish()
    }

    /// Adds all states with the memories that paths may have there.
    ///
    /// # Errors
    /// There are more than the limit; other limits.
    fn unfold(&mut self, starts: &[State], output: &mut Output<'_>) -> Result<(), Error> {
        // A rule takes one action; without one, all permitted actions may be taken.
        let scheduler = if self.chooser.is_some() { Scheduler::Progress } else { Scheduler::Permissive };
        let (words, limit, analysis) = (self.words(), self.args.limit(), self.analysis);
        let mut unfolding = Unfolding::new(&mut self.strategy, starts, scheduler, limit)?;
        let mut number = 0;
        while let Some(Node { at, next }) = unfolding.next_node()? {
            if !unfolding.complete {
                return Err(Limit::Listed(limit as u64).into());
            }
            let rank = |kind| analysis.rank(kind, &at.state);
            let attains = self.chooser.as_ref().and_then(|rule| rule.attained(&at.state));
            output.add(&StateReport {
                words,
                ranks: [rank(Kind::Sasi)?, rank(Kind::Spi)?],
                choosing: self.args.choose.shown(),
                attains: attains.as_ref().map(Attains::new),
                unfolded: None,
                cycle: None,
                place: Some(Place { node: number, is_start: number < starts.len(), next }),
                at,
            })?;
            number += 1;
        }
        Ok(())
    }

    /// Returns whether the lines are printed as soon as they are known, in place of the text.
    fn streams(&self) -> bool {
        self.csv.is_some_and(Target::is_stdout)
    }

    /// Returns all states of the scope.
    ///
    /// # Errors
    /// Limits.
    fn everywhere(&self) -> Result<Vec<State>, Error> {
        let engine = self.analysis.whole_engine();
        let all = engine.all_states();
        let count = engine.count(&all)?;
        self.job.update(|r| r.asked = Some(count.into()));
        engine.list_states(&all, self.args.limit())
    }

    /// Returns the states of the requested rank, or else the initial states, up to the limit.
    fn found(&self) -> Result<Vec<State>, Error> {
        let engine = self.analysis.engine();
        let set = match self.args.rank {
            None => engine.initial_states(),
            Some(Asked::Unbounded) => self.strategy.states_of_rank(None)?,
            Some(Asked::Exactly(k)) => self.strategy.states_of_rank(Some(k))?,
        };
        let (states, count) = at::listed(engine, &set, self.args.limit(), &|text| self.job.sink.note(text))?;
        self.job.update(|r| r.asked = Some(count.into()));
        Ok(states)
    }

    /// Returns the texts of the model and the preferences.
    fn words(&self) -> Words<'a> {
        let (program, preferences) = (&*self.question.program, &*self.question.preferences);
        Words { program, preferences, kind: self.strategy.kind(), levels: self.strategy.levels() }
    }

    fn state(&mut self, state: &[i64]) -> Result<StateReport<'a>, Error> {
        let ranks = [self.analysis.rank(Kind::Sasi, state)?, self.analysis.rank(Kind::Spi, state)?];
        let memory = self.strategy.start(state)?;
        let at = self.strategy.explain(state, memory)?;
        // In a list of states, the induced model is left out.
        let mut unfolded = None;
        if self.args.rank.is_none()
            && !self.streams()
            && (memory.level != Rank::Finite(0) || !at.aims.is_empty())
        {
            let (starts, scheduler) = ([state.to_vec()], Scheduler::Progress);
            unfolded = Some(InducedModel::unfold(&mut self.strategy, &starts, scheduler, MOST_NODES)?);
        }
        let cycle = match unfolded.is_some() && memory.level == Rank::Unbounded {
            true => check::cycle(self.analysis, self.question, self.strategy.levels(), state)?,
            false => None,
        };
        let attains = self.chooser.as_ref().and_then(|rule| rule.attained(state));
        let attains = attains.as_ref().map(Attains::new);
        Ok(StateReport {
            words: self.words(),
            at,
            ranks,
            choosing: self.args.choose.shown(),
            attains,
            unfolded,
            cycle,
            place: None,
        })
    }

    fn draw(&mut self, states: &[State]) -> Result<(), Error> {
        let limit = self.args.limit();
        let unfolded = InducedModel::unfold(&mut self.strategy, states, Scheduler::Permissive, limit)?;
        if !unfolded.complete {
            self.job.sink.warn(&format!("the graph ends after {limit} nodes; a larger `--limit` shows more"));
        }
        let dot = strategy_table::dot(self.words(), &unfolded, states.len());
        self.job.update(|r| r.drawing = Some(dot));
        Ok(())
    }
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
