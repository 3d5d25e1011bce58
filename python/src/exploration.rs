//! Models with explored states.

use std::sync::{Arc, Mutex};

use meliora::embed;
use meliora::engine::Engine;
use meliora::planning::result::ModelCounts;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

use crate::analysis::{self, Analysis};
use crate::errors::{unpicklable, usage};
use crate::model::Model;
use crate::options::{self, Asked};
use crate::preferences;
use crate::region::{Region, Space};
use crate::values::Names;
use crate::watch::lock;
use crate::worker::{Call, Teller};

/// The states of a model's scope, with their choices.
///
/// An exploration answers any number of queries without exploring again. Operators can combine all
/// of their regions.
#[pyclass(frozen, module = "meliora")]
pub(crate) struct Exploration {
    pub(crate) inner: embed::Exploration,
    pub(crate) space: Space,
    pub(crate) model: Py<Model>,
    counts: Mutex<Option<ModelCounts>>,
}

impl Exploration {
    pub(crate) fn of(inner: embed::Exploration, space: Space, model: Py<Model>) -> Self {
        Exploration { inner, space, model, counts: Mutex::new(None) }
    }

    pub(crate) fn explore(model: &Bound<'_, Model>, asked: &Asked<'_, '_>, call: &Call) -> PyResult<Self> {
        let (py, names) = (model.py(), Arc::clone(&model.get().names));
        let (settings, worker) = asked.settings()?;
        let read = model.get().inner.clone();
        let work = move |teller: &Teller<'_>| {
            teller.turn_to("states", String::new());
            read.explore(settings)
        };
        let inner = worker.run(py, call, work).map_err(|failure| failure.raise(py))?;
        Ok(Exploration::of(inner, Space { worker, names }, model.clone().unbind()))
    }

    /// Computes the regions of a target that is given as a condition.
    pub(crate) fn reach_condition(
        &self,
        py: Python<'_>,
        target: String,
        call: &Call,
    ) -> PyResult<Reachability> {
        let inner = self.inner.clone();
        self.reach_by(py, call, move || inner.states_where(&target))
    }

    fn reach_by(
        &self,
        py: Python<'_>,
        call: &Call,
        target: impl FnOnce() -> meliora::Result<embed::States> + Send + 'static,
    ) -> PyResult<Reachability> {
        let inner = self.inner.clone();
        let work = move |teller: &Teller<'_>| {
            teller.turn_to("target", String::new());
            let target = target()?;
            Ok((inner.reach(&target)?, target))
        };
        let (found, target) = self.space.worker.run(py, call, work).map_err(|failure| failure.raise(py))?;
        let region = |states| Py::new(py, self.space.region(states));
        Ok(Reachability {
            target: region(target)?,
            pmax_one: region(found.pmax_one)?,
            pmax_positive: region(found.pmax_positive)?,
            pmin_one: region(found.pmin_one)?,
            pmin_positive: region(found.pmin_positive)?,
        })
    }

    /// Returns the states of a condition, or those with some values.
    fn meant<'py>(&self, py: Python<'py>, condition: &Bound<'py, PyAny>) -> PyResult<Region> {
        let inner = self.inner.clone();
        let states = match condition.extract::<String>() {
            Ok(text) => self.space.worker.long(py, move || inner.states_where(&text))?,
            Err(_) => {
                let fixed = self.space.names.fixed(&crate::values::as_dict(condition)?)?;
                self.space.worker.long(py, move || inner.slice(&fixed))?
            }
        };
        Ok(self.space.region(states))
    }
}

#[pymethods]
impl Exploration {
    /// The model.
    #[getter]
    fn model(&self, py: Python<'_>) -> Py<Model> {
        self.model.clone_ref(py)
    }

    /// `"symbolic"` or `"explicit"`.
    #[getter]
    fn engine(&self) -> &'static str {
        self.inner.engine().storage().name()
    }

    /// `"reachable"` or `"all"`.
    #[getter]
    fn scope(&self) -> &'static str {
        self.inner.engine().settings().scope.name()
    }

    /// The numbers of `states`, `choices`, `transitions`, `deadlocks` and `initial` states. With
    /// `history = play`, `model_states` is the number of states without monitors.
    #[getter]
    fn counts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let known = lock(&self.counts).clone();
        let counts = match known {
            Some(counts) => counts,
            None => {
                let inner = self.inner.clone();
                let found = self.space.worker.long(py, move || inner.counts())?;
                lock(&self.counts).insert(found).clone()
            }
        };
        counts_dict(py, &counts)
    }

    /// All states of the scope.
    #[getter]
    fn states(&self) -> Region {
        self.space.region(self.inner.states())
    }

    /// The initial states.
    #[getter]
    fn initial(&self) -> Region {
        self.space.region(self.inner.initial())
    }

    /// The states without an enabled command; their only choice is a self-loop.
    #[getter]
    fn deadlocks(&self) -> Region {
        self.space.region(self.inner.deadlocks())
    }

    /// The names of the bits in the order of the diagrams, from the root down; None with the
    /// explicit engine.
    #[getter]
    fn order<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyList>>> {
        options::bit_names(py, &self.inner)
    }

    /// Returns the states that satisfy a condition in the model's language, such as 'x = 3 &
    /// "goal"', or in which some variables have the values of a dictionary.
    ///
    /// Raises:
    ///     InputError: The condition is invalid (the error shows the place), or has no value in
    ///         some state.
    #[pyo3(name = "where")]
    fn states_where(&self, py: Python<'_>, condition: &Bound<'_, PyAny>) -> PyResult<Region> {
        self.meant(py, condition)
    }

    /// Computes the states from which some strategy, and from which every strategy, reaches a
    /// target with probability one, and with positive probability.
    ///
    /// Args:
    ///     target: A region, a condition in the model's language, or a dictionary of values.
    #[pyo3(signature = (target, *, timeout=None, progress=None))]
    fn reach(
        &self,
        py: Python<'_>,
        target: &Bound<'_, PyAny>,
        timeout: Option<f64>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Reachability> {
        let call = Call::new(timeout, progress)?;
        let states = match target.cast::<Region>() {
            Ok(region) => region.get().states.clone(),
            Err(_) => self.meant(py, target)?.states,
        };
        self.reach_by(py, &call, move || Ok(states))
    }

    /// Analyses the exploration under preferences, as `Model.check` without exploring again. With
    /// `history = play` the model is explored anew in product with its monitors.
    #[pyo3(signature = (preferences, *, safety="action", max_level=None, timeout=None, progress=None))]
    fn check(
        &self,
        py: Python<'_>,
        preferences: &Bound<'_, PyAny>,
        safety: &str,
        max_level: Option<usize>,
        timeout: Option<f64>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Analysis> {
        let options = options::planning(safety, max_level)?;
        let call = Call::new(timeout, progress)?;
        let preferences = preferences::given(py, preferences)?;
        analysis::prefer(py, self, preferences, options, &call)
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let states = self.states().count(py)?;
        Ok(format!("<Exploration of {states} states, {}, scope {}>", self.engine(), self.scope()))
    }

    fn __reduce__(&self) -> PyResult<Py<PyAny>> {
        Err(unpicklable("an Exploration", "pickle its `model` and explore again"))
    }
}

/// The qualitative regions of a target.
#[pyclass(frozen, get_all, module = "meliora")]
pub(crate) struct Reachability {
    /// The target.
    target: Py<Region>,
    /// The states from which some strategy reaches the target with probability one.
    pmax_one: Py<Region>,
    /// The states from which some strategy reaches the target with positive probability.
    pmax_positive: Py<Region>,
    /// The states from which every strategy reaches the target with probability one.
    pmin_one: Py<Region>,
    /// The states from which every strategy reaches the target with positive probability.
    pmin_positive: Py<Region>,
}

#[pymethods]
impl Reachability {
    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let count = |region: &Py<Region>| region.get().count(py);
        let (target, one, positive) =
            (count(&self.target)?, count(&self.pmax_one)?, count(&self.pmax_positive)?);
        Ok(format!("<Reachability of {target} states: surely from {one}, possibly from {positive}>"))
    }
}

/// Converts the sizes of a model to a dictionary.
pub(crate) fn counts_dict<'py>(py: Python<'py>, counts: &ModelCounts) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("states", &counts.states)?;
    if let Some(states) = &counts.model_states {
        dict.set_item("model_states", states)?;
    }
    dict.set_item("choices", &counts.choices)?;
    dict.set_item("transitions", &counts.transitions)?;
    dict.set_item("deadlocks", &counts.deadlocks)?;
    dict.set_item("initial", &counts.initial)?;
    Ok(dict)
}

/// Returns the exploration of an analysis, which has other variables with `history = play`.
pub(crate) fn of_planning(
    py: Python<'_>,
    planning: &embed::Planning,
    before: &Space,
) -> (embed::Exploration, Space) {
    let inner = planning.exploration();
    let same = inner.program().variables.len() == before.names.program.variables.len();
    let names = if same { Arc::clone(&before.names) } else { Names::new(py, inner.program()) };
    (inner, Space { worker: Arc::clone(&before.worker), names })
}

/// Checks that a level is not negative.
pub(crate) fn level(k: i64) -> PyResult<usize> {
    usize::try_from(k).map_err(|_| usage(format!("{k} is no level: they are counted from 0")))
}
