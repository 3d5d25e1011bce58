//! Sweeps: one run per combination of values of constants, one row per instance.
//!
//! Each instance is a process of its own: the same command line with `--instance` appended. A
//! limit, an error or the memory of one instance does not affect the others. The process hands over its
//! report and, made from the same type, the row of the table.

mod json;
mod process;
mod table;

use std::collections::BTreeSet;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::Duration;

use clap::Args;
pub(super) use meliora::sweep::Columns;
use meliora::sweep::{self, Ended, Range, Rows, ranges};
use meliora_base::error::{Error, Limit};
use meliora_report::columns::Row;
use meliora_report::envelope::{Envelope, Findings};
use meliora_report::sweep::Instance as Finished;
use serde_json::{Map, Value as Json};

use super::exit::Status;
use super::files::Target;
use super::options::{ModelArgs, ShownArgs};
use super::{load, signals, terminal, watch};
use json::Runs;
use process::{Instance, Outcome, Pool};
use table::Table;

/// The interval between checks for an interruption.
const TICK: Duration = Duration::from_millis(100);

/// The help of `--const` for commands with sweeps.
pub(super) const CONSTANTS: &str = "Values of undefined constants, such as K=4,N=3 (repeatable), or ranges \
    N=1:5, N=0:2:10 and lists N={2,4,8}: one run per combination";

/// The options for sweeps.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Sweeps (constants with ranges or lists: -c N=1:5, N=0:2:10, N={2,4,8})")]
pub(super) struct SweepArgs {
    /// Write one row per instance to this file, as soon as the instance ends; `-` is standard output
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,

    /// Draw the results over the first constant with a range, as a picture (SVG)
    #[arg(long, value_name = "FILE.svg")]
    plot: Option<PathBuf>,

    /// Skip the instances that already have a row in the file; cuts off an incomplete last row
    #[arg(long, requires = "csv")]
    resume: bool,

    /// Run this number of instances in parallel, sharing --memory
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    jobs: Option<u16>,
}

impl SweepArgs {
    /// Runs the sweep that the arguments ask for; returns `None` if they ask for one instance.
    /// `inputs` are the files that are read in addition to the model; `kind` says what the rows contain,
    /// given the constants of the first and of the last instance.
    ///
    /// # Errors
    /// A range is wrong; the file cannot be written or belongs to another sweep.
    pub(super) fn run(
        &self,
        model: &ModelArgs,
        inputs: &[&Path],
        kind: impl FnOnce([&str; 2]) -> Result<Columns, Error>,
        shown: &ShownArgs,
    ) -> Result<Option<Status>, Error> {
        if model.instance.is_some() {
            return Ok(None);
        }
        let ranges = ranges::parse(&model.constants())?;
        let asked = self.csv.is_some() || self.plot.is_some() || self.jobs.is_some();
        if !asked && !ranges.iter().any(|r| r.varies) {
            return Ok(None);
        }
        terminal::set_color(shown.color);
        watch::limit_memory(model.memory());
        let own = model.model.paths().chain([Path::new(&model.order)]);
        let inputs: Vec<&Path> = inputs.iter().copied().chain(own).collect();
        if inputs.contains(&Path::new("-")) {
            let message = "a sweep reads its files once per instance; give files instead of standard input";
            return Err(Error::Usage(message.to_owned()));
        }
        let shown = shown.with_csv(Target::maybe(self.csv.as_deref(), &inputs)?.as_ref())?;
        let ends = [0, ranges::count(&ranges)?.saturating_sub(1)].map(|at| ranges::constants(&ranges, at));
        let columns = kind(ends.each_ref().map(String::as_str))?;
        Sweep::new(self, &inputs, ranges, columns)?.run(&shown).map(Some)
    }
}

impl SweepArgs {
    /// Runs the sweep of a command about a model and preferences, as [`SweepArgs::run`] does.
    ///
    /// # Errors
    /// The errors of [`SweepArgs::run`]; the preferences are wrong for all instances.
    pub(super) fn run_preferences<F: Findings>(
        &self,
        command: &'static str,
        model: &ModelArgs,
        preferences: &Path,
        report: &Envelope<F>,
        shown: &ShownArgs,
    ) -> Result<Option<Status>, Error> {
        let kind = |ends: [&str; 2]| {
            load::check_each(model, ends, |model| model.task(&load::read(preferences)?).map(drop))?;
            Ok(Columns::new(command, report, &[]))
        };
        self.run(model, &[preferences], kind, shown)
    }
}

struct Sweep {
    inner: sweep::Sweep<Target>,
    /// The ways in which the instances ended whose rows the file had.
    known: Kinds,
    plot: Option<(Target, Rows)>,
    jobs: usize,
    /// The notes on properties without an answer, each printed once.
    told: BTreeSet<String>,
}

/// The ways in which instances have ended, with the exit statuses of their processes as far as they are known.
type Kinds = BTreeSet<(Ended, Option<i32>)>;

/// The instances that have ended, those of which the file had the rows not counted.
struct Ends {
    count: usize,
    /// The ways in which all instances have ended.
    kinds: Kinds,
}

impl Sweep {
    fn new(args: &SweepArgs, inputs: &[&Path], ranges: Vec<Range>, columns: Columns) -> Result<Self, Error> {
        let plot = args.plot.as_ref().map(|path| plotted(path, inputs, &ranges)).transpose()?;
        let (inner, jobs) = (sweep::Sweep::new(ranges, columns)?, usize::from(args.jobs.unwrap_or(1)));
        let plot = plot.map(|target| (target, Rows::new()));
        let mut sweep = Sweep { inner, known: Kinds::new(), plot, jobs, told: BTreeSet::new() };
        if let Some(to) = Target::maybe(args.csv.as_deref(), inputs)? {
            match args.resume {
                true => sweep.resume(to)?,
                false => sweep.inner.open(to)?,
            }
        }
        Ok(sweep)
    }

    /// Opens a file, and skips the instances that have a row in it.
    fn resume(&mut self, to: Target) -> Result<(), Error> {
        let mut known = Vec::new();
        self.inner.resume(to, |position, cells| known.push((position, cells)))?;
        self.known = known.iter().map(|(_, cells)| (self.inner.columns.ended(cells), None)).collect();
        if let Some((_, rows)) = &mut self.plot {
            rows.extend(known);
        }
        Ok(())
    }

    /// Returns the number of instances that are left to run.
    fn left(&self) -> usize {
        self.inner.left().count()
    }

    /// Returns whether the rows are printed in place of the table.
    fn prints_rows(&self) -> bool {
        self.inner.to().is_some_and(Target::is_stdout)
    }

    /// Says which instances are not run because the file has their rows.
    fn tell_skipped(&self) {
        let text = match (self.inner.skipped(), self.left()) {
            (0, _) => return,
            (skipped, 0) => format!("all {skipped} instances have a row in the file; nothing is left to run"),
            (skipped, left) => format!("{skipped} instances have a row in the file; {left} are left to run"),
        };
        terminal::message(&format!("note: {text}"));
    }

    /// Says why properties have no answer: the cells of a row are too narrow for that.
    fn tell_unanswered(&mut self, row: &Row) {
        for note in &row.notes {
            if self.told.insert(note.clone()) {
                terminal::message(&format!("note: {note}"));
            }
        }
    }

    fn run(mut self, shown: &ShownArgs) -> Result<Status, Error> {
        if !shown.quiet {
            self.tell_skipped();
        }
        let pool = Arc::new(Pool::default());
        // The processes are ended below. The file has a row for each instance that has ended.
        let _ = signals::set_on_interrupt(&pool.stopped);
        let outcomes = pool.run(self.jobs, self.instances());
        let table = (!shown.json && !self.prints_rows()).then(|| self.table());
        if let Some(table) = &table {
            let style = terminal::stdout_style();
            let lines = table.heading().into_iter().map(|line| style.dim(line.trim_end()) + "\n");
            terminal::print(&lines.collect::<String>())?;
        }
        let mut runs = shown.json.then(|| self.runs()).transpose()?;
        let ends = self.collect(&pool, &outcomes, table.as_ref(), runs.as_mut(), shown);
        pool.stop();
        if terminal::is_unread() {
            return Ok(Status::Done);
        }
        runs.map_or(Ok(()), Runs::finish)?;
        let (ends, left) = (ends?, self.left());
        self.finish()?;
        if ends.count < left {
            terminal::show_error(&Limit::Interrupted.into(), None);
            return Ok(Status::Interrupted);
        }
        Ok(status(&ends.kinds))
    }

    /// Writes what instances have found as they end, until all have ended or the sweep is interrupted.
    fn collect(
        &mut self,
        pool: &Pool,
        outcomes: &Receiver<Outcome>,
        table: Option<&Table>,
        mut runs: Option<&mut Runs>,
        shown: &ShownArgs,
    ) -> Result<Ends, Error> {
        let (mut ends, left) = (Ends { count: 0, kinds: std::mem::take(&mut self.known) }, self.left());
        while ends.count < left {
            match outcomes.recv_timeout(TICK) {
                Ok(Outcome { ended: None, .. }) => break,
                Ok(Outcome { instance, report, row, ended: Some(ended), code }) => {
                    self.note(instance.position, &row, ended, table)?;
                    if !shown.quiet && !shown.json {
                        self.tell_unanswered(&row);
                    }
                    ends.count += 1;
                    ends.kinds.insert((ended, code));
                    let only_prints = self.inner.to().is_none_or(Target::is_stdout) && self.plot.is_none();
                    if only_prints && terminal::is_closed() {
                        return Err(terminal::unread());
                    }
                    if let Some(runs) = &mut runs {
                        runs.push(instance.index, &self.finished(instance.position, report, ended))?;
                    }
                }
                Err(_) if pool.is_stopped() => break,
                Err(RecvTimeoutError::Timeout) => {}
                Err(_) => break,
            }
        }
        Ok(ends)
    }

    /// Completes the file and the plot.
    fn finish(mut self) -> Result<(), Error> {
        self.inner.finish()?;
        let Some((target, rows)) = &self.plot else { return Ok(()) };
        let plot = sweep::plot(&self.inner.ranges, &self.inner.columns, rows);
        plot.map_or(Ok(()), |plot| target.write(&plot.svg()))
    }

    /// Returns the instances that are left to run, each with its command line: the last options
    /// decide.
    fn instances(&self) -> impl Iterator<Item = (Instance, Vec<OsString>)> + Send + use<> {
        let (ranges, jobs) = (Arc::clone(&self.inner.ranges), self.jobs.to_string());
        self.inner.left().enumerate().map(move |(index, position)| {
            let own = ["--instance", &ranges::constants(&ranges, position), "--sharing", &jobs];
            let own = own.map(OsString::from);
            (Instance { index, position }, std::env::args_os().skip(1).chain(own).collect())
        })
    }

    /// Writes a row to the file, and shows it in the table.
    fn note(&mut self, position: usize, row: &Row, ended: Ended, table: Option<&Table>) -> Result<(), Error> {
        let cells = self.inner.columns.cells(row, ended);
        if let Some(table) = table {
            let mut text = table.line(&ranges::constants(&self.inner.ranges, position), &cells) + "\n";
            if let Some(problem) = &row.problem {
                text += &format!("  {problem}\n");
            }
            terminal::print(&text)?;
        }
        self.inner.add(position, &cells)?;
        if let Some((_, rows)) = &mut self.plot {
            rows.insert(position, cells);
        }
        Ok(())
    }

    fn table(&self) -> Table {
        let longest = |r: &Range| r.values.iter().map(|v| v.chars().count()).max().unwrap_or(0);
        let constants =
            self.inner.ranges.iter().map(|r| r.name.chars().count() + "=,".len() + longest(r)).sum::<usize>();
        Table::new(&self.inner.columns, constants.saturating_sub(1), terminal::stdout_style().width)
    }

    fn finished(&self, position: usize, result: Json, ended: Ended) -> Finished {
        let values = self.inner.ranges.iter().zip(ranges::instance(&self.inner.ranges, position));
        let constants: Map<String, Json> = values.map(|(r, v)| (r.name.clone(), value(v))).collect();
        Finished { constants, status: ended.into(), result }
    }

    fn runs(&self) -> Result<Runs, Error> {
        let varying = self.inner.ranges.iter().filter(|r| r.varies);
        let ranges = varying.map(|r| (r.name.clone(), r.values.iter().map(|v| value(v)).collect())).collect();
        Runs::begin(self.inner.columns.command, ranges)
    }
}

/// Checks the file of a plot.
///
/// # Errors
/// The file cannot be written, or no constant varies.
fn plotted(path: &Path, inputs: &[&Path], ranges: &[Range]) -> Result<Target, Error> {
    if path.extension().is_none_or(|extension| !extension.eq_ignore_ascii_case("svg")) {
        let message = "`--plot` draws SVG; give the name of a file that ends with `.svg`";
        return Err(Error::Usage(message.to_owned()));
    }
    if !ranges.iter().any(|range| range.varies) {
        let message = "`--plot` shows results over a constant; give one a range, such as `-c N=1:5`";
        return Err(Error::Usage(message.to_owned()));
    }
    Target::new(path, inputs)
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

/// Returns the status of the sweep. A limit or an error ends only its row; if no row is complete,
/// it decides the status.
fn status(ends: &Kinds) -> Status {
    let ended = |wanted: Ended| ends.iter().any(|(e, _)| *e == wanted);
    let failed = |wanted: Status| ends.iter().any(|(_, code)| *code == Some(wanted.code().into()));
    if ended(Ended::No) {
        Status::No
    } else if ended(Ended::Done) || ends.is_empty() {
        Status::Done
    } else if ended(Ended::Limit) {
        Status::Limit
    } else if failed(Status::Usage) {
        Status::Usage
    } else if failed(Status::Internal) {
        Status::Internal
    } else {
        // An error in the input, or a report of properties none of which could be read.
        Status::Input
    }
}
