//! `meliora query`: counts and lists regions of a dump.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use clap::Args;
use meliora::supervise::{memory, parse_duration};
use meliora_base::error::Error;
use meliora_engine::{Scope, Settings};
use meliora_model::valuation::Valuation;
use meliora_query::{Archive, Selected};
use meliora_report::QueryReport;
use meliora_report::query::{Contained, Rows};

use super::exit::Status;
use super::files::Target;
use super::load;
use super::options::{self, Limits, ShownArgs};
use super::supervise::{Job, supervise};

/// Count and list regions of a dump, or look up states, without the model
#[derive(Debug, Clone, Args)]
#[command(after_help = "Examples:
  meliora query toy.dump 'sasi:1 & !sasi:2' --list 10
  meliora query toy.dump reachable --where 's > 1' --count")]
pub(super) struct QueryArgs {
    /// Directory of the dump
    #[arg(value_name = "DIR")]
    directory: PathBuf,

    /// Regions joined by `&`, `|`, `!` and parentheses, such as 'sasi:1 & !sasi:2'
    #[arg(value_name = "REGION_EXPR")]
    region: String,

    /// Print only the number of states (the default also prints the expression)
    #[arg(long)]
    count: bool,

    /// Test whether a state, such as r=2,c=2, is in the region (repeatable; exit status 1 if one is
    /// not)
    #[arg(long, value_name = "STATE", allow_hyphen_values = true)]
    contains: Vec<String>,

    /// List at most this number of states
    #[arg(long, value_name = "N")]
    list: Option<usize>,

    /// Write the listed states to this file as comma-separated values, all of them without `--list`; `-` is
    /// standard output
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,

    /// Restrict the region to states with this property, such as 'battery > 3 & !flag'
    #[arg(long = "where", value_name = "EXPR", allow_hyphen_values = true)]
    condition: Option<String>,

    #[command(flatten)]
    limits: LimitArgs,
    #[command(flatten)]
    shown: ShownArgs,
}

/// The limits of memory and time for commands on a dump.
#[derive(Debug, Clone, Args)]
pub(super) struct LimitArgs {
    /// Memory for the node table and the operation cache, such as 2GiB; the process needs up to 64
    /// MiB more [default: half of the memory that the process may use]
    #[arg(help_heading = options::LIMITS, long, value_name = "SIZE", value_parser = memory::parse)]
    memory: Option<u64>,

    /// Stop after this time, such as 30s or 5m
    #[arg(help_heading = options::LIMITS, long, value_name = "DURATION", value_parser = parse_duration)]
    timeout: Option<Duration>,
}

impl LimitArgs {
    /// Returns the memory limit in bytes.
    pub(super) fn memory(&self) -> u64 {
        self.memory.unwrap_or_else(memory::default_memory)
    }

    /// Returns the limits of a run.
    pub(super) fn limits(&self) -> Limits {
        Limits { timeout: self.timeout, memory: self.memory() }
    }

    /// Returns the settings of the engine.
    pub(super) fn settings<R>(&self, scope: Scope, job: &Job<R>) -> Settings {
        let memory = self.memory();
        Settings { scope, memory, sink: Arc::clone(&job.sink) as _, ..Settings::default() }
    }
}

/// Runs the command.
///
/// # Errors
/// The dump or the region expression is wrong, or a limit is hit.
pub(super) fn run(args: QueryArgs) -> Result<Status, Error> {
    let directory = args.directory.display().to_string();
    let mut report = QueryReport::of_region(&directory, &args.region, args.condition.as_deref());
    report.plain = args.count;
    let csv = Target::maybe(args.csv.as_deref(), &[])?;
    let (limits, shown) = (args.limits.limits(), args.shown.with_csv(csv.as_ref())?);
    supervise(report, limits, &shown, move |job| work(job, &args, csv.as_ref()))
}

fn work(job: &Job<QueryReport>, args: &QueryArgs, csv: Option<&Target>) -> Result<(), Error> {
    let settings = args.limits.settings(Scope::All, job);
    let open = || Archive::open(load::dump(&args.directory)?, args.condition.as_deref(), settings);
    let archive = job.timed("load", open, |_, _| ())?;
    let selected = job.timed("select", || archive.select(&args.region), |_, _| ())?;
    job.update(|r| {
        r.kind = Some(if matches!(selected, Selected::States(_)) { "states" } else { "choices" });
    });
    // The count is the default.
    if args.count || (args.contains.is_empty() && args.list.is_none()) {
        let count = archive.count(&selected)?;
        job.update(|r| r.count = Some(count.into()));
    }
    for text in &args.contains {
        let state = archive.state(text)?;
        let member = archive.member(&selected, &state)?;
        let found = Contained {
            state: Valuation::new(archive.program(), &state),
            contained: member.is_some(),
            choices: member.and_then(|m| m.choices),
        };
        job.update(|r| r.contains.push(found));
    }
    if args.list.is_none() && csv.is_none() {
        return Ok(());
    }
    let members = archive.list(&selected, args.list.unwrap_or(usize::MAX))?;
    if members.is_empty() && args.list != Some(0) {
        job.sink.warn("no state to list: the selection is empty");
    }
    let rows = Rows::new(archive.program(), members);
    if let Some(csv) = csv {
        csv.write(&rows.csv(matches!(selected, Selected::Choices(_))))?;
    }
    job.update(|r| r.states = args.list.map(|_| rows));
    Ok(())
}
