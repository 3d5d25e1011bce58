//! `meliora check`: levels of improvements, and permitted actions in the initial states.

use clap::Args;
use meliora::commands::check::{Extras, check};
use meliora_base::error::Error;
use meliora_report::CheckReport;

use super::exit::Status;
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

fn work(job: &Job<CheckReport>, args: &CheckArgs) -> Result<(), Error> {
    let given = Arguments { model: &args.model, preferences: &args.preferences, engine: &args.engine };
    let (task, ()) = plan::read(job, given, |task| {
        job.update(|r| r.read(&task.program, task.preferences.empty, task.preferences.history));
        Ok(())
    })?;
    let details = args.shown.verbose > 0 && !args.shown.json;
    let (options, extras) = (args.preferences.options(), Extras { jointly: args.jointly, details });
    plan::raced(job, given, &task, &|job, engine| check(job, engine, &task, options, extras))
}
