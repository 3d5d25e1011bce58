//! `meliora export`: regions and strategies for other programs.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use globset::{Glob, GlobSet, GlobSetBuilder};
use meliora::dump::directory::{check_directory, sha256, write_directory};
use meliora::error::Error;
use meliora::export::{Inputs, Selection, export};
use meliora::output::{ExportReport, Header};
use meliora::planning::{Analysis, Phase};

use super::exit::Status;
use super::export_explicit::{self, StrategyArg, Texts, Wanted};
use super::load;
use super::options::{ModelArgs, PreferenceArgs, ShownArgs};
use super::phases;
use super::supervise::{Job, supervise};

/// Write regions and strategies for other programs, as decision diagrams or explicit models
///
/// DIR receives `regions.dddmp` (all regions as roots of one diagram), `manifest.json` (the meaning
/// of roots and variables) and `certificate.dddmp` (the data that `verify` needs). If DIR exists,
/// it must be empty or contain only an older dump, which is replaced.
#[derive(Debug, Clone, Args)]
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

    /// dot: also one picture per region; explicit, drn: an explicit model for PRISM or Storm, with
    /// regions and ranks as labels
    #[arg(long, value_enum, default_value_t)]
    format: Format,

    /// Maximum number of states in the formats explicit and drn
    #[arg(long, value_name = "STATES", default_value_t = 1_000_000, value_parser = clap::value_parser!(u32).range(1..))]
    limit: u32,

    /// Write the model that a strategy induces, a dtmc (progress) or a smaller mdp (permissive),
    /// and a table of its actions; for the formats explicit and drn
    #[arg(long, value_name = "sasi|spi[:progress|permissive]", value_parser = StrategyArg::parse)]
    strategy: Option<StrategyArg>,

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
}

impl ExportArgs {
    /// Returns the format of an explicit model, or `None` for diagrams.
    ///
    /// # Errors
    /// [`Error::Usage`] for options of the other formats.
    fn texts(&self) -> Result<Option<Texts>, Error> {
        let texts = match self.format {
            Format::Dddmp | Format::Dot => None,
            Format::Explicit => Some(Texts::Explicit),
            Format::Drn => Some(Texts::Drn),
        };
        let wrong = match texts {
            None if self.strategy.is_some() => {
                "`--strategy` needs `--format explicit` or `--format drn`; a dump contains all strategies"
            }
            Some(_) if !self.region.is_empty() => {
                "`--region` selects diagrams; the formats explicit and drn contain all regions"
            }
            _ => return Ok(texts),
        };
        Err(Error::Usage(wrong.to_owned()))
    }
}

/// Runs the command.
///
/// # Errors
/// The input is wrong, a limit is hit, or the directory cannot be written.
pub(super) fn run(args: ExportArgs) -> Result<Status, Error> {
    if let Some(texts) = args.texts()? {
        let ExportArgs { model, preferences, out, limit, strategy, shown, .. } = args;
        let limit = usize::try_from(limit).unwrap_or(usize::MAX);
        return export_explicit::run(Wanted { model, preferences, out, texts, limit, strategy }, &shown);
    }
    let globs = globs(&args.region)?;
    let header = Header { safety: Some(args.preferences.safety.name()), ..args.model.header() };
    let report = ExportReport::to_directory(header, &args.out.display().to_string());
    let (timeout, shown) = (args.model.timeout, args.shown.clone());
    supervise(report, timeout, &shown, move |job| work(job, &args, &globs))
}

fn globs(patterns: &[String]) -> Result<GlobSet, Error> {
    let mut set = GlobSetBuilder::new();
    for pattern in patterns {
        set.add(Glob::new(pattern).map_err(|e| Error::Usage(format!("`--region {pattern}`: {e}")))?);
    }
    set.build().map_err(|e| Error::Usage(format!("`--region`: {e}")))
}

/// Adds to an error that `--region` matches no region.
fn unmatched(error: Error) -> Error {
    match error {
        Error::Usage(message) => Error::Usage(format!("{message}; `--region` matches no name")),
        other => other,
    }
}

fn work(job: &Job<ExportReport>, args: &ExportArgs, globs: &GlobSet) -> Result<(), Error> {
    if args.out.as_os_str() == "-" {
        let message = "a dump is a directory; it cannot be written to standard output";
        return Err(Error::Usage(message.to_owned()));
    }
    check_directory(&args.out)?;
    let read = || load::question(&args.model, &args.preferences, &job.sink);
    let question = job.timed("parse", read, |_, _| ())?;
    job.update(|r| r.header.read(&question.program));
    let build = || load::symbolic(&question.program, &args.model, &job.sink);
    let engine = job.timed("build", build, |_, _| ())?;
    let mut analysis = Analysis::new(&engine, &question.preferences, args.preferences.options());
    phases::run(&mut analysis, Phase::ALL, &job.sink, &mut |_| ())?;
    let inputs = Inputs {
        model: (args.model.path(), sha256(question.program.source.original().as_bytes())),
        preferences: (args.preferences.path(), sha256(question.source.original().as_bytes())),
    };
    let all = args.region.is_empty();
    let wanted = |name: &str| all || globs.is_match(name);
    let selection = Selection { wanted: &wanted, certificate: all && !args.no_certificate };
    let dump = || export(&analysis, &inputs, &selection).map_err(unmatched);
    let dump = job.timed("dump", dump, |_, _| ())?;
    let dot = args.format == Format::Dot;
    let write = || write_directory(dump, &args.out, dot, job.sink.as_ref());
    let manifest = job.timed("write", write, |_, _| ())?;
    let peak = meliora::engine::Engine::usage(&*engine).peak_nodes;
    job.update(|r| {
        r.set(&manifest);
        r.memory.peak_nodes = peak;
    });
    Ok(())
}
