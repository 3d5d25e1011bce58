//! `meliora export`: regions and strategies for other programs.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use meliora::commands::check::run_phases;
use meliora_base::error::{Error, Limit};
use meliora_dump::Dump;
use meliora_dump::directory::{check_directory, complete_directory, sha256, write_regions_first};
use meliora_engine::SymbolicEngine;
use meliora_export::bounds::Wanted;
use meliora_export::{DumpContent, Inputs, certify, export};
use meliora_model::region::RegionName;
use meliora_planning::{Analysis, Phase, Scheduler, StrategyKind};
use meliora_quantities::choose::LEVELS;
use meliora_quantities::{Steps, Values};
use meliora_report::{ExportReport, Header};

use super::by_name::by_name;
use super::choose::costs;
use super::engines;
use super::exit::Status;
use super::export_explicit::{self, Files, Induced};
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
        return export_explicit::run(
            export_explicit::Wanted { model, preferences, out, format, limit, strategy, objective, values },
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

/// Returns whether a name matches a pattern, in which `*` stands for any text and `?` for one character.
fn matches(pattern: &str, name: &str) -> bool {
    let mut rest = pattern.chars();
    match rest.next() {
        None => name.is_empty(),
        Some('*') => {
            let ends = name.char_indices().map(|(at, _)| at).chain([name.len()]);
            ends.into_iter().any(|at| matches(rest.as_str(), &name[at..]))
        }
        Some(sign) => {
            let mut left = name.chars();
            left.next().is_some_and(|c| sign == '?' || sign == c) && matches(rest.as_str(), left.as_str())
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
    let dot = args.format == Format::Dot;
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
    let inputs = Inputs {
        model: (args.model.path(), sha256(task.program.source.original().as_bytes())),
        preferences: (args.preferences.path(), sha256(task.source.original().as_bytes())),
    };
    let all = args.region.is_empty();
    let named = |name: &String| args.region.iter().any(|pattern| matches(pattern, name));
    let wanted = |name: &RegionName| all || named(&name.to_string());
    let content = DumpContent { wanted: &wanted, certificate: false };
    let dump = || export(&analysis, &inputs, &content);
    let mut dump = job.timed("dump", dump, |_, _| ())?;
    let certifies = all && !args.no_certificate;
    // Before anything is written: if there are no values, an older dump stays as it is.
    let mut width = None;
    if args.values {
        let costs = costs.check(analysis.engine(), &task.program)?;
        let levels = args.levels.map_or_else(|| Values::levels_found(&analysis, LEVELS), |k| k as usize);
        let limit = args.limit as usize;
        let wanted = Wanted { levels, reward: args.reward(), costs: &*costs, limit };
        let add = || meliora_export::bounds::add(&mut dump, &analysis, &wanted);
        width = Some(job.timed("values", add, |_, _| ())?);
    }
    if certifies {
        certified(job, &out, dot, &analysis, &mut dump)?;
    }
    let write = || match certifies {
        true => complete_directory(&mut dump, &out, job.sink.as_ref()),
        false => write_regions_first(&mut dump, &out, dot, job.sink.as_ref()),
    };
    job.timed("write", write, |_, _| ())?;
    let manifest = dump.manifest;
    let peak = meliora_engine::Engine::usage(&*engine).peak_nodes;
    job.update(|r| {
        r.set(&manifest);
        r.set_values(&manifest, width, args.precision);
        r.memory.peak_nodes = peak;
    });
    let open = manifest.certificate.map_or(0, |file| file.uncertified.len());
    if open == 0 {
        return Ok(());
    }
    // The limit has ended a part of this phase.
    job.sink.report("certificate", String::new());
    Err(Limit::Uncertified(open).into())
}

/// Writes the dump, and then adds its certificate: a limit that ends this leaves the regions.
fn certified(
    job: &Job<ExportReport>,
    out: &Path,
    dot: bool,
    analysis: &Analysis<SymbolicEngine>,
    dump: &mut Dump,
) -> Result<(), Error> {
    // The values come with the certificate, which proves them.
    let values = (dump.values.take(), dump.manifest.values.take());
    let write = || write_regions_first(dump, out, dot, job.sink.as_ref());
    job.timed("write", write, |_, _| ())?;
    job.update(|r| r.set_uncertified(&dump.manifest));
    let add = || certify(dump, analysis, &mut |left| job.sink.share(left));
    job.timed("certificate", add, |_, _| ())?;
    (dump.values, dump.manifest.values) = values;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::matches;

    #[test]
    fn patterns_match_whole_names() {
        for (pattern, name) in
            [("sasi:*", "sasi:12"), ("*", ""), ("*:A*", "strategy:almost-sure:A"), ("spi:?", "spi:3")]
        {
            assert!(matches(pattern, name), "{pattern} {name}");
        }
        for (pattern, name) in
            [("sasi:*", "strategy:sasi:1"), ("spi:?", "spi:12"), ("spi:?", "spi:"), ("", "x")]
        {
            assert!(!matches(pattern, name), "{pattern} {name}");
        }
    }
}
