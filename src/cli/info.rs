//! `meliora info`: the variables and sizes of a model.

use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;
use meliora_base::error::Error;
use meliora_engine::{Engine, Storage};
use meliora_lang::flat::Flat;
use meliora_model::Program;
use meliora_model::predicate::Predicate;
use meliora_planning::result::ModelCounts;
use meliora_report::InfoReport;
use meliora_report::info::{FlatReport, Nodes, RewardSummary};
use meliora_report::players::PlayerSummary;

use super::engines;
use super::exit::Status;
use super::load;
use super::options::{EngineArgs, ModelArgs, ShownArgs};
use super::supervise::{Job, supervise};

/// Print variables, sizes, the order of the BDD variables and node counts of a model
#[derive(Debug, Clone, Args)]
#[command(after_help = "Examples:
  meliora info models/robot5x5.prism
  meliora info models/ring.prism -c N=8 --flat")]
pub(super) struct InfoArgs {
    #[command(flatten)]
    model: ModelArgs,
    #[command(flatten)]
    engine: EngineArgs,
    #[command(flatten)]
    shown: ShownArgs,

    /// Add the monitors of the temporal objectives in this preference file to the model
    #[arg(long, value_name = "PREFS", conflicts_with = "flat")]
    preferences: Option<PathBuf>,

    /// Print the flat program instead: constants, formulas, renamings and synchronisation resolved
    #[arg(long, conflicts_with_all = ["json", "scope", "order", "memory", "threads", "engine"])]
    flat: bool,
}

/// Runs the command.
///
/// # Errors
/// The input is wrong, or a limit is hit.
pub(super) fn run(args: InfoArgs) -> Result<Status, Error> {
    args.engine.validate(&args.model)?;
    if args.flat {
        return show_flat(&args);
    }
    let selected = args.engine.diagrams("sizes of diagrams");
    let mut report = InfoReport::new(args.model.header());
    report.header.select(&selected);
    let (limits, shown) = (args.model.limits(), args.shown.clone());
    supervise(report, limits, &shown, move |job| work(job, &args, selected.storage))
}

/// Prints the flat program, without an engine.
fn show_flat(args: &InfoArgs) -> Result<Status, Error> {
    let (limits, shown) = (args.model.limits(), args.shown.clone());
    let args = args.clone();
    supervise(FlatReport::default(), limits, &shown, move |job| {
        let program = Arc::new(load::parsed(&args.model, &job.sink)?.into_program());
        let flat = Flat::new(&program)?;
        job.update(|r| r.flat = Some(flat));
        Ok(())
    })
}

fn work(job: &Job<InfoReport>, args: &InfoArgs, storage: Storage) -> Result<(), Error> {
    let read = || match &args.preferences {
        None => load::program(&args.model, &job.sink),
        Some(file) => {
            let task = load::preferring(load::parsed(&args.model, &job.sink)?, file, &job.sink)?;
            Ok((task.program, task.overlap))
        }
    };
    let (program, overlap) = job.timed("parse", read, |r, s| r.time.add("parse", s))?;
    job.update(|r| {
        r.header.read(&program);
        r.rewards = RewardSummary::all(&program);
    });
    let build = || engines::engine(&program, &args.model, storage, &job.sink);
    let engine = job.timed("build", build, |r, s| r.time.add("build", s))?;
    if let Some(engine) = engine.symbolic() {
        let sizes = engine.sizes()?;
        job.update(|r| {
            r.order = Some(engine.encoding().names());
            r.order_reason = engine.encoding().why().map(str::to_owned);
            let (transition, reachable) = (sizes.transition as u64, sizes.states as u64);
            r.nodes = Some(Nodes { transition, reachable });
        });
    }
    count(job, &*engine, &program, overlap.as_ref())
}

fn count<E: Engine>(
    job: &Job<InfoReport>,
    engine: &E,
    program: &Program,
    overlap: Option<&Predicate>,
) -> Result<(), Error> {
    let counts = job.timed("count", || ModelCounts::count(engine), |r, s| r.time.add("count", s))?;
    engines::warn_of_states(&job.sink, engine, program, &counts.deadlocks, overlap)?;
    let players = PlayerSummary::all(program, engine)?;
    job.update(|r| {
        (r.counts, r.players) = (Some(counts), players);
        r.memory.peak_nodes = engine.usage().peak_nodes;
    });
    Ok(())
}
