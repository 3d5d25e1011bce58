//! Analyses under preferences.

use std::sync::{Arc, Mutex};

use meliora::embed::{Drawing, Planning};
use meliora::engine::Engine;
use meliora::output::page::Picture;
use meliora::output::{CheckReport, Header, Report, Style};
use meliora::planning::{Kind, Options, Phase};
use meliora::{Result, SourceFile};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use crate::errors::{Failure, unpicklable, usage};
use crate::exploration::{self, Exploration, counts_dict};
use crate::levels::Levels;
use crate::model::Model;
use crate::options::{self, Asked};
use crate::preferences::Preferences;
use crate::region::{self, Region, Space};
use crate::shared::Shared;
use crate::strategy::Strategy;
use crate::watch::lock;
use crate::worker::{Call, Teller};
use crate::{display, size};

/// The result of `Model.check`: the states from which improvements are possible or sure, and how
/// many.
///
/// `sasi` and `spi` are the levels; `target`, `almost_sure` and `positive` are the regions of each
/// objective. `classes` are the states with the same most preferred objectives, and `strategy`
/// returns the strategies. Several threads may use an analysis: their calls take turns.
#[pyclass(frozen, module = "meliora")]
pub(crate) struct Analysis {
    pub(crate) shared: Arc<Shared>,
    pub(crate) space: Space,
    model: Py<Model>,
    preferences: Py<Preferences>,
    settings: Settings,
}

/// The names of the options of an analysis.
#[derive(Clone, Copy)]
struct Settings {
    engine: &'static str,
    scope: meliora::Scope,
    safety: &'static str,
}

/// Runs an analysis of an exploration.
///
/// # Errors
/// The preferences are invalid; a limit is reached, with the results so far.
pub(crate) fn prefer(
    py: Python<'_>,
    explored: &Exploration,
    preferences: Py<Preferences>,
    options: Options,
    call: &Call,
) -> PyResult<Analysis> {
    let (inner, source) = (explored.inner.clone(), Arc::clone(&preferences.get().source));
    let worker = Arc::clone(&explored.space.worker);
    let work = move |teller: &Teller<'_>| {
        teller.turn_to("preferences", String::new());
        let planning = inner.prefer(&source, options)?;
        Ok(Shared { known: Mutex::default(), planning: Mutex::new(planning) })
    };
    let shared = Arc::new(worker.run(py, call, work).map_err(|failure| failure.raise(py))?);
    let (_, space) = exploration::of_planning(py, &lock(&shared.planning), &explored.space);
    let settings = Settings {
        engine: explored.inner.engine().storage().name(),
        scope: Engine::settings(explored.inner.engine()).scope,
        safety: options.safety.name(),
    };
    let model = explored.model.clone_ref(py);
    let analysis = Analysis { shared, space, model, preferences, settings };
    match analysis.advance(py, call) {
        Ok(()) => Ok(analysis),
        Err(failure) => Err(analysis.failed(py, failure)),
    }
}

impl Analysis {
    pub(crate) fn check(
        model: &Bound<'_, Model>,
        preferences: Py<Preferences>,
        asked: &Asked<'_, '_>,
        options: Options,
        call: &Call,
    ) -> PyResult<Self> {
        let explored = Exploration::explore(model, asked, call)?;
        prefer(model.py(), &explored, preferences, options, call)
    }

    fn advance(&self, py: Python<'_>, call: &Call) -> std::result::Result<(), Failure> {
        let shared = Arc::clone(&self.shared);
        self.space.worker.run(py, call, move |teller| shared.run(teller))
    }

    /// Returns the exception of an incomplete analysis.
    fn failed(self, py: Python<'_>, failure: Failure) -> PyErr {
        failure.raise_with(py, |_| {
            let known = self.plain(py, &self.report_known(py)?)?;
            Ok((Py::new(py, self)?.into_any(), known))
        })
    }

    fn copy(&self, py: Python<'_>) -> Self {
        Analysis {
            shared: Arc::clone(&self.shared),
            space: self.space.clone(),
            model: self.model.clone_ref(py),
            preferences: self.preferences.clone_ref(py),
            settings: self.settings,
        }
    }

    /// Runs a short query on the planning, on the calling thread.
    fn look<T>(&self, py: Python<'_>, at: impl FnOnce(&Planning) -> Result<T>) -> PyResult<T> {
        self.space.worker.quick(py, || at(&lock(&self.shared.planning)))
    }

    /// Runs a query on the planning that may take long.
    fn ask<T: Send + 'static>(
        &self,
        py: Python<'_>,
        what: impl FnOnce(&Planning) -> Result<T> + Send + 'static,
    ) -> PyResult<T> {
        let shared = Arc::clone(&self.shared);
        self.space.worker.long(py, move || what(&lock(&shared.planning)))
    }

    /// Returns a report of the results so far. Does not lock the planning, which may be in use.
    fn report_known(&self, py: Python<'_>) -> PyResult<CheckReport> {
        let Settings { engine, scope, safety } = self.settings;
        let (model, preferences) = (self.model.get(), self.preferences.get());
        let path = model.inner.program().source.name.as_str();
        let header = Header { scope: Some(scope), ..Header::of_model(path) }.with_engine(engine);
        let mut report = CheckReport::new(header.with_preferences(&preferences.source.name, safety));
        let mut program = meliora::model::Program::clone(model.inner.program());
        let source: &Arc<SourceFile> = &preferences.source;
        let read = meliora::lang::load_preferences(source, &mut program);
        let read = read.map_err(|error| Failure::of(error).raise(py))?;
        report.header.read_both(model.inner.program(), &read);
        report.result = lock(&self.shared.known).clone();
        report.complete = false;
        Ok(report)
    }

    /// Converts a report to Python dictionaries and lists.
    fn plain(&self, py: Python<'_>, report: &CheckReport) -> PyResult<Py<PyAny>> {
        let text = serde_json::to_string(report)
            .map_err(|e| pyo3::exceptions::PyRuntimeError::new_err(e.to_string()))?;
        Ok(py.import("json")?.call_method1("loads", (text,))?.unbind())
    }

    fn levels(&self, kind: Kind) -> Levels {
        Levels { kind, shared: Arc::clone(&self.shared), space: self.space.clone() }
    }

    fn draw(&self, py: Python<'_>, drawing: Drawing, grid: Option<String>) -> PyResult<String> {
        self.ask(py, move |planning| planning.draw(drawing, grid.as_deref()))
    }
}

#[pymethods]
impl Analysis {
    /// The model.
    #[getter]
    fn model(&self, py: Python<'_>) -> Py<Model> {
        self.model.clone_ref(py)
    }

    /// The preferences.
    #[getter]
    fn preferences(&self, py: Python<'_>) -> Py<Preferences> {
        self.preferences.clone_ref(py)
    }

    /// `"symbolic"` or `"explicit"`.
    #[getter]
    fn engine(&self) -> &'static str {
        self.settings.engine
    }

    /// `"reachable"` or `"all"`.
    #[getter]
    fn scope(&self) -> &'static str {
        self.settings.scope.name()
    }

    /// `"action"`, `"transition"` or `"prefix"`.
    #[getter]
    fn safety(&self) -> &'static str {
        self.settings.safety
    }

    /// The exploration that is analysed. With `history = play` its states have the variables of the
    /// monitors too.
    #[getter]
    fn exploration(&self, py: Python<'_>) -> PyResult<Exploration> {
        let inner = self.look(py, |planning| Ok(planning.exploration()))?;
        Ok(Exploration::of(inner, self.space.clone(), self.model.clone_ref(py)))
    }

    /// True if all results are known: no limit ended the work.
    #[getter]
    fn complete(&self, py: Python<'_>) -> PyResult<bool> {
        self.look(py, |p| Ok(Phase::ALL.iter().all(|&phase| p.analysis().is_done(phase))))
    }

    /// Continues after a limit; does nothing if the analysis is complete.
    #[pyo3(signature = (*, timeout=None, progress=None))]
    fn resume(&self, py: Python<'_>, timeout: Option<f64>, progress: Option<Py<PyAny>>) -> PyResult<()> {
        let call = Call::new(timeout, progress)?;
        self.advance(py, &call).map_err(|failure| self.copy(py).failed(py, failure))
    }

    /// The numbers of `states`, `choices`, `transitions`, `deadlocks` and `initial` states. With
    /// `history = play`, `model_states` is the number of states without monitors. None if a limit
    /// ended the work before.
    #[getter]
    fn counts<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        let counts = lock(&self.shared.known).counts.clone();
        counts.map(|counts| counts_dict(py, &counts)).transpose()
    }

    /// The sizes of the improvement MDP: `states`, `transitions`, and the number of `dropped`
    /// transitions of the model. None with `safety="prefix"`, which has no such MDP, and if a limit
    /// ended the work before.
    #[getter]
    fn improvement<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        let Some(sizes) = lock(&self.shared.known).improvement.clone() else { return Ok(None) };
        let dict = PyDict::new(py);
        dict.set_item("states", &sizes.states)?;
        dict.set_item("transitions", &sizes.transitions)?;
        dict.set_item("dropped", &sizes.dropped)?;
        Ok(Some(dict))
    }

    /// The resources used so far: `peak_nodes`, the largest number of live diagram nodes; `bytes`
    /// of the engine's own tables; and `peak_rss_bytes`, the largest size of this process.
    #[getter]
    fn usage<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let used = self.look(py, |planning| Ok(Engine::usage(planning.engine())))?;
        let dict = PyDict::new(py);
        dict.set_item("peak_nodes", used.peak_nodes)?;
        dict.set_item("bytes", used.bytes)?;
        dict.set_item("peak_rss_bytes", size::peak_rss())?;
        Ok(dict)
    }

    /// The targets of the objectives by name, as far as they are known. The target of a temporal
    /// objective is the set of states from which its condition can be satisfied from then on,
    /// almost surely.
    #[getter]
    fn target<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.objective_regions(py, "target")
    }

    /// The almost-sure regions by objective: some strategy reaches the target with probability one.
    #[getter]
    fn almost_sure<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.objective_regions(py, "almost-sure")
    }

    /// The positive regions by objective: some strategy reaches the target with positive
    /// probability.
    #[getter]
    fn positive<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.objective_regions(py, "positive")
    }

    /// The states of each class. The keys are the most preferred objectives, as tuples of names in
    /// the order of declaration; () is the class of the states without an almost-sure objective.
    /// Empty if a limit ended the work before.
    #[getter]
    fn classes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let found = self.look(py, |planning| {
            let class = |class: &meliora::planning::Class<_>| {
                let names = planning.preferences().names(&class.most_preferred);
                let name = meliora::advanced::names::class(&meliora::advanced::names::members(&names));
                let states = planning.region(&name).unwrap_or_else(|| planning.exploration().deadlocks());
                (names.into_iter().map(str::to_owned).collect::<Vec<_>>(), states)
            };
            Ok(planning.analysis().classes().into_iter().flat_map(|c| &c.list).map(class).collect::<Vec<_>>())
        })?;
        let all = PyDict::new(py);
        for (names, states) in found {
            all.set_item(PyTuple::new(py, names)?, Py::new(py, self.space.region(states))?)?;
        }
        Ok(all)
    }

    /// Returns the most preferred objectives of a state, in the order of declaration.
    fn most_preferred<'py>(
        &self,
        py: Python<'py>,
        state: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyTuple>> {
        let state = self.space.names.state(state)?;
        let names = self.look(py, |planning| {
            Ok(planning.most_preferred(&state)?.into_iter().map(str::to_owned).collect::<Vec<_>>())
        })?;
        PyTuple::new(py, names)
    }

    /// The names of all known regions: `target:A`, `almost-sure:A`, `class:A+B`, `sasi:1`, …, as in
    /// dumps.
    #[getter]
    fn region_names(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        self.look(py, |planning| Ok(planning.regions().into_iter().map(|(name, _)| name).collect()))
    }

    /// Returns the region with this name.
    ///
    /// Raises:
    ///     UsageError: The name is unknown, or the region is not computed yet.
    fn region(&self, py: Python<'_>, name: &str) -> PyResult<Region> {
        let found = self.look(py, |planning| Ok(planning.region(name)))?;
        let states = found.ok_or_else(|| usage(format!("no region has the name `{name}`")))?;
        Ok(self.space.region(states))
    }

    /// The levels of almost-sure improvement.
    #[getter]
    fn sasi(&self) -> Levels {
        self.levels(Kind::Sasi)
    }

    /// The levels of positive improvement.
    #[getter]
    fn spi(&self) -> Levels {
        self.levels(Kind::Spi)
    }

    /// Returns the strategies of one kind, "sasi" or "spi".
    ///
    /// Raises:
    ///     UsageError: A limit ended the work before the levels of this kind were computed.
    fn strategy(&self, py: Python<'_>, kind: &str) -> PyResult<Strategy> {
        Strategy::new(py, &self.shared, &self.space, options::kind(kind)?)
    }

    /// Returns the report of `meliora check --json` as a dictionary; its counts are decimal
    /// strings.
    fn to_dict(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        let mut report = self.ask(py, Planning::report)?;
        report.complete = self.complete(py)?;
        self.plain(py, &report)
    }

    /// Returns all tables as text.
    fn to_text(&self, py: Python<'_>) -> PyResult<String> {
        let report = self.ask(py, Planning::report)?;
        Ok(report.text(Style { color: false, width: None }))
    }

    /// Returns an HTML page with interactive maps that loads nothing from elsewhere.
    ///
    /// Args:
    ///     grid: The integer variables that span the maps: (row, column), or (column,). None for
    ///         those with names that suggest rows and columns. Maps need the symbolic engine.
    #[pyo3(signature = (grid=None))]
    fn to_html(&self, py: Python<'_>, grid: Option<Vec<String>>) -> PyResult<String> {
        let grid = self.grid(grid)?;
        self.draw(py, Drawing::Html, grid)
    }

    /// Returns a picture as SVG: "hasse" is the preference order; "sasi", "spi" and "classes" are
    /// maps, which need the symbolic engine. `grid` as in `to_html`.
    #[pyo3(signature = (picture="hasse", grid=None))]
    fn to_svg(&self, py: Python<'_>, picture: &str, grid: Option<Vec<String>>) -> PyResult<String> {
        let picture = options::named("picture", picture, Picture::ALL, Picture::name)?;
        let grid = self.grid(grid)?;
        self.draw(py, Drawing::Svg(picture), grid)
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let known = lock(&self.shared.known).clone();
        let list = |levels: &[meliora::engine::Count]| {
            levels.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
        };
        let state = if self.complete(py)? { "" } else { " (unfinished)" };
        let (sasi, spi) = (list(&known.sasi.levels), list(&known.spi.levels));
        Ok(format!("<Analysis{state}: SASI [{sasi}], SPI [{spi}]>"))
    }

    fn _repr_html_(slf: &Bound<'_, Self>) -> PyResult<String> {
        display::html(slf.as_any(), "analysis")
    }

    fn __reduce__(&self) -> PyResult<Py<PyAny>> {
        let instead = "pickle its `model` and `preferences` and check again, or pickle `to_dict()`";
        Err(unpicklable("an Analysis", instead))
    }
}

impl Analysis {
    fn objective_regions<'py>(&self, py: Python<'py>, what: &str) -> PyResult<Bound<'py, PyDict>> {
        self.look(py, |planning| {
            Ok(region::by_name(py, &self.space, planning, |name| format!("{what}:{name}")))
        })?
    }

    /// Returns `r,c` for the names of variables.
    fn grid(&self, names: Option<Vec<String>>) -> PyResult<Option<String>> {
        let Some(names) = names else { return Ok(None) };
        match names.as_slice() {
            [column] => self.space.view(None, column, None)?,
            [row, column] => self.space.view(Some(row), column, None)?,
            _ => return Err(usage("grid: one or two names of variables, (row, column)")),
        };
        Ok(Some(names.join(",")))
    }
}
