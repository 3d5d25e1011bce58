//! Models with explored states.

use std::sync::{Arc, Mutex};

use meliora::engine::Engine;
use meliora::model::{Program, State};
use meliora::planning::result::ModelCounts;
use meliora::supervise::lock;
use meliora::{Event, Options, Reached, Safety, Settings, States};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

use crate::analysis::{Analysis, Origin};
use crate::errors::{Failure, unpicklable, usage};
use crate::handle::Handle;
use crate::options;
use crate::preferences::{self, Preferences};
use crate::region::{Region, Space};
use crate::values::{as_dict, counts_dict};
use crate::worker::Call;

/// The states of a model's scope, with their choices.
///
/// An exploration answers any number of queries without exploring again. Operators can combine all
/// of their regions.
#[pyclass(frozen, module = "meliora")]
pub(crate) struct Exploration {
    inner: meliora::Exploration,
    space: Space,
    model: Py<PyAny>,
    counts: Mutex<Option<ModelCounts>>,
}

impl Exploration {
    fn new(inner: meliora::Exploration, space: Space, model: Py<PyAny>) -> Self {
        Exploration { inner, space, model, counts: Mutex::new(None) }
    }

    /// Explores a model with the engine of the settings, or with whichever is the first to know all states; `object` is
    /// the model in Python.
    ///
    /// # Errors
    /// The errors of [`meliora::Model::explore`], and of the call.
    pub(crate) fn explore(
        (model, object): (&meliora::Model, Bound<'_, PyAny>),
        space: Space,
        (settings, is_any): (Settings, bool),
        call: &Call,
    ) -> PyResult<Self> {
        let (py, model) = (object.py(), model.clone());
        let work = move || if is_any { model.explore_by_any(settings) } else { model.explore(settings) };
        let inner = space.worker.phase(py, call, "states", work)?;
        Ok(Exploration::new(inner, space, object.unbind()))
    }

    /// Runs an analysis.
    ///
    /// # Errors
    /// The preferences are invalid; a limit is reached, with the results so far.
    pub(crate) fn analyse(
        &self,
        py: Python<'_>,
        preferences: Py<Preferences>,
        options: Options,
        call: &Call,
    ) -> PyResult<Analysis> {
        supports(self.inner.program(), options.safety)?;
        let (inner, source) = (self.inner.clone(), Arc::clone(&preferences.get().source));
        let work = move || inner.prefer(&source, options);
        let analysis = self.space.worker.phase(py, call, "preferences", work)?;
        let program = Arc::clone(self.inner.program());
        let (handle, origin) =
            begun(py, (&self.space, &self.model), program, analysis, (preferences, options))?;
        Analysis::run(py, handle, Arc::new(origin), call)
    }

    /// Runs a whole analysis by the first of several ways to end; `object` is the model in Python.
    ///
    /// # Errors
    /// The errors of [`Exploration::analyse`].
    pub(crate) fn analyse_by_any(
        (model, object): (&meliora::Model, Bound<'_, PyAny>),
        space: &Space,
        settings: Settings,
        (preferences, options): (Py<Preferences>, Options),
        call: &Call,
    ) -> PyResult<Analysis> {
        let (py, program) = (object.py(), Arc::clone(model.program()));
        supports(&program, options.safety)?;
        let (model, source) = (model.clone(), Arc::clone(&preferences.get().source));
        let supervisor = Arc::clone(&space.worker.supervisor);
        let work = move || {
            let listen = |event: Event<'_>| {
                if let Event::Part(phase, part) = event {
                    supervisor.set_position(phase.name(), part.to_owned());
                }
            };
            model.check_by_any(&source, options, settings, &listen)
        };
        let (analysis, limit) = space.worker.phase(py, call, "states", work)?;
        let place = (space, &object.unbind());
        let (handle, origin) = begun(py, place, program, analysis, (preferences, options))?;
        let limit = limit.map(|limit| Failure::of(limit.into()).at(space.worker.supervisor.position()));
        Analysis::ended(py, handle, Arc::new(origin), limit)
    }

    /// Answers a question about paths by the first of several ways to end.
    ///
    /// # Errors
    /// The errors of [`meliora::Model::ask_by_any`], and of the call.
    pub(crate) fn reach_by_any(
        py: Python<'_>,
        (model, question): (&meliora::Model, String),
        space: &Space,
        settings: Settings,
        call: &Call,
    ) -> PyResult<Reachability> {
        let model = model.clone();
        let answer = move || model.ask_by_any(settings, &|explored| explored.reach_where(&question));
        Reachability::new(py, space, space.worker.phase(py, call, "target", answer)?)
    }

    /// Answers a question about paths that is given as text.
    pub(crate) fn reach_text(&self, py: Python<'_>, question: String, call: &Call) -> PyResult<Reachability> {
        let inner = self.inner.clone();
        self.reach_by(py, call, move || inner.reach_where(&question))
    }

    /// Answers a question in the part of a model that decides it.
    ///
    /// # Errors
    /// The errors of [`meliora::Model::reach_stopping`], and of the call.
    pub(crate) fn reach_stopping(
        py: Python<'_>,
        (model, question): (&meliora::Model, String),
        space: &Space,
        (settings, is_any): (Settings, bool),
        call: &Call,
    ) -> PyResult<Reachability> {
        let model = model.clone();
        let answer = move || match is_any {
            true => model.reach_stopping_by_any(&question, settings),
            false => model.reach_stopping(&question, settings),
        };
        Reachability::new(py, space, space.worker.phase(py, call, "target", answer)?)
    }

    /// Computes the regions of a target.
    fn reach_states(&self, py: Python<'_>, target: States, call: &Call) -> PyResult<Reachability> {
        let inner = self.inner.clone();
        self.reach_by(py, call, move || {
            let regions = inner.reach(&target)?;
            Ok(Reached { target, regions, holds: None, value: None, exploration: inner })
        })
    }

    fn reach_by(
        &self,
        py: Python<'_>,
        call: &Call,
        answer: impl FnOnce() -> meliora::Result<Reached> + Send + 'static,
    ) -> PyResult<Reachability> {
        Reachability::new(py, &self.space, self.space.worker.phase(py, call, "target", answer)?)
    }

    /// Returns the states of a condition, or those with some values.
    fn meant<'py>(&self, py: Python<'py>, condition: &Bound<'py, PyAny>) -> PyResult<Region> {
        let inner = self.inner.clone();
        let states = match condition.extract::<String>() {
            Ok(text) => self.space.worker.long(py, move || inner.states_where(&text))?,
            Err(_) => {
                let fixed = self.space.names.fixed(&as_dict(condition)?)?;
                self.space.worker.long(py, move || inner.slice(&fixed))?
            }
        };
        Ok(self.space.region(states))
    }
}

/// Refuses a safety mode that is not supported for games.
fn supports(program: &Program, safety: Safety) -> PyResult<()> {
    if safety == Safety::Transition && program.players.is_some() {
        let others = "\"action\" and \"prefix\" hold against every strategy of the opponent";
        return Err(usage(format!("safety=\"transition\" of a game is not supported; {others}")));
    }
    Ok(())
}

/// Returns an analysis with the objects and options that it comes from.
fn begun(
    py: Python<'_>,
    (space, model): (&Space, &Py<PyAny>),
    program: Arc<Program>,
    analysis: meliora::Analysis,
    (preferences, options): (Py<Preferences>, Options),
) -> PyResult<(Handle, Origin)> {
    let names = space.names.of_product(py, analysis.program());
    let space = Space { worker: Arc::clone(&space.worker), names };
    let engine = analysis.whole_engine();
    let (storage, scope) = (engine.storage(), engine.settings().scope);
    let exploration = Exploration::new(analysis.exploration(), space.clone(), model.clone_ref(py));
    let origin = Origin {
        model: model.clone_ref(py),
        program,
        exploration: Py::new(py, exploration)?.into_any(),
        preferences,
        storage,
        scope,
        safety: options.safety,
    };
    Ok((Handle::new(analysis, space), origin))
}

#[pymethods]
impl Exploration {
    /// The model.
    #[getter]
    fn model(&self, py: Python<'_>) -> Py<PyAny> {
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

    /// The players of a game, each with the states in which it chooses; {} for other models. A deadlock
    /// belongs to nobody.
    #[getter]
    fn players<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let inner = self.inner.clone();
        let all = PyDict::new(py);
        for (player, states) in self.space.worker.long(py, move || Ok(inner.players()))? {
            all.set_item(player.name, Py::new(py, self.space.region(states))?)?;
        }
        Ok(all)
    }

    /// The states of a game in which the opponent chooses; empty for other models.
    #[getter]
    fn theirs(&self) -> Region {
        self.space.region(self.inner.theirs())
    }

    /// Returns the player that chooses in a state of a game; None for deadlocks and other models.
    ///
    /// Raises:
    ///     UsageError: The state is not in the scope.
    fn owner(&self, py: Python<'_>, state: &Bound<'_, PyAny>) -> PyResult<Option<String>> {
        let state = self.space.names.state(state)?;
        let owner = self.space.worker.quick(py, || self.inner.owner(&state))?;
        Ok(owner.map(|player| player.name))
    }

    /// Returns the successors of the enabled actions of a state, whoever chooses there: for each action a
    /// list of pairs (probability, state). Names are as in `Strategy`.
    ///
    /// Raises:
    ///     UsageError: The state is not in the scope.
    fn successors<'py>(&self, py: Python<'py>, state: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyDict>> {
        let state = self.space.names.state(state)?;
        let steps = self.space.worker.quick(py, || self.inner.steps(&state))?;
        let all = PyDict::new(py);
        for step in steps {
            let pair = |(to, p): (State, f64)| Ok((p, self.space.names.dict(py, &to)?));
            let successors = step.successors.into_iter().map(pair).collect::<PyResult<Vec<_>>>()?;
            all.set_item(step.name, PyList::new(py, successors)?)?;
        }
        Ok(all)
    }

    /// The names of the bits in the order of the diagrams, from the root down; None with the
    /// explicit engine.
    #[getter]
    fn order<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyList>>> {
        options::bit_names(py, &self.inner)
    }

    /// Returns the states that satisfy a condition in the model's language, such as 'x = 3 &
    /// "goal"', or in which some variables have the values of a dictionary, or of arguments:
    /// `explored.where(x=3)`.
    ///
    /// Raises:
    ///     InputError: The condition is invalid (the error shows the place), or has no value in
    ///         some state.
    #[pyo3(name = "where", signature = (condition=None, /, **values))]
    fn states_where(
        &self,
        py: Python<'_>,
        condition: Option<&Bound<'_, PyAny>>,
        values: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Region> {
        match (condition, values) {
            (Some(condition), None) => self.meant(py, condition),
            (None, Some(values)) => self.meant(py, values.as_any()),
            _ => Err(usage("where() has either a condition or values of variables")),
        }
    }

    /// Computes the states from which some strategy, and from which every strategy, reaches a
    /// target with probability one, and with positive probability. In a game these are the states from
    /// which we, and from which the opponent can enforce this.
    ///
    /// Args:
    ///     target: A region, a dictionary of values, or a text: a condition in the model's language,
    ///         a temporal formula such as 'G F x = 3', or a property such as 'P>=1 [ F x = 3 ]' or
    ///         'Pmax=? [ F x = 3 ]'; of a game, '<<p1>> P>=1 [ F x = 3 ]'.
    ///         For a temporal formula other than 'F condition', the regions are of the product with
    ///         its monitors, in the states where these begin.
    ///
    /// `Model.reach` can leave out the states behind the target, which are explored here already.
    #[pyo3(signature = (target, *, timeout=None, progress=None))]
    fn reach(
        &self,
        py: Python<'_>,
        target: &Bound<'_, PyAny>,
        timeout: Option<&Bound<'_, PyAny>>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Reachability> {
        let call = Call::new(timeout, progress)?;
        if let Ok(text) = target.extract::<String>() {
            return self.reach_text(py, text, &call);
        }
        let states = match target.cast::<Region>() {
            Ok(region) => region.get().states.clone(),
            Err(_) => self.meant(py, target)?.states,
        };
        self.reach_states(py, states, &call)
    }

    /// Analyses the exploration under preferences, as `Model.check` without exploring again. With
    /// `history = play` the model is explored anew in product with its monitors.
    #[pyo3(signature = (preferences, *, safety="prefix", max_level=None, timeout=None, progress=None))]
    fn check(
        &self,
        py: Python<'_>,
        preferences: &Bound<'_, PyAny>,
        safety: &str,
        max_level: Option<i128>,
        timeout: Option<&Bound<'_, PyAny>>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Analysis> {
        let options = options::planning(safety, max_level)?;
        let call = Call::new(timeout, progress)?;
        let preferences = preferences::given(py, preferences, &self.space.names.program)?;
        self.analyse(py, preferences, options, &call)
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
#[pyclass(frozen, module = "meliora")]
pub(crate) struct Reachability {
    /// The target; for a temporal formula other than `F condition`, the states from which it can be
    /// satisfied from then on, almost surely.
    #[pyo3(get)]
    target: Py<Region>,
    /// For a property, True if it is true in all initial states; None if it only asks for a number,
    /// or if the bounds of the number do not decide it.
    #[pyo3(get)]
    holds: Option<bool>,
    /// For a property about a number, bounds (lower, upper) of the probability or of the expected
    /// reward in every initial state; else None.
    #[pyo3(get)]
    value: Option<(f64, f64)>,
    /// The states from which some strategy reaches the target with probability one.
    #[pyo3(get)]
    pmax_one: Py<Region>,
    /// The states from which some strategy reaches the target with positive probability.
    #[pyo3(get)]
    pmax_positive: Py<Region>,
    /// The states from which every strategy reaches the target with probability one.
    #[pyo3(get)]
    pmin_one: Py<Region>,
    /// The states from which every strategy reaches the target with positive probability.
    #[pyo3(get)]
    pmin_positive: Py<Region>,
}

impl Reachability {
    /// Returns an answer; `space` is that of the model without monitors.
    fn new(py: Python<'_>, space: &Space, found: Reached) -> PyResult<Self> {
        let names = space.names.of_product(py, found.exploration.program());
        let space = Space { worker: Arc::clone(&space.worker), names };
        let region = |states| Py::new(py, space.region(states));
        let regions = found.regions;
        Ok(Reachability {
            target: region(found.target)?,
            holds: found.holds,
            value: found.value.as_ref().map(|value| (value.lower, value.upper)),
            pmax_one: region(regions.pmax_one)?,
            pmax_positive: region(regions.pmax_positive)?,
            pmin_one: region(regions.pmin_one)?,
            pmin_positive: region(regions.pmin_positive)?,
        })
    }
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
