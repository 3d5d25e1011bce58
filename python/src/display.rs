//! How things show themselves in notebooks: `meliora._display` says it in HTML.

use pyo3::prelude::*;

/// The HTML of something, by the function that `meliora._display` has for it.
pub(crate) fn html(what: &Bound<'_, PyAny>, function: &str) -> PyResult<String> {
    what.py().import("meliora._display")?.call_method1(function, (what,))?.extract()
}
