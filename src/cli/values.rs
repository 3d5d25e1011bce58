//! `meliora values`: how likely improvements are, how soon they come, and at what cost.

use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;
use meliora::NamedStates;
use meliora::commands::check::levels;
use meliora::commands::listed as listed_states;
use meliora_base::csv::Lines;
use meliora_base::error::{Limit, Result};
use meliora_engine::{Algebra, AnyEngine, Count, Engine};
use meliora_model::{Program, State};
use meliora_planning::{Analysis, Phase};
use meliora_quantities::by_goal::by_goal;
use meliora_quantities::choose::LEVELS;
use meliora_quantities::cost::{Cost, Costs};
use meliora_quantities::state_values::{StateValues, Width};
use meliora_quantities::{Steps, ValueOptions, Values};
use meliora_report::ValuesReport;
use meliora_report::values::{heading, rows};

use super::choose::costs;
use super::exit::Status;
use super::files::Target;
use super::load;
use super::options::{self, EngineArgs, ModelArgs, PreferenceArgs, ShownArgs};
use super::plan::{self, Arguments};
use super::supervise::{Job, supervise};

/// The number of states whose values are added before they are computed.
const SOON: usize = 1000;
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
        let mut lines = csv.map(|_| Lines::default());
        let program = &task.program;
        let evaluation = Evaluation { job, args, program, analysis: &analysis, states: &states, everywhere };
        let end = evaluation.run(&costs, lines.as_mut());
        job.update(|r| r.used(engine.usage()));
        end.map(|()| lines)
    })?;
    match csv.zip(lines) {
        Some((target, lines)) => target.write(&lines.text()),
        None => Ok(()),
    }
}

/// Returns the initial states or all states, up to the limit.
fn listed(job: &Job<ValuesReport>, args: &ValuesArgs, engine: &Arc<AnyEngine>) -> Result<Vec<State>> {
    let set = if args.all { engine.all_states() } else { engine.initial_states() };
    Ok(listed_states(&**engine, &set, args.limit as usize, &|text| job.sink.note(text))?.0)
}

/// The evaluation of states.
struct Evaluation<'a> {
    job: &'a Job<ValuesReport>,
    args: &'a ValuesArgs,
    program: &'a Arc<Program>,
    analysis: &'a Analysis<AnyEngine>,
    states: &'a [State],
    /// True if these are all states of the scope.
    everywhere: bool,
}

impl Evaluation<'_> {
    /// Computes the values and adds them to the report, also those known when a limit is hit. All
    /// values are also added to `lines`.
    fn run(&self, costs: &Costs, lines: Option<&mut Lines>) -> Result<()> {
        let Evaluation { job, args, program, analysis, states, everywhere } = *self;
        let levels = args.levels.map_or_else(|| Values::levels_found(analysis, LEVELS), |k| k as usize);
        let within = args.within.map(|n| n as usize);
        let mut values = Values::new(ValueOptions { levels, exact: args.exact, within });
        let costs = costs.check(analysis.engine(), program)?;
        let explore = || match everywhere {
            true => values.explore_everywhere(analysis, program, &*costs),
            false => values.explore(analysis, program, states, &*costs),
        };
        let explored = job.timed("explore", explore, |r, s| r.time.add("explore", s));
        // The worker may be left behind while it solves, so what follows from the levels is added
        // first, unless that takes long.
        self.fill(&values, &states[..states.len().min(SOON)], usize::MAX, None)?;
        explored?;
        let solved = job.timed("solve", || values.solve(analysis.engine()), |r, s| r.time.add("solve", s));
        let shown = if lines.is_some() && !args.shown.json { SHOWN } else { usize::MAX };
        let widest = self.fill(&values, states, shown, lines)?;
        solved?;
        if args.by_goal {
            job.timed("by goal", || self.add_gains(&*costs), |_, _| ())?;
        }
        self.judge(&widest)
    }

    /// Adds what the first improvement of each listed state gains.
    fn add_gains(&self, costs: &dyn Cost) -> Result<()> {
        let Evaluation { job, args, program, analysis, states, .. } = *self;
        for (position, state) in states.iter().enumerate() {
            let gains = by_goal(analysis, program, state, costs, args.precision)?;
            job.update(|r| {
                if let Some(values) = r.states.get_mut(position).filter(|values| !values.is_unsafe) {
                    values.by_goal = Some(gains);
                }
            });
        }
        Ok(())
    }

    /// Refuses bounds that are wider than the precision.
    fn judge(&self, widest: &Width) -> Result<()> {
        let (width, quantity, precision) = (widest.width, widest.quantity(), self.args.precision);
        let is_wide = width > precision;
        if !is_wide {
            return Ok(());
        }
        let what = match width.is_finite() {
            true => {
                format!("bounds of {quantity} are {width:e} apart, more than the precision {precision:e}")
            }
            false => format!("no upper bound of {quantity} was found"),
        };
        let what = format!("{what}; `--exact` finds the values of small models");
        Err(Limit::Size { what }.into())
    }

    /// Lists values as far as they are known: those of the first states in the report, all in
    /// `lines`. Returns the widest bound of all.
    fn fill(
        &self,
        values: &Values,
        states: &[State],
        shown: usize,
        mut lines: Option<&mut Lines>,
    ) -> Result<Width> {
        let (mut found, mut more, mut widest) = (Vec::new(), 0, Width::default());
        let required = self.analysis.requirements().is_some();
        if let Some(lines) = &mut lines {
            lines.push(heading(self.program, required));
        }
        StateValues::each(self.analysis, self.program, values, states, &mut |state| {
            widest = widest.or(state.widest());
            if let Some(lines) = &mut lines {
                rows(&state, required).into_iter().for_each(|row| lines.push(row));
            }
            if found.len() < shown {
                found.push(state);
            } else {
                more += 1;
            }
        })?;
        self.job.update(|r| (r.states, r.more) = (found, more));
        Ok(widest)
    }
}
