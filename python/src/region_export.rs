//! The export of regions to other packages of decision diagrams.

use meliora::dump::{Diagram, Edge, dddmp, dot};
use meliora::embed::States;
use meliora::advanced::symbolic::Set;
use meliora::advanced::any::AnyStates;
use meliora::engine::Dumpable;
use meliora::{Error, Result};
use pyo3::exceptions::{PyImportError, PyRuntimeError};
use pyo3::prelude::*;

/// Returns a region as a diagram with one root.
///
/// # Errors
/// [`Error::Usage`] if the engine has no diagrams; a limit is reached.
pub(crate) fn diagram(states: &States) -> Result<Diagram> {
    let engine = states.engine().diagrams()?;
    match states.set() {
        AnyStates::Symbolic(x) => engine.diagram(&[Set::States(x.clone())], &[]),
        AnyStates::Explicit(_) => Err(Error::Usage("the region is no diagram".to_owned())),
    }
}

/// Converts the root to a function of the package `dd`.
pub(crate) fn to_dd<'py>(
    py: Python<'py>,
    diagram: &Diagram,
    manager: Option<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let manager = match manager {
        Some(manager) => manager,
        None => new_manager(py)?,
    };
    let known = manager.getattr("vars")?;
    for name in &diagram.variables {
        if !known.contains(name)? {
            manager.call_method1("declare", (name,))?;
        }
    }
    let (yes, no) = (manager.getattr("true")?, manager.getattr("false")?);
    let mut made: Vec<Bound<'py, PyAny>> = Vec::with_capacity(diagram.nodes.len());
    let function = |made: &[Bound<'py, PyAny>], edge: Edge| -> PyResult<Bound<'py, PyAny>> {
        match (edge.is_constant(), edge.is_complemented()) {
            (true, false) => Ok(yes.clone()),
            (true, true) => Ok(no.clone()),
            (false, false) => Ok(made[edge.id() - 2].clone()),
            (false, true) => made[edge.id() - 2].call_method0("__invert__"),
        }
    };
    for node in &diagram.nodes {
        let bit = manager.call_method1("var", (&diagram.variables[node.level as usize],))?;
        let branches = (bit, function(&made, node.then)?, function(&made, node.otherwise)?);
        made.push(manager.call_method1("ite", branches)?);
    }
    function(&made, diagram.roots[0])
}

fn new_manager(py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
    let dd = py.import("dd.autoref").map_err(|error| {
        let wrapped = PyImportError::new_err("`to_dd` needs the package dd: `pip install dd`");
        wrapped.set_cause(py, Some(error));
        wrapped
    })?;
    dd.getattr("BDD")?.call0()
}

pub(crate) fn to_dddmp(diagram: &Diagram) -> PyResult<String> {
    let mut out = Vec::new();
    dddmp::write(diagram, &mut out)?;
    text(out)
}

pub(crate) fn to_dot(diagram: &Diagram) -> PyResult<String> {
    let mut out = Vec::new();
    dot::write(diagram, diagram.roots[0], "region", &mut out)?;
    text(out)
}

fn text(bytes: Vec<u8>) -> PyResult<String> {
    String::from_utf8(bytes).map_err(|_| PyRuntimeError::new_err("the text is no UTF-8"))
}
