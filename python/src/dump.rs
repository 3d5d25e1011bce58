//! Dumps: regions of an analysis in a folder, without the model.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use meliora::query::{Archive, Selected};
use meliora::supervise::memory::default_memory;
use meliora::{Error, Settings, Storage};
use num_bigint::BigUint;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyTuple};
use serde_json::to_string;

use crate::errors::unpicklable;
use crate::model::Model;
use crate::options;
use crate::preferences;
use crate::values::{Names, plain};
use crate::worker::{Call, Worker};

/// A dump that `Analysis.export` or `meliora export` wrote: regions and strategies, without the model.
///
/// An expression joins names of `regions` by `&`, `|`, `!` and parentheses: "sasi:1 & !sasi:2".
///
/// Args:
///     folder: The folder of the dump.
///     where: A condition over its variables and constants that restricts all answers, such as "r > 2".
///
/// Raises:
///     Error: The dump is invalid.
///     InputError: The condition is invalid.
///     OSError: A file cannot be read.
#[pyclass(frozen, module = "meliora")]
pub(crate) struct Dump {
    archive: Arc<Archive>,
    names: Arc<Names>,
    worker: Arc<Worker>,
    folder: PathBuf,
}

/// Returns the settings of a worker for a dump.
fn settings(worker: &Arc<Worker>) -> Settings {
    let (memory, sink) = (default_memory(), Arc::clone(&worker.supervisor) as _);
    Settings { storage: Storage::Symbolic, memory, sink, ..Settings::default() }
}

impl Dump {
    /// Evaluates an expression, and answers a question about its value.
    fn ask<T: Send + 'static>(
        &self,
        py: Python<'_>,
        regions: String,
        answer: impl FnOnce(&Archive, &Selected) -> Result<T, Error> + Send + 'static,
    ) -> PyResult<T> {
        let archive = Arc::clone(&self.archive);
        self.worker.long(py, move || answer(&archive, &archive.select(&regions)?))
    }
}

#[pymethods]
impl Dump {
    #[new]
    #[pyo3(signature = (folder, r#where=None))]
    fn new(py: Python<'_>, folder: PathBuf, r#where: Option<String>) -> PyResult<Self> {
        let worker = Worker::new(default_memory());
        let (settings, path) = (settings(&worker), folder.clone());
        let open = move || Archive::open(&path, r#where.as_deref(), settings);
        let archive = Arc::new(worker.long(py, open)?);
        let names = Names::new(py, archive.program());
        Ok(Dump { archive, names, worker, folder })
    }

    /// The names of the regions and strategies.
    #[getter]
    fn regions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(py, self.archive.manifest().regions.roots.iter().map(|root| root.name.as_str()))
    }

    /// The manifest as a dictionary: variables, constants, the hashes of the texts, and so on.
    #[getter]
    fn manifest(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        plain(py, to_string(self.archive.manifest()))
    }

    /// Returns the number of states of an expression; of a strategy, the number of pairs of a state and
    /// an action.
    ///
    /// Raises:
    ///     InputError: A name is unknown, or the expression is invalid.
    fn count(&self, py: Python<'_>, regions: String) -> PyResult<BigUint> {
        self.ask(py, regions, Archive::count)
    }

    /// Returns True if a state is in an expression.
    fn contains(&self, py: Python<'_>, regions: String, state: &Bound<'_, PyAny>) -> PyResult<bool> {
        let state = self.names.state(state)?;
        self.ask(py, regions, move |archive, selected| Ok(archive.member(selected, &state)?.is_some()))
    }

    /// Returns the actions of a state in an expression with strategies, such as "strategy:sasi:1".
    ///
    /// Raises:
    ///     UsageError: The expression has no strategy: it is a set of states.
    fn actions<'py>(
        &self,
        py: Python<'py>,
        regions: String,
        state: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyTuple>> {
        let state = self.names.state(state)?;
        let found = self.ask(py, regions, move |archive, selected| match selected {
            Selected::States(_) => Err(Error::Usage("this is a set of states, without actions".to_owned())),
            Selected::Choices(_) => Ok(archive.member(selected, &state)?.and_then(|member| member.choices)),
        })?;
        PyTuple::new(py, found.unwrap_or_default())
    }

    /// Returns up to `limit` states of an expression as dictionaries, in the order of their values.
    #[pyo3(signature = (regions, limit=1000))]
    fn states<'py>(&self, py: Python<'py>, regions: String, limit: i128) -> PyResult<Bound<'py, PyList>> {
        let limit = options::count("limit", limit)?;
        let found = self.ask(py, regions, move |archive, selected| archive.list(selected, limit))?;
        let dicts = found.iter().map(|member| self.names.dict(py, &member.state));
        PyList::new(py, dicts.collect::<PyResult<Vec<_>>>()?)
    }

    fn __repr__(&self) -> String {
        format!(
            "<Dump in {}: {} regions>",
            self.folder.display(),
            self.archive.manifest().regions.roots.len()
        )
    }

    fn __reduce__(&self) -> PyResult<Py<PyAny>> {
        Err(unpicklable("a Dump", "open its folder again"))
    }
}

/// The result of `verify`.
#[pyclass(frozen, get_all, module = "meliora")]
pub(crate) struct Verdict {
    /// True if all conditions hold, and all regions are certified.
    accepted: bool,
    /// The names of the regions that were checked.
    checked: Py<PyTuple>,
    /// The regions that the certificate does not prove, because a limit ended the export.
    uncertified: Py<PyTuple>,
    /// The first condition that does not hold; None if there is none.
    violation: Option<String>,
    /// A state for which it does not hold; None if there is none.
    state: Option<Py<PyDict>>,
}

#[pymethods]
impl Verdict {
    fn __bool__(&self) -> bool {
        self.accepted
    }

    fn __repr__(&self) -> String {
        match &self.violation {
            None if self.accepted => "<Verdict: accepted>".to_owned(),
            None => "<Verdict: not all regions are certified>".to_owned(),
            Some(violation) => format!("<Verdict: refused, {violation}>"),
        }
    }
}

/// Checks the dump in a folder against a model and preferences by one-step conditions, without the code
/// that computes fixpoints.
///
/// Args:
///     folder: The folder of the dump.
///     model: The model that the dump was made from, with the same constants.
///     preferences: The preferences, or the path of their file.
///     timeout, progress: As in `Model.explore`.
///
/// Raises:
///     Error: The dump is invalid, or has no certificate.
///     OSError: A file cannot be read.
#[pyfunction]
#[pyo3(signature = (folder, model, preferences, *, timeout=None, progress=None))]
pub(crate) fn verify(
    py: Python<'_>,
    folder: PathBuf,
    model: &Bound<'_, Model>,
    preferences: &Bound<'_, PyAny>,
    timeout: Option<&Bound<'_, PyAny>>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Verdict> {
    let (call, worker) = (Call::new(timeout, progress)?, Worker::new(default_memory()));
    let source = Arc::clone(&preferences::given(py, preferences, model.get().inner.program())?.get().source);
    let (settings, inner) = (settings(&worker), model.get().inner.clone());
    let work = move || inner.verify(&source, Path::new(&folder), settings);
    let (program, verdict) = worker.phase(py, &call, "verify", work)?;
    let state = verdict.violation.as_ref().and_then(|violation| violation.state.as_ref());
    let state = state.map(|state| Names::new(py, &program).dict(py, state)).transpose()?;
    Ok(Verdict {
        accepted: verdict.is_accepted(),
        checked: PyTuple::new(py, verdict.checked.iter().map(|checked| checked.region.as_str()))?.unbind(),
        uncertified: PyTuple::new(py, &verdict.uncertified)?.unbind(),
        violation: verdict.violation.map(|violation| violation.condition.to_string()),
        state: state.map(Bound::unbind),
    })
}
