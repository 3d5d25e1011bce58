//! `meliora export --format explicit|drn|umb`: models state by state.

use std::str::FromStr;
use std::sync::Arc;

use meliora::commands::check::run_phases;
use meliora::commands::strategy_of;
use meliora_base::error::Error;
use meliora_engine::Engine;
use meliora_export::bounds;
use meliora_export::explicit::{
    Graph, Quantities, action_table, drn, explored, induced, prism, refuse_drn, umb,
};
use meliora_model::Program;
use meliora_planning::induced_model::Scheduler;
use meliora_planning::{Analysis, Phase, StrategyKind};
use meliora_quantities::Values;
use meliora_quantities::choose::LEVELS;
use meliora_quantities::cost::Costs;
use meliora_report::{ExplicitReport, Header};

use super::choose::costs;
use super::exit::Status;
use super::folder::Folder;
use super::options::{ModelArgs, PreferenceArgs, ShownArgs};
use super::supervise::{Job, supervise};
use super::{engines, load};

/// The strategy whose induced model is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Induced {
    pub(super) kind: StrategyKind,
    pub(super) scheduler: Scheduler,
}

impl FromStr for Induced {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (kind, scheduler) = text.split_once(':').unwrap_or((text, Scheduler::Permissive.name()));
        let wrong =
            || "expected a kind of strategy, such as `sasi`, or with a scheduler `sasi:progress`".to_owned();
        let (kind, scheduler) = (kind.parse().map_err(|_| wrong())?, scheduler.parse().map_err(|_| wrong())?);
        Ok(Induced { kind, scheduler })
    }
}

impl Induced {
    fn name(self) -> String {
        format!("{}:{}", self.kind.name(), self.scheduler.name())
    }
}

/// The format of the files.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Files {
    /// PRISM's `.tra`, `.sta` and `.lab`
    Explicit,
    /// Storm's `.drn`
    Drn,
    /// UMB's `.umb`
    Umb,
}

/// The arguments of the export.
#[derive(Debug, Clone)]
pub(super) struct Wanted {
    pub(super) model: ModelArgs,
    pub(super) preferences: PreferenceArgs,
    pub(super) out: std::path::PathBuf,
    pub(super) format: Files,
    pub(super) limit: usize,
    pub(super) strategy: Option<Induced>,
    pub(super) objective: Option<String>,
    pub(super) values: Option<ValuesArgs>,
}

/// `--values` and its options.
#[derive(Debug, Clone)]
pub(super) struct ValuesArgs {
    pub(super) levels: Option<u32>,
    pub(super) reward: String,
    pub(super) precision: f64,
}

impl ValuesArgs {
    fn quantities<E: Engine>(
        &self,
        analysis: &Analysis<E>,
        program: &Program,
        graph: &Graph,
        costs: Costs,
        limit: usize,
    ) -> Result<Quantities, Error> {
        let costs = costs.check(analysis.engine(), program)?;
        let levels = self.levels.map_or_else(|| Values::levels_found(analysis, LEVELS), |k| k as usize);
        let wanted = bounds::Wanted { levels, reward: self.reward.as_str(), costs: &*costs, limit };
        Ok(Quantities::of(graph, &bounds::compute(analysis, program, &wanted)?, &wanted))
    }
}

/// Runs the command.
///
/// # Errors
/// The input is wrong, a limit is hit, or the directory cannot be written.
pub(super) fn run(wanted: Wanted, shown: &ShownArgs) -> Result<Status, Error> {
    let header = Header { safety: Some(wanted.preferences.safety), ..wanted.model.header() };
    let directory = wanted.out.display().to_string();
    let report = ExplicitReport::to_directory(header, &directory, wanted.strategy.map(Induced::name));
    supervise(report, wanted.model.limits(), shown, move |job| work(job, &wanted))
}

fn work(job: &Job<ExplicitReport>, wanted: &Wanted) -> Result<(), Error> {
    let inputs = wanted.preferences.inputs(&wanted.model);
    let folder = Folder::new(&wanted.out, names(wanted), &inputs)?;
    let read = || {
        let task = load::task(&wanted.model, &wanted.preferences, &job.sink)?;
        refuse_game(wanted, &task.program)?;
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
    let list = || listed(wanted, &analysis, &task.program);
    let graph = job.timed("states", list, |_, _| ())?;
    let mut quantities = None;
    if let Some((args, costs)) = wanted.values.as_ref().zip(costs) {
        let compute = || args.quantities(&analysis, &task.program, &graph, costs, wanted.limit);
        quantities = Some(job.timed("values", compute, |_, _| ())?);
    }
    let program = &task.program;
    let write = || folder.write(&contents(wanted, &graph, &analysis, program, quantities.as_ref())?);
    let names = job.timed("write", write, |_, _| ())?;
    let peak = engine.usage().peak_nodes;
    job.update(|r| {
        r.set(&graph, names);
        r.set_values(wanted.values.as_ref().zip(quantities.as_ref()).map(|(args, q)| (q, args.precision)));
        r.memory.peak_nodes = peak;
    });
    Ok(())
}

/// Refuses what a game cannot be written with.
fn refuse_game(wanted: &Wanted, program: &Program) -> Result<(), Error> {
    // The progress strategy leaves an mdp of the opponent's choices.
    let is_mdp = wanted.strategy.is_some_and(|strategy| strategy.scheduler == Scheduler::Progress);
    if wanted.format == Files::Drn && !is_mdp {
        refuse_drn(program)?;
    }
    Ok(())
}

fn listed<E: Engine>(
    wanted: &Wanted,
    analysis: &Analysis<E>,
    program: &Arc<Program>,
) -> Result<Graph, Error> {
    let Some(asked) = wanted.strategy else { return explored(analysis, program, wanted.limit) };
    let objectives = asked.kind.objectives(analysis.preferences(), wanted.objective.as_deref())?;
    let mut strategy = strategy_of(analysis, program, asked.kind, asked.kind.levels(), &objectives)?;
    induced(analysis, program, &mut strategy, asked.scheduler, wanted.limit)
}

/// Returns the names of the files.
fn names(wanted: &Wanted) -> Vec<String> {
    let stem = wanted.strategy.map_or("model".to_owned(), |s| s.name().replace(':', "-"));
    let table = wanted.strategy.map(|_| "csv");
    let formats: &[&str] = match wanted.format {
        Files::Drn => &["drn"],
        Files::Umb => &["umb"],
        Files::Explicit => &["tra", "sta", "lab"],
    };
    formats.iter().copied().chain(table).map(|extension| format!("{stem}.{extension}")).collect()
}

/// Returns the contents of the files.
fn contents<E: Engine>(
    wanted: &Wanted,
    graph: &Graph,
    analysis: &Analysis<E>,
    program: &Program,
    quantities: Option<&Quantities>,
) -> Result<Vec<Vec<u8>>, Error> {
    let mut contents = match wanted.format {
        Files::Drn => vec![drn(graph, program, &*analysis.engine().settings().sink)?.into_bytes()],
        Files::Umb => vec![umb(graph, analysis, program, quantities)?],
        Files::Explicit => {
            let all = prism(graph);
            [all.tra, all.sta, all.lab].map(String::into_bytes).into()
        }
    };
    contents.extend(wanted.strategy.map(|_| action_table(graph).into_bytes()));
    Ok(contents)
}
