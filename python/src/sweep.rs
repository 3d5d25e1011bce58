//! The rows of sweeps, and their file.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use meliora::output::{CheckReport, Header, ReachReport, Report, Row};
use meliora::supervise::{lock, memory};
use meliora::sweep::{Ended, Range, RegularFile, Sweep};
use meliora::{Error, Usage, question, sweep};
use pyo3::prelude::*;

use crate::analysis::Analysis;
use crate::errors::{Failure, usage};

/// The answers to the properties of an instance.
#[pyclass(frozen, name = "_Answers", module = "meliora._native")]
pub(crate) struct Answers {
    pub(crate) answers: question::Answers,
    pub(crate) usage: Option<Usage>,
}

#[pymethods]
impl Answers {
    /// Returns why properties with these names have no answer; None if all have one.
    fn reason(&self, names: Vec<String>) -> Option<String> {
        let answers = names.iter().zip(&self.answers.properties);
        let open = answers
            .filter(|(_, answer)| answer.holds.is_none() && answer.value.iter().flatten().next().is_none());
        let reasons = open.filter_map(|(name, answer)| Some(format!("{name}: {}", answer.reason.as_ref()?)));
        Some(reasons.collect::<Vec<_>>().join("; ")).filter(|reasons| !reasons.is_empty())
    }
}

/// Returns the row of an instance that took these seconds.
fn row(mut report: impl Report, seconds: f64) -> Row {
    report.finish(seconds, memory::peak_rss());
    report.row()
}

/// The columns of a sweep after those of the constants: of an analysis, or of properties with titles.
#[pyclass(frozen, name = "_Columns", module = "meliora._native")]
pub(crate) struct Columns {
    inner: sweep::Columns,
    given: (Option<usize>, Vec<String>, bool),
}

impl Columns {
    fn of((max_level, titles, has_regions): &(Option<usize>, Vec<String>, bool)) -> sweep::Columns {
        match titles.as_slice() {
            [] => sweep::Columns::of_check(*max_level),
            titles => sweep::Columns::of_reach(titles, *has_regions),
        }
    }
}

#[pymethods]
impl Columns {
    #[new]
    fn new(max_level: Option<usize>, titles: Vec<String>, has_regions: bool) -> Self {
        let given = (max_level, titles, has_regions);
        Columns { inner: Columns::of(&given), given }
    }

    /// Returns the cells of an instance: its results after these seconds, as far as they are known, and its end.
    fn cells(
        &self,
        py: Python<'_>,
        found: &Bound<'_, PyAny>,
        seconds: f64,
        status: &str,
    ) -> PyResult<Vec<String>> {
        let ended = match status {
            "done" => Ended::Done,
            "limit" => Ended::Limit,
            _ => return Ok(self.inner.cells(&Default::default(), Ended::Error)),
        };
        let row = if let Ok(analysis) = found.cast::<Analysis>() {
            row(analysis.get().report(py)?, seconds)
        } else if let Ok(found) = found.cast::<Answers>() {
            let Answers { answers, usage } = found.get();
            let mut report = ReachReport::new(Header::of_model(""));
            report.findings.answers = answers.clone();
            usage.iter().for_each(|usage| report.used(*usage));
            row(report, seconds)
        } else {
            row(CheckReport::new(Header::of_model("")), seconds)
        };
        Ok(self.inner.cells(&row, ended))
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> (Bound<'py, PyAny>, (Option<usize>, Vec<String>, bool)) {
        (slf.get_type().into_any(), slf.get().given.clone())
    }
}

/// The rows of a sweep by the positions of their instances, also in a file: each is appended at once.
#[pyclass(frozen, name = "_Rows", module = "meliora._native")]
pub(crate) struct Rows {
    sweep: Mutex<Sweep<RegularFile>>,
    rows: Mutex<BTreeMap<usize, Vec<String>>>,
}

#[pymethods]
impl Rows {
    /// Creates the rows for each combination of the values of constants.
    #[new]
    fn new(
        py: Python<'_>,
        constants: Vec<(String, Vec<String>)>,
        columns: &Bound<'_, Columns>,
    ) -> PyResult<Self> {
        let range = |(name, values)| Range { name, values, varies: true };
        let columns = Columns::of(&columns.get().given);
        let sweep = Sweep::new(constants.into_iter().map(range).collect(), columns);
        let sweep = sweep.map_err(|error| Failure::of(error).raise(py))?;
        Ok(Rows { sweep: Mutex::new(sweep), rows: Mutex::default() })
    }

    /// Opens the file of the rows, with those that it has if it is resumed.
    ///
    /// Raises:
    ///     UsageError: The file is an input, not a regular file, or belongs to another sweep.
    ///     OSError: The file cannot be read or written.
    fn open(&self, py: Python<'_>, path: PathBuf, resume: bool, inputs: Vec<PathBuf>) -> PyResult<()> {
        let inputs: Vec<&Path> = inputs.iter().map(PathBuf::as_path).collect();
        let mut sweep = lock(&self.sweep);
        let opened = RegularFile::new(&path, &inputs).and_then(|to| match resume {
            true => sweep.resume(to, |position, cells| drop(lock(&self.rows).insert(position, cells))),
            false => sweep.open(to),
        });
        opened.map_err(|error| match error {
            Error::Input(wrong) => {
                let places = wrong
                    .iter()
                    .map(|d| format!("{}, line {}: {}", path.display(), d.position().0, d.message));
                let places = places.collect::<Vec<_>>().join("\n");
                usage(places + "; without `resume` the file is overwritten")
            }
            other => Failure::of(other).raise(py),
        })
    }

    /// The names of the columns.
    #[getter]
    fn header(&self) -> Vec<String> {
        lock(&self.sweep).header()
    }

    /// Returns the positions of the instances that have no row.
    fn missing(&self) -> Vec<usize> {
        lock(&self.sweep).left().collect()
    }

    /// Adds a row: the cells after those of the constants.
    fn add(&self, py: Python<'_>, position: usize, cells: Vec<String>) -> PyResult<()> {
        let added = lock(&self.sweep).add(position, &cells);
        lock(&self.rows).insert(position, cells);
        added.map_err(|error| Failure::of(error).raise(py))
    }

    /// Sorts the rows of the file by their instances.
    fn finish(&self, py: Python<'_>) -> PyResult<()> {
        lock(&self.sweep).finish().map_err(|error| Failure::of(error).raise(py))
    }

    /// Returns the rows in the order of their instances, each with its position.
    fn rows(&self) -> Vec<(usize, Vec<String>)> {
        let ranges = lock(&self.sweep).ranges.clone();
        let constants = |position| sweep::ranges::instance(&ranges, position).into_iter().map(str::to_owned);
        let rows = lock(&self.rows).clone().into_iter();
        rows.map(|(position, cells)| (position, constants(position).chain(cells).collect())).collect()
    }
}
