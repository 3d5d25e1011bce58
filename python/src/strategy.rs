//! Strategies, and runs under them.

use std::sync::{Arc, Mutex};

use meliora::Error;
use meliora::embed;
use meliora::output::reason::Words;
use meliora::planning::explain::Explanation as Explained;
use meliora::planning::{Kind, Memory, Rank, Setup};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

use crate::errors::{unpicklable, usage};
use crate::explanation::Explanation;
use crate::levels::rank_of;
use crate::region::Space;
use crate::shared::Shared;
use crate::simulation::{Recorder, Simulation};
use crate::watch::lock;
use crate::worker::{Call, Teller};
use crate::{arrays, options};

/// The strategies of all levels of one kind.
///
/// Actions are named by their labels. An unlabelled command is `module#k`. If a label has several
/// choices in a state, the names distinguish them: `label(m1#2,m2#1)`.
#[pyclass(frozen, module = "meliora")]
pub(crate) struct Strategy {
    worker: Worker,
}

/// The data shared by a strategy and its runs.
#[derive(Clone)]
pub(crate) struct Worker {
    kind: Kind,
    book: Arc<Mutex<embed::Strategy>>,
    pub(crate) space: Space,
}

/// The selection of actions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Which {
    Permitted,
    Progress,
    Kept,
}

impl Which {
    fn named(name: &str) -> PyResult<Self> {
        match name {
            "permitted" => Ok(Which::Permitted),
            "progress" => Ok(Which::Progress),
            "kept" => Ok(Which::Kept),
            _ => Err(usage(format!("which={name:?}: it is one of \"permitted\", \"progress\", \"kept\""))),
        }
    }

    fn names(self, at: &Explained) -> Vec<String> {
        let actions = at.actions.iter().enumerate().filter(|(index, action)| match self {
            Which::Permitted => action.permitted,
            Which::Progress => at.pick == Some(*index),
            Which::Kept => action.kept,
        });
        actions.map(|(_, action)| action.name.clone()).collect()
    }
}

impl Worker {
    /// Explains a state; on a worker thread if a strategy must be computed first.
    fn explain(&self, py: Python<'_>, state: Vec<i64>, memory: Option<Memory>) -> PyResult<Explained> {
        let known = self.space.worker.quick(py, || {
            let mut book = lock(&self.book);
            let book = book.book();
            let memory = memory.map_or_else(|| book.start(&state), Ok)?;
            book.knows(memory).then(|| book.explain(&state, memory)).transpose()
        })?;
        if let Some(found) = known {
            return Ok(found);
        }
        let book = Arc::clone(&self.book);
        let work = move |teller: &Teller<'_>| {
            teller.turn_to("strategy", String::new());
            let mut book = lock(&book);
            let book = book.book();
            let memory = memory.map_or_else(|| book.start(&state), Ok)?;
            book.explain(&state, memory)
        };
        self.space.worker.run(py, &Call::plain(), work).map_err(|failure| failure.raise(py))
    }

    /// Returns a state; it must be in the scope.
    fn state(&self, py: Python<'_>, state: &Bound<'_, PyAny>) -> PyResult<Vec<i64>> {
        let state = self.space.names.state(state)?;
        let inside = self.space.worker.quick(py, || lock(&self.book).book().is_state(&state))?;
        if inside {
            return Ok(state);
        }
        let shown = self.space.names.program.show_state(&state);
        Err(usage(format!("{shown} is no state of the scope")))
    }

    /// Returns for each action if one with its label is selected.
    fn mask<'py>(
        &self,
        py: Python<'py>,
        at: &Explained,
        actions: Option<Vec<String>>,
        which: &str,
    ) -> PyResult<Bound<'py, PyAny>> {
        let actions = actions.unwrap_or_else(|| self.space.names.program.actions.clone());
        let names = Which::named(which)?.names(at);
        // A choice among several with one label is called `label(…)`.
        let label = |name: &str, action: &str| {
            name.strip_prefix(action).is_some_and(|rest| rest.is_empty() || rest.starts_with('('))
        };
        let mask: Vec<bool> =
            actions.iter().map(|action| names.iter().any(|name| label(name, action))).collect();
        arrays::bools(py, &mask, &[mask.len()])
    }

    fn explanation(&self, py: Python<'_>, at: &Explained) -> PyResult<Explanation> {
        let rank = self.space.worker.quick(py, || lock(&self.book).book().rank(&at.state))?;
        let mut book = lock(&self.book);
        let book = book.book();
        let (program, preferences) = (&*self.space.names.program, book.preferences());
        let words = Words { program, preferences, kind: self.kind };
        Explanation::new(py, &self.space.names, at, rank, words)
    }
}

impl Strategy {
    pub(crate) fn new(py: Python<'_>, shared: &Shared, space: &Space, kind: Kind) -> PyResult<Self> {
        let book = space.worker.quick(py, || {
            lock(&shared.planning).strategy(kind).map_err(|_| {
                let name = kind.name().to_uppercase();
                Error::Usage(format!("the levels of {name} are not known: `resume` the analysis first"))
            })
        })?;
        let worker = Worker { kind, book: Arc::new(Mutex::new(book)), space: space.clone() };
        Ok(Strategy { worker })
    }
}

#[pymethods]
impl Strategy {
    /// `"sasi"` or `"spi"`.
    #[getter]
    fn kind(&self) -> &'static str {
        self.worker.kind.name()
    }

    /// Returns the actions of a start state: the permitted ones, the one of the progress strategy,
    /// or those that the safety mode keeps, even if they do not lead to an improvement.
    ///
    /// Args:
    ///     state: A dictionary with a value for every variable.
    ///     which: "permitted", "progress" or "kept".
    ///
    /// Raises:
    ///     UsageError: The state is not in the scope.
    #[pyo3(signature = (state, which="permitted"))]
    fn actions(&self, py: Python<'_>, state: &Bound<'_, PyAny>, which: &str) -> PyResult<Vec<String>> {
        let which = Which::named(which)?;
        let state = self.worker.state(py, state)?;
        Ok(which.names(&self.worker.explain(py, state, None)?))
    }

    /// Returns the successors of the enabled actions: for each action a list of pairs (probability,
    /// state).
    fn successors<'py>(&self, py: Python<'py>, state: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyDict>> {
        let state = self.worker.state(py, state)?;
        let at = self.worker.explain(py, state, None)?;
        let all = PyDict::new(py);
        for action in &at.actions {
            let successors = action
                .successors
                .iter()
                .map(|s| Ok((s.probability, self.worker.space.names.dict(py, &s.state)?)));
            all.set_item(&action.name, PyList::new(py, successors.collect::<PyResult<Vec<_>>>()?)?)?;
        }
        Ok(all)
    }

    /// Explains every enabled action of a start state: if it is permitted, its successors, and the
    /// reason.
    fn explain(&self, py: Python<'_>, state: &Bound<'_, PyAny>) -> PyResult<Explanation> {
        let state = self.worker.state(py, state)?;
        let at = self.worker.explain(py, state, None)?;
        self.worker.explanation(py, &at)
    }

    /// Returns an action mask for reinforcement learning: a Boolean array with an entry for each of
    /// `actions`; None for the labels of the model in the order of `Model.actions`. Needs NumPy.
    ///
    /// This is for start states; use `play` to follow a run.
    #[pyo3(signature = (state, actions=None, which="permitted"))]
    fn mask<'py>(
        &self,
        py: Python<'py>,
        state: &Bound<'py, PyAny>,
        actions: Option<Vec<String>>,
        which: &str,
    ) -> PyResult<Bound<'py, PyAny>> {
        let state = self.worker.state(py, state)?;
        let at = self.worker.explain(py, state, None)?;
        self.worker.mask(py, &at, actions, which)
    }

    /// Starts a run in a state; it keeps the memory of the strategy.
    fn play(&self, py: Python<'_>, state: &Bound<'_, PyAny>) -> PyResult<Play> {
        let state = self.worker.state(py, state)?;
        let memory =
            self.worker.space.worker.quick(py, || lock(&self.worker.book).book().start(&state))?;
        let at = Moment { state, memory, improvements: 0 };
        Ok(Play { worker: self.worker.clone(), at: Mutex::new(at) })
    }

    /// Simulates random runs from a state, as arrays. The same seed gives the same runs, with any
    /// engine, on any machine.
    ///
    /// Args:
    ///     state: The start state of the runs.
    ///     runs: Number of runs.
    ///     steps: Maximum number of steps of a run.
    ///     seed: An integer from 0.
    ///     picks: "permissive" draws uniformly from the permitted actions; "progress" takes the
    ///         action of the progress strategy.
    ///     timeout, progress: As in `Model.explore`.
    #[pyo3(signature = (state, *, runs=1, steps=1000, seed=0, picks="permissive", timeout=None, progress=None))]
    #[expect(clippy::too_many_arguments, reason = "they have names in Python")]
    fn simulate(
        &self,
        py: Python<'_>,
        state: &Bound<'_, PyAny>,
        runs: u64,
        steps: u64,
        seed: u64,
        picks: &str,
        timeout: Option<f64>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Simulation> {
        let setup = Setup { scheduler: options::picks(picks)?, runs, steps, seed };
        let call = Call::new(timeout, progress)?;
        let start = self.worker.state(py, state)?;
        let book = Arc::clone(&self.worker.book);
        let work = move |teller: &Teller<'_>| {
            teller.turn_to("plays", format!("{runs} plays"));
            Recorder::record(&mut lock(&book), setup, &start)
        };
        let worker = &self.worker.space.worker;
        let (tally, record) = worker.run(py, &call, work).map_err(|failure| failure.raise(py))?;
        Simulation::new(py, &self.worker.space.names, &tally, record)
    }

    fn __repr__(&self) -> String {
        format!("<Strategy of {}>", self.worker.kind.name())
    }

    fn __reduce__(&self) -> PyResult<Py<PyAny>> {
        Err(unpicklable("a Strategy", "explanations as text and arrays can be pickled"))
    }
}

/// The position of a run.
struct Moment {
    state: Vec<i64>,
    memory: Memory,
    improvements: u64,
}

/// A run under a strategy, step by step: the caller, or an environment, says what happens.
///
/// Must not be used by several threads at once.
#[pyclass(frozen, module = "meliora")]
pub(crate) struct Play {
    worker: Worker,
    at: Mutex<Moment>,
}

impl Play {
    fn explained(&self, py: Python<'_>) -> PyResult<Explained> {
        let (state, memory) = {
            let at = lock(&self.at);
            (at.state.clone(), at.memory)
        };
        self.worker.explain(py, state, Some(memory))
    }
}

#[pymethods]
impl Play {
    /// The present state.
    #[getter]
    fn state<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let state = lock(&self.at).state.clone();
        self.worker.space.names.dict(py, &state)
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

    /// True if no improvement is left; then no action is permitted.
    #[getter]
    fn over(&self) -> bool {
        lock(&self.at).memory.level == Rank::Finite(0)
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
        self.worker.mask(py, &self.explained(py)?, actions, which)
    }

    /// Explains the present state, as `Strategy.explain`.
    fn explain(&self, py: Python<'_>) -> PyResult<Explanation> {
        self.worker.explanation(py, &self.explained(py)?)
    }

    /// Moves to the state that a step led to. Returns True if the step was an improvement.
    ///
    /// Raises:
    ///     UsageError: The state is not in the scope, or no enabled action leads to it.
    fn step(&self, py: Python<'_>, state: &Bound<'_, PyAny>) -> PyResult<bool> {
        let state = self.worker.state(py, state)?;
        let (from, memory) = {
            let at = lock(&self.at);
            (at.state.clone(), at.memory)
        };
        let program = &self.worker.space.names.program;
        let improved = self.worker.space.worker.quick(py, || {
            let steps = program.steps(&from).map_err(|f| meliora::model::fault::error(program, &f, &from))?;
            if !steps.iter().any(|step| step.successors.iter().any(|(to, _)| *to == state)) {
                let (from, to) = (program.show_state(&from), program.show_state(&state));
                return Err(Error::Usage(format!("no enabled action leads from {from} to {to}")));
            }
            lock(&self.worker.book).book().after(memory, &from, &state)
        });
        let (memory, is_improvement) = improved?;
        let mut at = lock(&self.at);
        let improvements = at.improvements + u64::from(is_improvement);
        *at = Moment { state, memory, improvements };
        Ok(is_improvement)
    }

    fn __repr__(&self) -> String {
        let at = lock(&self.at);
        format!("<Play at {}>", self.worker.space.names.program.show_state(&at.state))
    }

    fn __reduce__(&self) -> PyResult<Py<PyAny>> {
        Err(unpicklable("a Play", "its `state` can be"))
    }
}
