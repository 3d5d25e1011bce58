//! Options by their Python names.

use std::str::FromStr;
use std::sync::Arc;

use meliora::engine::Order;
use meliora::planning::{Opponent, Options, Scheduler, StrategyKind};
use meliora::supervise::memory::{default_memory, parse};
use meliora::{Exploration, Safety, Scope, Settings, SourceFile, Storage};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyList, PyString};

use crate::errors::usage;
use crate::worker::Worker;

/// Returns the value with a name.
pub(crate) fn named<T: Copy + FromStr>(
    what: &str,
    given: &str,
    known: &[T],
    name: fn(T) -> &'static str,
) -> PyResult<T> {
    given.parse().map_err(|_| {
        let names: Vec<String> = known.iter().map(|&value| format!("{:?}", name(value))).collect();
        usage(format!("{what}={given:?}: it is one of {}", names.join(", ")))
    })
}

pub(crate) fn scope(name: &str) -> PyResult<Scope> {
    named("scope", name, Scope::ALL, Scope::name)
}

/// Returns the engine with a name; `None` for "auto".
fn engine(name: &str) -> PyResult<Option<Storage>> {
    if name == "auto" {
        return Ok(None);
    }
    name.parse().map(Some).map_err(|_| {
        let names: Vec<String> = Storage::ALL.iter().map(|storage| format!("{:?}", storage.name())).collect();
        usage(format!("engine={name:?}: it is one of \"auto\", {}", names.join(", ")))
    })
}

pub(crate) fn strategy_kind(name: &str) -> PyResult<StrategyKind> {
    named("kind", name, StrategyKind::ALL, StrategyKind::name)
}

pub(crate) fn picks(name: &str) -> PyResult<Scheduler> {
    named("picks", name, Scheduler::ALL, Scheduler::name)
}

pub(crate) fn opponent(name: &str) -> PyResult<Opponent> {
    named("opponent", name, Opponent::ALL, Opponent::name)
}

/// Reads the options of an analysis.
///
/// # Errors
/// `UsageError` if the name is unknown or the level is 0.
pub(crate) fn planning(safety: &str, max_level: Option<i128>) -> PyResult<Options> {
    let max_level = counted("max_level", max_level)?;
    let safety = named("safety", safety, Safety::ALL, Safety::name)?;
    if max_level == Some(0) {
        return Err(usage("max_level=0: levels are counted from 1"));
    }
    Ok(Options { safety, max_level })
}

/// Returns a number of something: an argument that is an integer from 0. Larger types than that of the argument
/// are read, so that the error can name it.
///
/// # Errors
/// `UsageError` if it is negative or too large.
pub(crate) fn count<T: TryFrom<i128>>(name: &str, given: i128) -> PyResult<T> {
    T::try_from(given).map_err(|_| {
        let wrong = if given < 0 { "an integer from 0" } else { "a smaller integer" };
        usage(format!("{name}={given}: expected {wrong}"))
    })
}

/// Does the same for an optional argument.
///
/// # Errors
/// See [`count`].
pub(crate) fn counted<T: TryFrom<i128>>(name: &str, given: Option<i128>) -> PyResult<Option<T>> {
    given.map(|given| count(name, given)).transpose()
}

/// The options of an exploration, as given.
pub(crate) struct ExploreOptions<'a, 'py> {
    pub(crate) scope: &'a str,
    pub(crate) engine: &'a str,
    pub(crate) memory: Option<&'a Bound<'py, PyAny>>,
    pub(crate) order: Option<&'a Bound<'py, PyAny>>,
}

impl ExploreOptions<'_, '_> {
    /// Converts the options to settings of the library, with a new worker, and whether several ways race: that is so
    /// for "auto" without an order.
    ///
    /// # Errors
    /// `UsageError` if an option is unknown, or options are inconsistent.
    pub(crate) fn settings(&self) -> PyResult<(Settings, bool, Arc<Worker>)> {
        let order = order(self.order)?;
        let named = engine(self.engine)?;
        if named == Some(Storage::Explicit) && order != Order::Auto {
            return Err(usage("`order` orders bits of diagrams: the engine \"explicit\" has none"));
        }
        let memory = self.memory.map_or_else(|| Ok(default_memory()), memory)?;
        let worker = Worker::new(memory);
        let is_any = named.is_none() && order == Order::Auto;
        let settings = Settings {
            scope: scope(self.scope)?,
            storage: named.unwrap_or_default(),
            memory,
            order,
            threads: std::thread::available_parallelism().map_or(1, usize::from),
            sink: Arc::clone(&worker.supervisor) as _,
            ..Settings::default()
        };
        Ok((settings, is_any, worker))
    }
}

/// Reads a number of bytes: an int, or a text such as `2GiB`.
fn memory(given: &Bound<'_, PyAny>) -> PyResult<u64> {
    if let Ok(text) = given.extract::<String>() {
        return parse(&text).map_err(|wrong| usage(format!("memory={text:?}: {wrong}")));
    }
    let bytes = given.extract::<u64>().ok().filter(|&bytes| bytes > 0 && !given.is_instance_of::<PyBool>());
    bytes.ok_or_else(|| usage(format!("memory={given}: a number of bytes, or a text such as \"2GiB\"")))
}

/// Reads an order: `"auto"`, `"declared"`, or the names of variables or bits from the root down.
fn order(given: Option<&Bound<'_, PyAny>>) -> PyResult<Order> {
    let Some(given) = given else { return Ok(Order::Auto) };
    if given.is_instance_of::<PyString>() {
        let auto = (Order::Auto, Order::Declared);
        return match given.extract::<String>()?.as_str() {
            "auto" => Ok(auto.0),
            "declared" => Ok(auto.1),
            other => Err(usage(format!("order={other:?}: \"auto\", \"declared\" or a list of names"))),
        };
    }
    let names: Vec<String> = given.extract()?;
    Ok(Order::Text(SourceFile::new("order", names.join("\n") + "\n")))
}

/// Returns the names of the bits in the order of an exploration's diagrams; none for the explicit
/// engine.
pub(crate) fn bit_names<'py>(
    py: Python<'py>,
    exploration: &Exploration,
) -> PyResult<Option<Bound<'py, PyList>>> {
    let engine = exploration.engine().symbolic();
    engine.map(|engine| PyList::new(py, engine.encoding().names())).transpose()
}
