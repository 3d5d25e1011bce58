//! Progress of long calls.

use std::time::{Duration, Instant};

use meliora::supervise::Position;
use pyo3::prelude::*;

/// The progress of a long call, as received by a `progress` callback.
#[pyclass(frozen, get_all, module = "meliora")]
pub(crate) struct Progress {
    /// The phase: `"model"`, `"preferences"`, `"states"`, `"target"`, `"properties"`, `"counts"`, `"outcomes"`,
    /// `"improvement"`, `"sasi"`, `"spi"`, `"jointly"`, `"values"`, `"strategy"`, `"plays"`, `"shield"`,
    /// `"export"`, `"verify"` or `"picture"`.
    phase: &'static str,
    /// The part of the phase, in words; may be empty.
    detail: String,
    /// Seconds since the call began.
    elapsed: f64,
}

impl Progress {
    fn new(position: &Position, elapsed: Duration) -> Self {
        Progress { phase: position.phase, detail: position.words(), elapsed: elapsed.as_secs_f64() }
    }
}

#[pymethods]
impl Progress {
    fn __repr__(&self) -> String {
        format!("Progress(phase={:?}, detail={:?}, elapsed={:.3})", self.phase, self.detail, self.elapsed)
    }

    fn __str__(&self) -> String {
        match self.detail.as_str() {
            "" => format!("{:.1} s: {}", self.elapsed, self.phase),
            detail => format!("{:.1} s: {}: {detail}", self.elapsed, self.phase),
        }
    }
}

/// The `progress` callback of a call.
pub(crate) struct Callback {
    callback: Option<Py<PyAny>>,
    started: Instant,
}

impl Callback {
    pub(crate) fn new(callback: Option<Py<PyAny>>) -> Self {
        Callback { callback, started: Instant::now() }
    }

    /// Calls the callback, if the work has begun a phase.
    ///
    /// # Errors
    /// An exception raised by the callback.
    pub(crate) fn call(&self, py: Python<'_>, position: &Position) -> PyResult<()> {
        let Some(callback) = &self.callback else { return Ok(()) };
        if position.phase.is_empty() {
            return Ok(());
        }
        callback.call1(py, (Progress::new(position, self.started.elapsed()),)).map(drop)
    }
}
