//! `meliora compare`: runs both engines on the same input.

use std::time::Instant;

use clap::Args;
use meliora_base::error::Error;
use meliora_engine::{AnyEngine, Engine, Storage};
use meliora_planning::{Analysis, Phase};
use meliora_report::CompareReport;
use meliora_report::check::CheckFindings;
use meliora_report::compare::{EngineReport, Preference};
use meliora_report::envelope::Times;

use super::agreement::{self, Agreement};
use super::engines;
use super::exit::Status;
use super::load::{self, Question};
use super::options::{ModelArgs, PreferenceArgs, ShownArgs};
use super::phases;
use super::supervise::{Job, supervise};
use super::sweep::SweepArgs;

/// Below this factor, two times count as about equal.
const CLEARLY: f64 = 1.25;

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
    let read = || load::question(&args.model, &args.preferences, &job.sink);
    let mut parsed = 0.0;
    let question = job.timed("parse", read, |_, seconds| parsed = seconds)?;
    job.update(|r| r.header.read_both(&question.program, &question.preferences));
    let left = analysed(job, args, &question, Storage::Symbolic, "symbolic: build", parsed)?;
    let right = analysed(job, args, &question, Storage::Explicit, "explicit: build", parsed)?;
    conclude(job, args, &question, &left, &right)
}

/// Builds one engine and runs the analysis with it.
fn analysed(
    job: &Job<CompareReport>,
    args: &CompareArgs,
    question: &Question,
    storage: Storage,
    phase: &'static str,
    parsed: f64,
) -> Result<Analysis<AnyEngine>, Error> {
    let start = Instant::now();
    let build = || engines::engine(&question.program, &args.model, storage, &job.sink);
    let engine = job.timed(phase, build, |_, _| ())?;
    let mut time = Times::of::<CheckFindings>();
    time.add("build", start.elapsed().as_secs_f64());
    let mut analysis = Analysis::new(&engine, &question.preferences, args.preferences.options());
    analyse(job, storage.name(), time, parsed, &mut analysis)?;
    Ok(analysis)
}

/// Runs all phases with one engine and records times and memory.
fn analyse<E: Engine>(
    job: &Job<CompareReport>,
    name: &'static str,
    mut time: Times,
    parsed: f64,
    analysis: &mut Analysis<E>,
) -> Result<(), Error> {
    phases::run(analysis, Phase::ALL, &job.sink, &mut |event| phases::note(&mut time, event))?;
    time.total = time.phases().filter_map(|(_, seconds)| seconds).sum();
    // Both engines share the parsed input, so its time is not a part of the total.
    time.add("parse", parsed);
    let usage = analysis.engine().usage();
    job.update(|r| {
        r.counts.clone_from(&analysis.result().counts);
        r.memory.peak_nodes = r.memory.peak_nodes.max(usage.peak_nodes);
        let (peak_nodes, table_bytes) = (usage.peak_nodes, usage.bytes);
        r.engines.push(EngineReport { engine: name, time, peak_nodes, table_bytes });
    });
    Ok(())
}

/// Compares the results of both engines and recommends one.
fn conclude<E: Engine, F: Engine>(
    job: &Job<CompareReport>,
    args: &CompareArgs,
    question: &Question,
    left: &Analysis<E>,
    right: &Analysis<F>,
) -> Result<(), Error> {
    let Agreement { compared, strategies, membership, difference } = job.timed(
        "compare",
        || agreement::compare(left, right, &question.program, args.membership, &job.sink),
        |_, _| (),
    )?;
    job.update(|r| {
        r.compared = compared;
        r.strategies = strategies;
        r.membership = membership.map(|n| n.into());
        r.equal = Some(difference.is_none());
        r.prefer = if difference.is_none() { preference(&r.engines) } else { None };
        r.difference = difference;
    });
    Ok(())
}

/// Returns the clearly faster engine, or else the one with the smaller tables.
fn preference(engines: &[EngineReport]) -> Option<Preference> {
    let [a, b] = engines else { return None };
    let (fast, slow) = if a.time.total <= b.time.total { (a, b) } else { (b, a) };
    let factor = slow.time.total / fast.time.total.max(1e-9);
    if factor > CLEARLY {
        let reason = format!("it is {factor:.1} times as fast");
        return Some(Preference { engine: fast.engine, reason });
    }
    let small = if a.table_bytes <= b.table_bytes { a } else { b };
    let reason = "both take about the same time, and its tables are smaller".to_owned();
    Some(Preference { engine: small.engine, reason })
}
