//! Errors of the library as Python exceptions. The classes are those of `meliora.errors`.

use meliora::error::{Diagnostic, Relief, render};
use meliora::supervise::Position;
use meliora::{Error, Limit};
use pyo3::exceptions::{PyOSError, PyRuntimeError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

/// The reason why a call failed, and the position of the work.
pub(crate) struct Failure(Box<Reason>);

struct Reason {
    cause: Cause,
    position: Position,
}

enum Cause {
    /// An exception raised in Python.
    Raised(PyErr),
    /// An error of the library.
    Library(Error),
}

impl From<PyErr> for Failure {
    fn from(raised: PyErr) -> Self {
        Failure::new(Cause::Raised(raised), Position::default())
    }
}

impl Failure {
    fn new(cause: Cause, position: Position) -> Self {
        Failure(Box::new(Reason { cause, position }))
    }

    pub(crate) fn of(error: Error) -> Self {
        Failure::new(Cause::Library(error), Position::default())
    }

    /// Returns the failure for a bug of this package.
    pub(crate) fn panic(message: &str) -> Self {
        PyRuntimeError::new_err(format!("internal error of meliora: {message}")).into()
    }

    pub(crate) fn at(self, position: Position) -> Self {
        Failure::new(self.0.cause, position)
    }

    /// Converts it to an exception.
    pub(crate) fn raise(self, py: Python<'_>) -> PyErr {
        self.raise_with(py, |_| Ok((py.None(), py.None())))
    }

    /// Converts it to an exception. `known` returns the analysis and its report, which the
    /// exception of a limit contains.
    pub(crate) fn raise_with(
        self,
        py: Python<'_>,
        known: impl FnOnce(&Limit) -> PyResult<(Py<PyAny>, Py<PyAny>)>,
    ) -> PyErr {
        let Reason { cause, position } = *self.0;
        let made = match cause {
            Cause::Raised(raised) => return raised,
            Cause::Library(Error::Input(wrong)) => input(py, &wrong),
            Cause::Library(Error::Limit(reached)) => {
                known(&reached).and_then(|known| limit(py, &reached, &position, known))
            }
            Cause::Library(Error::Io { path, message }) => {
                return PyOSError::new_err(format!("{path}: {message}"));
            }
            Cause::Library(Error::Usage(message)) => return usage(message),
            Cause::Library(Error::ForeignSet) => return usage(Error::ForeignSet.to_string()),
            Cause::Library(other) => instance(py, "Error", (other.to_string(),)),
        };
        made.unwrap_or_else(|error| error)
    }
}

/// Returns the exception for inconsistent arguments.
pub(crate) fn usage(message: impl Into<String>) -> PyErr {
    let message = message.into();
    Python::attach(|py| instance(py, "UsageError", (message,)).unwrap_or_else(|error| error))
}

/// Creates an exception of a class of `meliora.errors`.
fn instance<'py>(
    py: Python<'py>,
    class: &str,
    arguments: impl pyo3::call::PyCallArgs<'py>,
) -> PyResult<PyErr> {
    let class = py.import("meliora.errors")?.getattr(class)?;
    Ok(PyErr::from_value(class.call1(arguments)?))
}

/// Removes advice about the command line, and writes that on constants as Python does.
fn in_python(problem: &Diagnostic) -> Diagnostic {
    let help = problem.help.as_ref().filter(|help| !help.contains("`meliora ") && !help.contains("`--"));
    Diagnostic { help: help.map(|help| with_dictionary(help)), ..problem.clone() }
}

/// Replaces `` `constants N=…,K=…` `` by a dictionary.
fn with_dictionary(help: &str) -> String {
    let written = |rest: &str| -> Option<String> {
        let (list, behind) = rest.split_once('`')?;
        let pair = |one: &str| one.split_once('=').map(|(name, value)| format!("\"{name}\": {value}"));
        let all = list.split(',').map(pair).collect::<Option<Vec<_>>>()?;
        Some(format!("`constants={{{}}}`{behind}", all.join(", ")))
    };
    let found = help.split_once("`constants ");
    let made = found.and_then(|(before, rest)| Some(format!("{before}{}", written(rest)?)));
    made.unwrap_or_else(|| help.to_owned())
}

fn input(py: Python<'_>, wrong: &[Diagnostic]) -> PyResult<PyErr> {
    let wrong: Vec<Diagnostic> = wrong.iter().map(in_python).collect();
    let class = py.import("meliora.errors")?.getattr("Problem")?;
    let problem = |d: &Diagnostic| {
        let (line, column) = d.position();
        let notes = PyTuple::new(py, &d.notes)?;
        let shown = render(std::slice::from_ref(d), false);
        class.call1((&d.message, &d.source.name, line, column, &d.label, &d.help, notes, shown))
    };
    let problems = wrong.iter().map(problem).collect::<PyResult<Vec<_>>>()?;
    instance(py, "InputError", (PyTuple::new(py, problems)?, render(&wrong, false)))
}

fn limit(
    py: Python<'_>,
    limit: &Limit,
    position: &Position,
    (analysis, known): (Py<PyAny>, Py<PyAny>),
) -> PyResult<PyErr> {
    let class = match limit {
        Limit::Time(_) | Limit::Share(_) => "OutOfTime",
        Limit::Memory { .. } | Limit::System { .. } => "OutOfMemory",
        _ => "TooLarge",
    };
    let mut message = match limit {
        Limit::Time(after) => format!("out of time after {} s", after.as_secs_f64()),
        other => other.to_string(),
    };
    message.push_str(advice(limit));
    if !position.phase.is_empty() {
        message.push_str(&format!("; the work ended in the phase `{}`", position.phase));
        let words = position.words();
        if !words.is_empty() {
            message.push_str(&format!(" ({words})"));
        }
    }
    let fields = PyDict::new(py);
    fields.set_item("phase", Some(position.phase).filter(|phase| !phase.is_empty()))?;
    fields.set_item("detail", position.words())?;
    fields.set_item("analysis", analysis)?;
    fields.set_item("known", known)?;
    let class = py.import("meliora.errors")?.getattr(class)?;
    Ok(PyErr::from_value(class.call((message,), Some(&fields))?))
}

/// Returns advice about a limit.
fn advice(limit: &Limit) -> &'static str {
    match limit.relief() {
        Some(Relief::MoreMemory) => "; a larger `memory` raises the limit",
        Some(Relief::LessMemory) => ": a smaller `memory`, or a process that may have more, helps",
        Some(Relief::System) => ": a process that may have more memory helps",
        Some(Relief::Time) => "; a longer `timeout` raises the limit",
        Some(Relief::Listed) => "; a larger `limit` raises it",
        Some(Relief::Symbolic) => "; `engine=\"symbolic\"` has no such limit",
        _ => "",
    }
}

/// Returns the exception for pickling an object that is bound to this process.
pub(crate) fn unpicklable(what: &str, instead: &str) -> PyErr {
    pyo3::exceptions::PyTypeError::new_err(format!(
        "{what} cannot be pickled: it lives in this process; {instead}"
    ))
}
