//! The handle by which the classes of the package share one analysis.

use std::sync::{Arc, Mutex};

use meliora::supervise::{Reporter, lock, run_phases};
use meliora::{Analysis, AnalysisResult, Event, Phase, Result};
use pyo3::prelude::*;

use crate::errors::Failure;
use crate::region::Space;
use crate::worker::Call;

/// An analysis, its results while it runs, and the origin of its regions.
#[derive(Clone)]
pub(crate) struct Handle {
    analysis: Arc<Mutex<Analysis>>,
    known: Arc<Mutex<AnalysisResult>>,
    pub(crate) space: Space,
}

impl Handle {
    pub(crate) fn new(analysis: Analysis, space: Space) -> Self {
        Handle { analysis: Arc::new(Mutex::new(analysis)), known: Arc::default(), space }
    }

    /// Returns the results so far. Does not wait for the analysis, which may be running.
    pub(crate) fn known(&self) -> AnalysisResult {
        lock(&self.known).clone()
    }

    /// Computes all incomplete phases; each result is known at once.
    ///
    /// # Errors
    /// The errors of [`Analysis::run`], and of the call.
    pub(crate) fn run(&self, py: Python<'_>, call: &Call) -> std::result::Result<(), Failure> {
        let (analysis, known) = (Arc::clone(&self.analysis), Arc::clone(&self.known));
        self.space.worker.run(py, call, move |reporter| {
            let mut analysis = lock(&analysis);
            let report = |phase, part| reporter.report(phase, part);
            for &phase in Phase::ALL {
                let mut listener = |event: Event<'_>| lock(&known).add(event);
                let ended = run_phases(&mut analysis, &[phase], &report, &mut listener);
                *lock(&known) = analysis.result().clone();
                ended?;
            }
            Ok(())
        })
    }

    /// Runs a short query, on the calling thread.
    ///
    /// # Errors
    /// The errors of the query.
    pub(crate) fn quick<T>(&self, py: Python<'_>, query: impl FnOnce(&Analysis) -> Result<T>) -> PyResult<T> {
        self.space.worker.quick(py, || query(&lock(&self.analysis)))
    }

    /// Runs a query that may take long, without a time limit.
    ///
    /// # Errors
    /// The errors of the query; `KeyboardInterrupt`, or any other exception of a signal handler.
    pub(crate) fn long<T: Send + 'static>(
        &self,
        py: Python<'_>,
        query: impl FnOnce(&Analysis) -> Result<T> + Send + 'static,
    ) -> PyResult<T> {
        let analysis = Arc::clone(&self.analysis);
        self.space.worker.long(py, move || query(&lock(&analysis)))
    }

    /// Runs a query within the limits of a call, which calls it `phase`.
    ///
    /// # Errors
    /// The errors of the query; the time of the call is up; an exception of a signal handler or the
    /// callback.
    pub(crate) fn call<T: Send + 'static>(
        &self,
        py: Python<'_>,
        call: &Call,
        phase: &'static str,
        query: impl FnOnce(&Analysis) -> Result<T> + Send + 'static,
    ) -> PyResult<T> {
        let analysis = Arc::clone(&self.analysis);
        let work = move |reporter: &Reporter<'_>| {
            reporter.report(phase, String::new());
            query(&lock(&analysis))
        };
        self.space.worker.run(py, call, work).map_err(|failure| failure.raise(py))
    }
}
