//! `meliora export`: regions and strategies for other programs.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use meliora::commands::check::run_phases;
use meliora::commands::dump_files::{DumpOptions, DumpValues, write_dump};
use meliora::commands::explicit_files::{ExplicitFiles, ExplicitFormat as Files, Induced};
use meliora_base::error::Error;
use meliora_dump::directory::check_directory;
use meliora_planning::{Analysis, Phase, Scheduler, StrategyKind};
use meliora_quantities::Steps;
use meliora_report::{ExportReport, Header};

use super::by_name::by_name;
use super::choose::costs;
use super::engines;
use super::exit::Status;
use super::export_explicit;
use super::load;
use super::options::{self, ModelArgs, PreferenceArgs, ShownArgs};
use super::supervise::{Job, supervise};

/// Write regions and strategies for other programs, as decision diagrams or explicit models
///
/// DIR receives `regions.dddmp` (all regions as roots of one diagram), `manifest.json` (the meaning
/// of roots and variables) and `certificate.dddmp` (the data that `verify` needs); with `--values`
/// also `values.csv` (bounds of probabilities and costs, state by state). If DIR exists,
/// it must be empty or contain only an older dump, which is replaced. The values are computed before anything is
/// written, and the regions are written before the certificate is computed. If a limit ends that, the dump has
/// the parts of it that were finished.
#[derive(Debug, Clone, Args)]
#[command(group = clap::ArgGroup::new("induced").args(["kind", "strategy"]))]
#[command(after_help = "Examples:
  meliora export models/toy.prism models/toy.pref --out toy.dump
  meliora export models/toy.prism models/toy.pref --region 'sasi:*' --format dot --out toy.dump")]
pub(super) struct ExportArgs {
    #[command(flatten)]
    model: ModelArgs,
    #[command(flatten)]
    preferences: PreferenceArgs,

    /// Directory to write
    #[arg(long, value_name = "DIR")]
    out: PathBuf,

    /// Write only regions with matching names, such as 'sasi:*' (repeatable), and no certificate
    #[arg(long, value_name = "GLOB")]
    region: Vec<String>,

    /// dot: also one picture per region; explicit, drn, umb: a model state by state for PRISM, Storm
    /// or other tools, with regions and ranks as labels
    #[arg(long, value_enum, default_value_t)]
    format: Format,

    /// Maximum number of states in the formats explicit, drn and umb, and with `--values`
    #[arg(long, value_name = "STATES", default_value_t = 1_000_000, value_parser = clap::value_parser!(u32).range(1..))]
    limit: u32,

    /// Write the model that a strategy of this kind induces, and a table of its actions; for the
    /// formats explicit, drn and umb
    #[arg(long, value_parser = by_name::<StrategyKind>())]
    kind: Option<StrategyKind>,

    /// Permitted actions that the model of `--kind` has: permissive gives a smaller mdp, progress a
    /// dtmc
    #[arg(long, requires = "kind", value_parser = by_name::<Scheduler>(), default_value = Scheduler::Permissive.name())]
    scheduler: Scheduler,

    /// `--kind` and `--scheduler` in one word, such as sasi:progress
    #[arg(long, value_name = "KIND[:SCHEDULER]")]
    strategy: Option<Induced>,

    /// Objective that `--kind achieve` achieves (`C,D`: both in one path), and that `plan` pursues
    /// where it is a most preferred one
    #[arg(long, value_name = "NAME", requires = "induced")]
    objective: Option<String>,

    /// Write also `values.csv`: bounds of the probabilities and costs of improvements, each of which
    /// `verify` confirms by one step. With `--format umb`, write bounds as numbers of states
    #[arg(long, conflicts_with_all = ["no_certificate", "region", "induced"])]
    values: bool,

    /// Greatest number of improvements of `--values` [default: the levels found, at most 10]
    #[arg(long, value_name = "K", requires = "values", value_parser = clap::value_parser!(u32).range(1..))]
    levels: Option<u32>,

    /// Reward structure that is the cost of a step in `--values` [default: `steps`, each step
    /// costs 1]
    #[arg(long, value_name = "NAME", requires = "values")]
    reward: Option<String>,

    /// Largest width of a bound of `--values`, absolute for probabilities, relative above 1 for costs
    #[arg(long, value_name = "X", default_value_t = 1e-6, requires = "values", value_parser = options::precision)]
    precision: f64,

    /// Write no certificate; `verify` cannot check such a dump
    #[arg(long)]
    no_certificate: bool,

    #[command(flatten)]
    shown: ShownArgs,
}

/// `--format`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
enum Format {
    /// DDDMP 2.0 text
    #[default]
    Dddmp,
    /// DDDMP, and one DOT file per region
    Dot,
    /// PRISM's explicit files .tra, .sta and .lab
    Explicit,
    /// Storm's explicit file .drn
    Drn,
    /// A UMB archive .umb with exact numbers, ranks and strategies
    Umb,
}

impl ExportArgs {
    /// Returns the name of the cost of a step.
    fn reward(&self) -> &str {
        self.reward.as_deref().unwrap_or(Steps::NAME)
    }

    /// Returns the strategy whose induced model is written.
    fn induced(&self) -> Option<Induced> {
        let kind = self.kind.map(|kind| Induced { kind, scheduler: self.scheduler });
        self.strategy.or(kind)
    }

    /// Returns the format of an explicit model, or `None` for diagrams.
    ///
    /// # Errors
    /// [`Error::Usage`] for options of the other formats.
    fn files(&self) -> Result<Option<Files>, Error> {
        let files = match self.format {
            Format::Dddmp | Format::Dot => None,
            Format::Explicit => Some(Files::Explicit),
            Format::Drn => Some(Files::Drn),
            Format::Umb => Some(Files::Umb),
        };
        let wrong = match files {
            None if self.induced().is_some() => {
                "`--kind` needs `--format explicit`, `drn` or `umb`; a dump contains all strategies"
            }
            Some(Files::Explicit | Files::Drn) if self.values => {
                "`--values` belongs to dumps, `--format dddmp` or `dot`, and to `--format umb`"
            }
            Some(_) if !self.region.is_empty() => {
                "`--region` selects diagrams; the formats explicit, drn and umb contain all regions"
            }
            _ => return Ok(files),
        };
        Err(Error::Usage(wrong.to_owned()))
    }
}

/// Runs the command.
///
/// # Errors
/// The input is wrong, a limit is hit, or the directory cannot be written.
pub(super) fn run(args: ExportArgs) -> Result<Status, Error> {
    if let Some(format) = args.files()? {
        let (levels, reward, precision) = (args.levels, args.reward().to_owned(), args.precision);
        let values = args.values.then_some(export_explicit::ValuesArgs { levels, reward, precision });
        let strategy = args.induced();
        let ExportArgs { model, preferences, out, limit, objective, shown, .. } = args;
        let limit = usize::try_from(limit).unwrap_or(usize::MAX);
        let files = ExplicitFiles { format, strategy, objective, limit };
        return export_explicit::run(
            export_explicit::Wanted { model, preferences, out, files, values },
            &shown,
        );
    }
    check_patterns(&args.region)?;
    let header = Header { safety: Some(args.preferences.safety), ..args.model.header() };
    let report = ExportReport::to_directory(header, &args.out.display().to_string());
    let (limits, shown) = (args.model.limits(), args.shown.clone());
    supervise(report, limits, &shown, move |job| work(job, &args))
}

/// Refuses patterns with signs that other programs give a meaning.
fn check_patterns(patterns: &[String]) -> Result<(), Error> {
    match patterns.iter().find(|pattern| pattern.contains(['[', ']', '{', '}', '\\'])) {
        None => Ok(()),
        Some(wrong) => {
            let message =
                "`*` stands for any text and `?` for one character; repeat `--region` for more names";
            Err(Error::Usage(format!("`--region {wrong}`: {message}")))
        }
    }
}

fn work(job: &Job<ExportReport>, args: &ExportArgs) -> Result<(), Error> {
    if args.out.as_os_str() == "-" {
        let message = "a dump is a directory; it cannot be written to standard output";
        return Err(Error::Usage(message.to_owned()));
    }
    check_directory(&args.out)?;
    // The first of two dumps replaces the working directory if this is an old dump.
    let out = std::path::absolute(&args.out).map_err(|e| Error::writing(&args.out, &e))?;
    let read = || {
        let task = load::task(&args.model, &args.preferences, &job.sink)?;
        let costs = costs(&task.program, args.reward(), &job.sink)?;
        Ok((task, costs))
    };
    let (task, costs) = job.timed("parse", read, |_, _| ())?;
    job.update(|r| r.header.read(&task.program));
    let build = || engines::symbolic(&task.program, &args.model, &job.sink);
    let engine = job.timed("build", build, |_, _| ())?;
    let mut analysis = Analysis::new(&engine, &task.preferences, args.preferences.options());
    run_phases(job, &mut analysis, Phase::ALL, &mut |_| ())?;
    let values = DumpValues {
        levels: args.levels.map(|k| k as usize),
        reward: args.reward(),
        costs: &costs,
        limit: args.limit as usize,
        precision: args.precision,
    };
    let options = DumpOptions {
        regions: &args.region,
        certificate: !args.no_certificate,
        dot: args.format == Format::Dot,
        values: args.values.then_some(values),
    };
    let files = (args.model.path(), args.preferences.path());
    write_dump(job, (&analysis, &task), files, options, &out)
}
