//! `meliora values`: how likely improvements are, how soon they come, and at what cost.

use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;
use meliora::NamedStates;
use meliora::commands::check::levels;
use meliora::commands::listed as listed_states;
use meliora::commands::values::{ValuesWanted, values};
use meliora_base::csv::Lines;
use meliora_base::error::Result;
use meliora_engine::{Algebra, AnyEngine, Count, Engine};
use meliora_model::State;
use meliora_planning::Phase;
use meliora_quantities::Steps;
use meliora_quantities::cost::Costs;
use meliora_report::ValuesReport;

use super::choose::costs;
use super::exit::Status;
use super::files::Target;
use super::load;
use super::options::{self, EngineArgs, ModelArgs, PreferenceArgs, ShownArgs};
use super::plan::{self, Arguments};
use super::supervise::{Job, supervise};

/// The number of states that the text lists if a file has all.
const SHOWN: usize = 100;

/// Compute how likely improvements are, how soon they come, and at what cost
///
/// Prints for each state and number of improvements the greatest probability to make them, the
/// least expected cost where they are certain, and both for each action that the safety mode
/// keeps, the best action first. All numbers are bounds that contain the true value.
#[derive(Debug, Clone, Args)]
#[command(after_help = "Examples:
  meliora values models/drone.prism models/drone.pref
  meliora values models/robot5x5.prism models/robot5x5.pref --all --levels 2 --csv values.csv")]
pub(super) struct ValuesArgs {
    #[command(flatten)]
    model: ModelArgs,
    #[command(flatten)]
    preferences: PreferenceArgs,

    /// State to evaluate, such as r=2,c=2 or r=2,c=*; variables left out have their initial value, `*` is
    /// any value (repeatable) [default: the initial states]
    #[arg(long, value_name = "STATE", conflicts_with = "all", allow_hyphen_values = true)]
    at: Vec<String>,

    /// Evaluate all states of the scope
    #[arg(long)]
    all: bool,

    /// Maximum number of states to list
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = clap::value_parser!(u32).range(1..))]
    limit: u32,

    /// Greatest number of improvements [default: the levels found, at most 10]
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u32).range(1..))]
    levels: Option<u32>,

    /// Reward structure that is the cost of a step; `steps`: each step costs 1, even if the model
    /// has a structure with this name
    #[arg(long, value_name = "NAME", default_value = Steps::NAME)]
    reward: String,

    /// Compute also what the first improvement gains, and how likely each gain is, under the strategy that
    /// makes it most likely
    #[arg(long, conflicts_with = "all")]
    by_goal: bool,

    /// Compute also the probabilities of success within 0, 1, …, N steps
    #[arg(long, value_name = "N")]
    within: Option<u32>,

    /// Largest width of a result, absolute for probabilities, relative above 1 for other numbers
    #[arg(long, value_name = "X", default_value_t = 1e-6, value_parser = options::precision)]
    precision: f64,

    /// Compute with fractions; for small models
    #[arg(long)]
    exact: bool,

    /// Write all values to a file, as comma-separated values
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,

    #[command(flatten)]
    engine: EngineArgs,
    #[command(flatten)]
    shown: ShownArgs,
}

/// Runs the command.
///
/// # Errors
/// The input is wrong, or a limit is hit.
pub(super) fn run(args: ValuesArgs) -> Result<Status> {
    args.engine.validate(&args.model)?;
    let inputs = args.preferences.inputs(&args.model);
    let csv = Target::maybe(args.csv.as_deref(), &inputs)?;
    let header = args.engine.header(args.preferences.header(&args.model));
    let report = ValuesReport::of_cost(header, &args.reward, args.precision);
    let (limits, shown) = (args.model.limits(), args.shown.with_csv(csv.as_ref())?);
    supervise(report, limits, &shown, move |job| work(job, &args, csv.as_ref()))
}

fn work(job: &Job<ValuesReport>, args: &ValuesArgs, csv: Option<&Target>) -> Result<()> {
    let arguments = Arguments { model: &args.model, preferences: &args.preferences, engine: &args.engine };
    let (task, (at, costs)) = plan::read(job, arguments, |task| {
        load::note_assumed(&task.program, &job.sink);
        let at = NamedStates::read(&task.program, "--at", &args.at)?;
        Ok((at, costs(&task.program, &args.reward, &job.sink)?))
    })?;
    job.update(|r| r.header.history = task.preferences.whole_paths());
    let limit = args.limit as usize;
    let lines = plan::raced(job, arguments, &task, &|job, engine| {
        let given = at.states(&**engine, &task.program, limit, &|text| job.sink.warn(text))?;
        let phases = [Phase::Counts, Phase::Sasi, Phase::Spi];
        let analyse = || levels(job, engine, &task, args.preferences.options(), &phases);
        let analysis = job.timed("levels", analyse, |r, s| r.time.add("levels", s))?;
        job.update(|r| r.counts = analysis.result().counts.clone());
        let states = if at.is_empty() { listed(job, args, engine)? } else { given };
        let everywhere = args.all && engine.count(&engine.all_states())? == Count::from(states.len());
        let wanted = ValuesWanted { everywhere, ..args.wanted(&costs, csv.is_some()) };
        let mut lines = csv.map(|_| Lines::default());
        let end = values(job, (&analysis, &task), &states, &wanted, lines.as_mut());
        job.update(|r| r.used(engine.usage()));
        end.map(|()| lines)
    })?;
    match csv.zip(lines) {
        Some((target, lines)) => target.write(&lines.text()),
        None => Ok(()),
    }
}

impl ValuesArgs {
    fn wanted(&self, costs: &Costs, is_table: bool) -> ValuesWanted {
        ValuesWanted {
            levels: self.levels.map(|k| k as usize),
            exact: self.exact,
            within: self.within.map(|n| n as usize),
            costs: costs.clone(),
            precision: self.precision,
            by_goal: self.by_goal,
            everywhere: false,
            shown: if is_table && !self.shown.json { SHOWN } else { usize::MAX },
        }
    }
}

/// Returns the initial states or all states, up to the limit.
fn listed(job: &Job<ValuesReport>, args: &ValuesArgs, engine: &Arc<AnyEngine>) -> Result<Vec<State>> {
    let set = if args.all { engine.all_states() } else { engine.initial_states() };
    Ok(listed_states(&**engine, &set, args.limit as usize, &|text| job.sink.note(text))?.0)
}
