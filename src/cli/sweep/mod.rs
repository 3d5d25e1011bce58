//! Sweeps: one run per combination of values of constants, one row per instance.
//!
//! Each instance is a process of its own: the same command line with `--instance` appended. A
//! limit, an error or the memory of one instance does not affect the others.

mod file;
mod process;
pub(super) mod ranges;
mod row;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use clap::Args;
use meliora::error::{Error, Limit};
use serde_json::{Map, Value as Json, json};

use super::exit::Status;
use super::options::{ModelArgs, ShownArgs};
use super::{signals, terminal};
use file::CsvFile;
use process::{Outcome, Pool};
use ranges::Range;
use row::Ended;
pub(super) use row::Job;

/// The interval between checks for an interruption.
const TICK: Duration = Duration::from_millis(100);

/// The options for sweeps.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Sweeps (constants with ranges or lists: -c N=1:5, N=0:2:10, N={2,4,8})")]
pub(super) struct SweepArgs {
    /// Write one row per instance to this file, which is complete after each row
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,

    /// Skip the instances that already have a row in the file
    #[arg(long, requires = "csv")]
    resume: bool,

    /// Run this number of instances in parallel, sharing --memory
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    jobs: Option<u16>,

    /// Run every N-th instance only, starting with the I-th
    #[arg(long, value_name = "I/N", value_parser = shard)]
    shard: Option<(usize, usize)>,
}

/// Reads `I/N` with I from 1 to N.
fn shard(text: &str) -> Result<(usize, usize), String> {
    let numbers = text.split_once('/').and_then(|(i, n)| Some((i.parse().ok()?, n.parse().ok()?)));
    numbers
        .filter(|&(i, n): &(usize, usize)| 1 <= i && i <= n)
        .ok_or_else(|| "expected I/N with I from 1 to N, such as 1/4".to_owned())
}

impl SweepArgs {
    /// Runs the sweep that the arguments ask for; returns `None` if they ask for one instance.
    /// `inputs` are the files that are read in addition to the model.
    ///
    /// # Errors
    /// A range is wrong; the file cannot be written or belongs to another sweep.
    pub(super) fn run(
        &self,
        model: &ModelArgs,
        inputs: &[&Path],
        kind: Job,
        shown: &ShownArgs,
    ) -> Result<Option<Status>, Error> {
        if model.instance.is_some() {
            return Ok(None);
        }
        let ranges = ranges::parse(&model.constants())?;
        let asked = self.csv.is_some() || self.jobs.is_some() || self.shard.is_some();
        if !asked && !ranges.iter().any(|r| r.varies) {
            return Ok(None);
        }
        if model.model.as_os_str() == "-" {
            let message = "a sweep reads the model once per instance; give a file instead of standard input";
            return Err(Error::Usage(message.to_owned()));
        }
        terminal::set_color(shown.color);
        let inputs = [inputs, &[model.model.as_path(), Path::new(&model.order)]].concat();
        Sweep::new(self, &inputs, ranges, kind)?.run(shown).map(Some)
    }
}

/// An instance: its position among all, and its values in the order of the constants.
struct Instance {
    position: usize,
    values: Vec<String>,
}

struct Sweep {
    ranges: Vec<Range>,
    kind: Job,
    instances: Vec<Instance>,
    file: Option<CsvFile>,
    jobs: usize,
}

impl Sweep {
    fn new(args: &SweepArgs, inputs: &[&Path], ranges: Vec<Range>, kind: Job) -> Result<Self, Error> {
        let (first, every) = args.shard.unwrap_or((1, 1));
        let all = ranges::instances(&ranges)?.into_iter().enumerate();
        let own = all.skip(first - 1).step_by(every);
        let mut instances: Vec<Instance> =
            own.map(|(position, values)| Instance { position, values }).collect();
        let mut file = None;
        if let Some(path) = &args.csv {
            let header: Vec<String> = ranges.iter().map(|r| r.name.clone()).chain(kind.columns()).collect();
            let mut csv = CsvFile::new(path, inputs, &header)?;
            if args.resume {
                let starts: Vec<_> = instances.iter().map(|i| (i.position, i.values.join(","))).collect();
                csv.resume(&starts)?;
                instances.retain(|i| !csv.has(i.position));
            }
            csv.write()?;
            file = Some(csv);
        }
        Ok(Sweep { ranges, kind, instances, file, jobs: usize::from(args.jobs.unwrap_or(1)) })
    }

    fn run(mut self, shown: &ShownArgs) -> Result<Status, Error> {
        let pool = Arc::new(Pool::default());
        // The processes are ended below. The file is complete at any time.
        let _ = signals::set_on_interrupt(&pool.stopped);
        let outcomes = pool.run(self.jobs, self.instances.iter().map(|i| self.arguments(i)).collect());
        let mut runs: Vec<(usize, Json)> = Vec::new();
        let mut ends = Vec::new();
        if !shown.json {
            terminal::print(&self.heading())?;
        }
        while ends.len() < self.instances.len() {
            match outcomes.recv_timeout(TICK) {
                Ok(Outcome { ended: None, .. }) => break,
                Ok(Outcome { index, report, ended: Some(ended) }) => {
                    ends.push((ended, report["kind"].as_str().map(str::to_owned)));
                    self.note(index, &report, ended, shown)?;
                    runs.push((index, self.json(index, report, ended)));
                }
                Err(_) if pool.is_stopped() => break,
                Err(std::sync::mpsc::RecvTimeoutError::Timeout) => {}
                Err(_) => break,
            }
        }
        let finished = ends.len() == self.instances.len();
        pool.stop();
        if shown.json {
            terminal::print_json(&self.object(runs))?;
        }
        if !finished {
            terminal::show_error(&Limit::Interrupted.into(), None);
            return Ok(Status::Interrupted);
        }
        Ok(status(&ends))
    }

    /// Returns the command line for one instance: the last options decide.
    fn arguments(&self, instance: &Instance) -> Vec<std::ffi::OsString> {
        let mut arguments: Vec<_> = std::env::args_os().skip(1).collect();
        let jobs = self.jobs.to_string();
        let own = ["--instance", &self.constants(instance), "--beside", &jobs];
        arguments.extend(own.map(std::ffi::OsString::from));
        arguments
    }

    fn constants(&self, instance: &Instance) -> String {
        let named = self.ranges.iter().zip(&instance.values).map(|(r, v)| format!("{}={v}", r.name));
        named.collect::<Vec<_>>().join(",")
    }

    /// Writes a row to the file, and shows it.
    fn note(&mut self, index: usize, report: &Json, ended: Ended, shown: &ShownArgs) -> Result<(), Error> {
        let instance = &self.instances[index];
        let found = self.kind.cells(report, ended);
        if !shown.json {
            terminal::print(&self.line(instance, report, ended, &found))?;
        }
        if let Some(file) = &mut self.file {
            let cells: Vec<String> = instance.values.iter().cloned().chain(found).collect();
            file.add(instance.position, &cells)?;
        }
        Ok(())
    }

    /// Returns the columns for the text output: those whose names do not depend on the number of
    /// levels.
    fn shown_columns(&self) -> Vec<(usize, String)> {
        let hidden = |name: &str| {
            matches!(name, "peak_rss_bytes" | "choices")
                || name.rsplit_once('_').is_some_and(|(_, k)| k.parse::<usize>().is_ok_and(|k| k > 2))
        };
        self.kind.columns().into_iter().enumerate().filter(|(_, name)| !hidden(name)).collect()
    }

    fn width(&self) -> usize {
        self.instances.iter().map(|i| self.constants(i).chars().count()).max().unwrap_or(0).max(9)
    }

    fn heading(&self) -> String {
        let width = self.width();
        let mut line = format!("{:width$}", "constants");
        for (_, name) in self.shown_columns() {
            line += &format!("  {name:>10}");
        }
        terminal::stdout_style().dim(&line) + "\n"
    }

    fn line(&self, instance: &Instance, report: &Json, ended: Ended, cells: &[String]) -> String {
        let width = self.width();
        let mut line = format!("{:width$}", self.constants(instance));
        for (column, name) in self.shown_columns() {
            line += &format!("  {:>wide$}", brief(&cells[column]), wide = name.len().max(10));
        }
        if ended == Ended::Error || ended == Ended::Limit {
            let message = report["message"].as_str().or_else(|| report["error"]["message"].as_str());
            line += &format!("  {}", message.unwrap_or_default());
        }
        line + "\n"
    }

    fn json(&self, index: usize, report: Json, ended: Ended) -> Json {
        let values = self.ranges.iter().zip(&self.instances[index].values);
        let constants: Map<String, Json> = values.map(|(r, v)| (r.name.clone(), value(v))).collect();
        json!({"constants": constants, "status": ended.word(), "result": report})
    }

    fn object(&self, mut runs: Vec<(usize, Json)>) -> Json {
        runs.sort_by_key(|(index, _)| *index);
        let varying = self.ranges.iter().filter(|r| r.varies);
        let ranges: Map<String, Json> =
            varying.map(|r| (r.name.clone(), r.values.iter().map(|v| value(v)).collect())).collect();
        let command = match self.kind {
            Job::Check { .. } => "check",
            Job::Reach => "reach",
            Job::Compare => "compare",
        };
        let runs: Vec<Json> = runs.into_iter().map(|(_, run)| run).collect();
        json!({"schema": "meliora.sweep/1", "command": command, "ranges": ranges, "runs": runs})
    }
}

/// Converts a number or a truth value to JSON.
fn value(text: &str) -> Json {
    let number =
        || text.parse::<i64>().map(Json::from).ok().or_else(|| text.parse::<f64>().ok().map(Json::from));
    match text {
        "true" => Json::Bool(true),
        "false" => Json::Bool(false),
        _ => number().unwrap_or_else(|| Json::from(text)),
    }
}

/// Formats seconds with three decimals.
fn brief(cell: &str) -> String {
    match cell.parse::<f64>() {
        Ok(x) if cell.contains('.') => format!("{x:.3}"),
        _ => cell.to_owned(),
    }
}

/// Returns the status of the sweep. A limit or an error ends only its row; if no row is complete,
/// it decides the status.
fn status(ends: &[(Ended, Option<String>)]) -> Status {
    let ended = |wanted: Ended| ends.iter().any(|(e, _)| *e == wanted);
    match () {
        () if ended(Ended::No) => Status::No,
        () if ended(Ended::Done) || ends.is_empty() => Status::Done,
        () if ended(Ended::Limit) => Status::Limit,
        () if ends.iter().any(|(_, kind)| kind.as_deref() == Some("usage")) => Status::Usage,
        () if ends.iter().any(|(_, kind)| kind.as_deref() == Some("input")) => Status::Input,
        () => Status::Internal,
    }
}
