//! Runs under a strategy, step by step.

use std::sync::Mutex;

use meliora::model::{State, fault};
use meliora::planning::Memory;
use meliora::planning::explain::Explanation as Explained;
use meliora::supervise::lock;
use meliora::{Error, Rank};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::errors::unpicklable;
use crate::explanation::Explanation;
use crate::strategy::{SharedStrategy, Which};
use crate::values::rank_of;

/// The position of a run.
struct Moment {
    state: State,
    memory: Memory,
    improvements: u64,
}

/// A run under a strategy, step by step: the caller, or an environment, says what happens.
///
/// Must not be used by several threads at once.
#[pyclass(frozen, module = "meliora")]
pub(crate) struct Play {
    shared: SharedStrategy,
    at: Mutex<Moment>,
}

impl Play {
    /// Starts a run in a state.
    pub(crate) fn start(py: Python<'_>, shared: SharedStrategy, state: State) -> PyResult<Self> {
        let start = state.clone();
        let memory = shared.query(py, move |strategy| strategy.start(&start))?;
        let at = Moment { state, memory, improvements: 0 };
        Ok(Play { shared, at: Mutex::new(at) })
    }

    fn explained(&self, py: Python<'_>) -> PyResult<Explained> {
        let (state, memory) = {
            let at = lock(&self.at);
            (at.state.clone(), at.memory)
        };
        self.shared.explain(py, state, Some(memory))
    }
}

#[pymethods]
impl Play {
    /// The present state.
    #[getter]
    fn state<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let state = lock(&self.at).state.clone();
        self.shared.space.names.dict(py, &state)
    }

    /// The number of improvements that the strategy still aims for: an int, or `math.inf`; 0 at the
    /// end of the run.
    #[getter]
    fn ahead<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let memory = lock(&self.at).memory;
        rank_of(py, memory.level)
    }

    /// The number of improvements so far.
    #[getter]
    fn improvements(&self) -> u64 {
        lock(&self.at).improvements
    }

    /// True if no improvement is left and no objective is pursued, or if the pursued objective is
    /// achieved.
    #[getter]
    fn over(&self, py: Python<'_>) -> PyResult<bool> {
        let (state, memory) = {
            let at = lock(&self.at);
            (at.state.clone(), at.memory)
        };
        if memory.pursuit.is_none() {
            return Ok(memory.level == Rank::Finite(0));
        }
        self.shared.quick(py, |strategy| Ok(strategy.left(memory, &state)?.is_empty()))
    }

    /// The objective that the run pursues, once no improvement is left, or several as "C and D"; None
    /// for strategies that achieve none.
    #[getter]
    fn pursues(&self, py: Python<'_>) -> PyResult<Option<String>> {
        let memory = lock(&self.at).memory;
        self.shared.quick(py, |strategy| {
            let pursued = strategy.pursued(memory);
            Ok((!pursued.is_empty()).then(|| strategy.preferences().names(&pursued).join(" and ")))
        })
    }

    /// Returns the actions of the present state, as `Strategy.actions`.
    #[pyo3(signature = (which="permitted"))]
    fn actions(&self, py: Python<'_>, which: &str) -> PyResult<Vec<String>> {
        let which = Which::named(which)?;
        Ok(which.names(&self.explained(py)?))
    }

    /// Returns the action mask of the present state, as `Strategy.mask`.
    #[pyo3(signature = (actions=None, which="permitted"))]
    fn mask<'py>(
        &self,
        py: Python<'py>,
        actions: Option<Vec<String>>,
        which: &str,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.shared.mask(py, &self.explained(py)?, actions, which)
    }

    /// Explains the present state, as `Strategy.explain`.
    fn explain(&self, py: Python<'_>) -> PyResult<Explanation> {
        self.shared.explanation(py, &self.explained(py)?)
    }

    /// Moves to the state that a step led to. Returns True if the step was an improvement.
    ///
    /// Raises:
    ///     UsageError: The state is not in the scope, or no enabled action leads to it.
    fn step(&self, py: Python<'_>, state: &Bound<'_, PyAny>) -> PyResult<bool> {
        let state = self.shared.state(py, state)?;
        let (from, memory) = {
            let at = lock(&self.at);
            (at.state.clone(), at.memory)
        };
        let to = state.clone();
        let improved = self.shared.query(py, move |strategy| {
            let program = strategy.program();
            let steps = program.steps(&from).map_err(|f| fault::error(program, &f, &from))?;
            if !steps.iter().any(|step| step.successors.iter().any(|(reached, _)| *reached == to)) {
                let (from, to) = (program.show_state(&from), program.show_state(&to));
                return Err(Error::Usage(format!("no enabled action leads from {from} to {to}")));
            }
            strategy.after(memory, &from, &to)
        });
        let (memory, is_improvement) = improved?;
        let mut at = lock(&self.at);
        let improvements = at.improvements + u64::from(is_improvement);
        *at = Moment { state, memory, improvements };
        Ok(is_improvement)
    }

    fn __repr__(&self) -> String {
        let at = lock(&self.at);
        format!("<Play at {}>", self.shared.space.names.program.show_state(&at.state))
    }

    fn __reduce__(&self) -> PyResult<Py<PyAny>> {
        Err(unpicklable("a Play", "its `state` can be"))
    }
}
