//! NumPy arrays. NumPy is imported for the first of them.

use pyo3::exceptions::PyImportError;
use pyo3::prelude::*;
use pyo3::types::PyByteArray;

/// Creates an array over some bytes.
///
/// # Errors
/// NumPy is not installed.
fn array<'py>(py: Python<'py>, bytes: &[u8], dtype: &str, shape: &[usize]) -> PyResult<Bound<'py, PyAny>> {
    let numpy = py.import("numpy").map_err(|error| {
        let wrapped = PyImportError::new_err("arrays need the package numpy: `pip install numpy`");
        wrapped.set_cause(py, Some(error));
        wrapped
    })?;
    // A bytearray is writable, and so is the array over it.
    let flat = numpy.call_method1("frombuffer", (PyByteArray::new(py, bytes), dtype))?;
    flat.call_method1("reshape", (shape.to_vec(),))
}

pub(crate) fn bools<'py>(py: Python<'py>, values: &[bool], shape: &[usize]) -> PyResult<Bound<'py, PyAny>> {
    let bytes: Vec<u8> = values.iter().map(|&b| u8::from(b)).collect();
    array(py, &bytes, "?", shape)
}

pub(crate) fn floats<'py>(py: Python<'py>, values: &[f64], shape: &[usize]) -> PyResult<Bound<'py, PyAny>> {
    let bytes: Vec<u8> = values.iter().flat_map(|x| x.to_ne_bytes()).collect();
    array(py, &bytes, "=f8", shape)
}

pub(crate) fn longs<'py>(py: Python<'py>, values: &[i64], shape: &[usize]) -> PyResult<Bound<'py, PyAny>> {
    let bytes: Vec<u8> = values.iter().flat_map(|x| x.to_ne_bytes()).collect();
    array(py, &bytes, "=i8", shape)
}
