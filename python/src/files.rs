//! Reading of files.

use std::fs::File;
use std::path::Path;
use std::sync::Arc;

use meliora::SourceFile;
use meliora::lang::Document;
use pyo3::exceptions::PyOSError;
use pyo3::prelude::*;

use crate::errors::Failure;

/// Reads a file; its name is the path.
///
/// # Errors
/// The `OSError` that Python's `open` raises; the text is too large or not UTF-8.
pub(crate) fn open(py: Python<'_>, path: &Path) -> PyResult<Arc<SourceFile>> {
    let file = opened(py, path)?;
    let name = path.display().to_string();
    py.detach(|| SourceFile::read(name, file)).map_err(|error| Failure::of(error).raise(py))
}

/// Reads a model file, and those next to it.
///
/// # Errors
/// See [`open`].
pub(crate) fn document(py: Python<'_>, path: &Path) -> PyResult<Document> {
    opened(py, path)?;
    py.detach(|| Document::open(path)).map_err(|error| Failure::of(error).raise(py))
}

/// Opens a file.
///
/// # Errors
/// The `OSError` that Python's `open` raises.
pub(crate) fn opened(py: Python<'_>, path: &Path) -> PyResult<File> {
    let name = path.display().to_string();
    File::open(path).map_err(|e| match e.raw_os_error() {
        // Python finds the class of the number: FileNotFoundError, PermissionError, …
        Some(number) => {
            let text = py.import("os").and_then(|os| os.call_method1("strerror", (number,)));
            match text.and_then(|text| text.extract::<String>()) {
                Ok(text) => PyOSError::new_err((number, text, name.clone())),
                Err(error) => error,
            }
        }
        None => PyOSError::new_err(format!("{name}: {e}")),
    })
}
