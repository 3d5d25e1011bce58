//! The JSON report of a sweep, whose runs are written as soon as those before them are.

use std::collections::BTreeMap;

use meliora_base::error::{Error, Limit};
use meliora_base::json::pretty;
use meliora_report::sweep::{Instance, SweepReport};
use serde_json::{Map, Value as Json};

use super::super::terminal;

/// The end of a report without runs.
const NO_RUNS: &str = "]\n}";

pub(crate) struct Runs {
    /// The number of runs that are written.
    written: usize,
    /// The texts of runs that have ended before an earlier one.
    waiting: BTreeMap<usize, String>,
}

impl Runs {
    /// Writes the beginning of a report.
    ///
    /// # Errors
    /// Standard output cannot be written.
    pub(crate) fn begin(command: &'static str, ranges: Map<String, Json>) -> Result<Self, Error> {
        let empty = text(pretty(&SweepReport::new(command, ranges, Vec::new())))?;
        terminal::print_bytes(empty.strip_suffix(NO_RUNS).unwrap_or(&empty).as_bytes())?;
        Ok(Runs { written: 0, waiting: BTreeMap::new() })
    }

    /// Adds the run with this number; runs are written in the order of their numbers.
    ///
    /// # Errors
    /// Standard output cannot be written.
    pub(crate) fn push(&mut self, number: usize, run: &Instance) -> Result<(), Error> {
        self.waiting.insert(number, text(pretty(run))?.replace('\n', "\n    "));
        while let Some(run) = self.waiting.remove(&self.written) {
            self.write(&run)?;
        }
        Ok(())
    }

    fn write(&mut self, run: &str) -> Result<(), Error> {
        let comma = if self.written == 0 { "" } else { "," };
        self.written += 1;
        terminal::print_bytes(format!("{comma}\n    {run}").as_bytes())
    }

    /// Writes the end of the report, with the runs that wait for one that did not end.
    ///
    /// # Errors
    /// Standard output cannot be written.
    pub(crate) fn finish(mut self) -> Result<(), Error> {
        for run in std::mem::take(&mut self.waiting).into_values() {
            self.write(&run)?;
        }
        let before = if self.written == 0 { "" } else { "\n  " };
        terminal::print_bytes(format!("{before}{NO_RUNS}\n").as_bytes())
    }
}

fn text(json: serde_json::Result<String>) -> Result<String, Error> {
    json.map_err(|e| Limit::Output { what: format!("standard output: {e}") }.into())
}
