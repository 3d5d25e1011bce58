//! The display of objects in notebooks, as HTML from `meliora._display`.

use pyo3::prelude::*;

/// Returns the HTML of an object, from the given function of `meliora._display`.
pub(crate) fn html(what: &Bound<'_, PyAny>, function: &str) -> PyResult<String> {
    what.py().import("meliora._display")?.call_method1(function, (what,))?.extract()
}
