//! The comparison of both engines: results, times and memory.

mod agreement;

use self::agreement::Agreement;
use super::check::{note_time, run_phases};
use super::{Task, Work};
use meliora_base::error::Result;
use meliora_engine::{AnyEngine, Engine, Settings, Storage};
use meliora_planning::{Analysis, Options, Phase};
use meliora_question::race::built;
use meliora_report::CompareReport;
use meliora_report::check::CheckFindings;
use meliora_report::compare::{EngineReport, Preference};
use meliora_report::envelope::Times;

/// Below this factor, two times count as about equal.
const CLEARLY: f64 = 1.25;

/// Analyses a task with both engines and compares their results: the fields of the report of `check`, what strategies say
/// about some states, and for at most `membership` states the membership of each state in each region. `parsed` is the
/// time in seconds that both need to read the input.
///
/// # Errors
/// A limit is reached, or a target has no value in some state.
pub fn compare(
    work: &dyn Work<CompareReport>,
    task: &Task,
    options: Options,
    settings: &Settings,
    (parsed, membership): (f64, u32),
) -> Result<()> {
    work.update(|r| r.header.read_both(&task.program, &task.preferences));
    let analysed = |storage, phase| {
        let settings = Settings { storage, ..settings.clone() };
        analysed(work, task, options, settings, (phase, parsed))
    };
    let left = analysed(Storage::Symbolic, "symbolic: build")?;
    let right = analysed(Storage::Explicit, "explicit: build")?;
    let (program, sink) = (&task.program, work.sink());
    let compare = || agreement::compare(&left, &right, program, membership, &*sink);
    let Agreement { compared, strategies, membership, difference } =
        work.timed("compare", compare, |_, _| ())?;
    work.update(|r| {
        r.compared = compared;
        r.strategies = strategies;
        r.membership = membership.map(|n| n.into());
        r.equal = Some(difference.is_none());
        r.prefer = if difference.is_none() { preference(&r.engines) } else { None };
        r.difference = difference;
    });
    Ok(())
}

/// Builds one engine and runs the analysis with it; notes times and memory.
fn analysed(
    work: &dyn Work<CompareReport>,
    task: &Task,
    options: Options,
    settings: Settings,
    (phase, parsed): (&'static str, f64),
) -> Result<Analysis<AnyEngine>> {
    let (mut time, engine) = (Times::unfinished::<CheckFindings>(), settings.storage.name());
    let build = || built(&task.program, settings);
    let built = work.timed(phase, build, |_, seconds| time.add("build", seconds))?;
    let mut analysis = Analysis::new(&built, &task.preferences, options);
    run_phases(work, &mut analysis, Phase::ALL, &mut |event| note_time(&mut time, event))?;
    time.total = time.phases().filter_map(|(_, seconds)| seconds).sum();
    // Both engines share the parsed input, so its time is not a part of the total.
    time.add("parse", parsed);
    let usage = built.usage();
    work.update(|r| {
        r.counts.clone_from(&analysis.result().counts);
        r.memory.peak_nodes = r.memory.peak_nodes.max(usage.peak_nodes);
        let (peak_nodes, table_bytes) = (usage.peak_nodes, usage.bytes);
        r.engines.push(EngineReport { engine, time, peak_nodes, table_bytes });
    });
    Ok(analysis)
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
