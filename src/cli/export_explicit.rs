//! `meliora export --format explicit|drn|umb`: models state by state.

use meliora::commands::check::run_phases;
use meliora::commands::dump_files::DumpValues;
use meliora::commands::explicit_files::{ExplicitFiles, Induced};
use meliora_base::error::Error;
use meliora_engine::Engine;
use meliora_planning::{Analysis, Phase};
use meliora_report::{ExplicitReport, Header};

use super::choose::costs;
use super::exit::Status;
use super::folder::Folder;
use super::options::{ModelArgs, PreferenceArgs, ShownArgs};
use super::supervise::{Job, supervise};
use super::{engines, load};

/// The arguments of the export.
#[derive(Debug, Clone)]
pub(super) struct Wanted {
    pub(super) model: ModelArgs,
    pub(super) preferences: PreferenceArgs,
    pub(super) out: std::path::PathBuf,
    pub(super) files: ExplicitFiles,
    pub(super) values: Option<ValuesArgs>,
}

/// `--values` and its options.
#[derive(Debug, Clone)]
pub(super) struct ValuesArgs {
    pub(super) levels: Option<u32>,
    pub(super) reward: String,
    pub(super) precision: f64,
}

/// Runs the command.
///
/// # Errors
/// The input is wrong, a limit is hit, or the directory cannot be written.
pub(super) fn run(wanted: Wanted, shown: &ShownArgs) -> Result<Status, Error> {
    let header = Header { safety: Some(wanted.preferences.safety), ..wanted.model.header() };
    let directory = wanted.out.display().to_string();
    let report = ExplicitReport::to_directory(header, &directory, wanted.files.strategy.map(Induced::name));
    supervise(report, wanted.model.limits(), shown, move |job| work(job, &wanted))
}

fn work(job: &Job<ExplicitReport>, wanted: &Wanted) -> Result<(), Error> {
    let inputs = wanted.preferences.inputs(&wanted.model);
    let folder = Folder::new(&wanted.out, wanted.files.names(), &inputs)?;
    let read = || {
        let task = load::task(&wanted.model, &wanted.preferences, &job.sink)?;
        wanted.files.refuse_game(&task.program)?;
        let costs = |v: &ValuesArgs| costs(&task.program, &v.reward, &job.sink);
        let costs = wanted.values.as_ref().map(costs).transpose()?;
        Ok((task, costs))
    };
    let (task, costs) = job.timed("parse", read, |_, _| ())?;
    job.update(|r| r.header.read(&task.program));
    let build = || engines::symbolic(&task.program, &wanted.model, &job.sink);
    let engine = job.timed("build", build, |_, _| ())?;
    let mut analysis = Analysis::new(&engine, &task.preferences, wanted.preferences.options());
    run_phases(job, &mut analysis, Phase::ALL, &mut |_| ())?;
    let list = || wanted.files.graph(&analysis, &task.program);
    let graph = job.timed("states", list, |_, _| ())?;
    let mut quantities = None;
    if let Some((args, costs)) = wanted.values.as_ref().zip(costs) {
        let values = DumpValues {
            levels: args.levels.map(|k| k as usize),
            reward: &args.reward,
            costs: &costs,
            limit: wanted.files.limit,
            precision: args.precision,
        };
        let compute = || wanted.files.values(&analysis, &task.program, &graph, values);
        quantities = Some(job.timed("values", compute, |_, _| ())?);
    }
    let program = &task.program;
    let write = || folder.write(&wanted.files.contents(&graph, &analysis, program, quantities.as_ref())?);
    let names = job.timed("write", write, |_, _| ())?;
    let peak = engine.usage().peak_nodes;
    job.update(|r| {
        r.set(&graph, names);
        r.set_values(wanted.values.as_ref().zip(quantities.as_ref()).map(|(args, q)| (q, args.precision)));
        r.memory.peak_nodes = peak;
    });
    Ok(())
}
