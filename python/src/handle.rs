//! The handle by which the classes of the package share one analysis.

use std::sync::{Arc, Mutex};

use meliora::engine::Engine;
use meliora::model::State;
use meliora::supervise::lock;
use meliora::{Analysis, AnalysisResult, Event, Result};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::errors::{Failure, usage};
use crate::region::Space;
use crate::worker::Call;

/// Maximum number of initial states with values.
const MOST_STATES: usize = 1 << 20;

/// An analysis, its results while it runs, and the origin of its regions.
#[derive(Clone)]
pub(crate) struct Handle {
    analysis: Arc<Mutex<Analysis>>,
    known: Arc<Mutex<AnalysisResult>>,
    pub(crate) space: Space,
}

impl Handle {
    pub(crate) fn new(analysis: Analysis, space: Space) -> Self {
        let known = Arc::new(Mutex::new(analysis.result().clone()));
        Handle { analysis: Arc::new(Mutex::new(analysis)), known, space }
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
            lock(&analysis).run(&mut |event| match event {
                Event::Part(phase, part) => reporter.report(phase.name(), part.to_owned()),
                event => lock(&known).add(event),
            })
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
        self.space.worker.phase(py, call, phase, move || query(&lock(&analysis)))
    }

    /// Returns a region of each objective by its name: `almost-sure`, `positive` or `target`.
    pub(crate) fn objective_regions<'py>(&self, py: Python<'py>, what: &str) -> PyResult<Bound<'py, PyDict>> {
        let found = self.quick(py, |analysis| {
            let region =
                |name: &String| Some((name.clone(), analysis.region(format!("{what}:{name}").as_str())?));
            let objectives = analysis.preferences().objectives.iter().map(|objective| &objective.name);
            Ok(objectives.filter_map(region).collect::<Vec<_>>())
        })?;
        let all = PyDict::new(py);
        for (name, states) in found {
            all.set_item(name, Py::new(py, self.space.region(states))?)?;
        }
        Ok(all)
    }

    /// Returns the given states of the scope; without any, the initial states.
    pub(crate) fn states(
        &self,
        py: Python<'_>,
        states: Option<Vec<Bound<'_, PyAny>>>,
    ) -> PyResult<Vec<State>> {
        let Some(states) = states else {
            return self.quick(py, |analysis| {
                analysis.engine().list_states(&analysis.engine().initial_states(), MOST_STATES)
            });
        };
        let names = &self.space.names;
        let states: Vec<State> = states.iter().map(|state| names.state(state)).collect::<PyResult<_>>()?;
        for state in &states {
            let all =
                |a: &meliora::Analysis| a.whole_engine().contains(&a.whole_engine().all_states(), state);
            if !self.quick(py, all)? {
                return Err(usage(format!(
                    "{} is not a state of the scope",
                    names.program.show_state(state)
                )));
            }
        }
        Ok(states)
    }
}
