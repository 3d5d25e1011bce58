//! `meliora compare`: runs both engines on the same input.

use clap::Args;
use meliora::commands::compare;
use meliora_base::error::Error;
use meliora_engine::Storage;
use meliora_report::CompareReport;

use super::engines;
use super::exit::Status;
use super::load;
use super::options::{ModelArgs, PreferenceArgs, ShownArgs};
use super::supervise::{Job, supervise};
use super::sweep::SweepArgs;

/// Run both engines and compare their results, times and memory
///
/// Compares every field of the reports of `check`: counts, classes, levels, ranks. Compares what `strategy` says about the initial
/// states and some states of each rank and class: kept, permitted and progress actions, reasons and
/// successors, for every kind. For models of limited size it also compares the membership of each
/// state in each region. If the engines differ, prints the first difference and
/// ends with exit status 1.
#[derive(Debug, Clone, Args)]
#[command(after_help = "Examples:
  meliora compare models/robot5x5.prism models/robot5x5.pref --scope all
  meliora compare models/network.prism models/network.pref -c K=20,M=5")]
pub(super) struct CompareArgs {
    #[command(flatten)]
    model: ModelArgs,
    #[command(flatten)]
    preferences: PreferenceArgs,

    /// Maximum number of states for the comparison of memberships
    #[arg(long, value_name = "STATES", default_value_t = 100_000)]
    membership: u32,

    #[command(flatten)]
    sweep: SweepArgs,
    #[command(flatten)]
    shown: ShownArgs,
}

/// Runs the command.
///
/// # Errors
/// The input is wrong, or a limit is hit.
pub(super) fn run(args: CompareArgs) -> Result<Status, Error> {
    let report = CompareReport::new(args.preferences.header(&args.model));
    let preferences = &args.preferences.preferences;
    if let Some(status) =
        args.sweep.run_preferences("compare", &args.model, preferences, &report, &args.shown)?
    {
        return Ok(status);
    }
    let (limits, shown) = (args.model.limits(), args.shown.of(&args.model));
    supervise(report, limits, &shown, move |job| work(job, &args))
}

fn work(job: &Job<CompareReport>, args: &CompareArgs) -> Result<(), Error> {
    let read = || load::task(&args.model, &args.preferences, &job.sink);
    let mut parsed = 0.0;
    let task = job.timed("parse", read, |_, seconds| parsed = seconds)?;
    let settings = engines::settings(&args.model, Storage::Symbolic, &job.sink)?;
    compare(job, &task, args.preferences.options(), &settings, (parsed, args.membership))
}
