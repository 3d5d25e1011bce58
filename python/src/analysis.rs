//! Analyses under preferences.

use std::sync::Arc;

use meliora::advanced::names::{RegionName, members};
use meliora::engine::Engine;
use meliora::model::Program;
use meliora::output::page::Picture;
use meliora::output::{CheckReport, Header, Report, Style};
use meliora::planning::{Class, Phase};
use meliora::supervise::memory;
use meliora::{Choose, Drawing, Kind, Safety, Scope, Storage, Wanted};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use serde_json::to_string;

use crate::errors::{Failure, unpicklable, usage};
use crate::handle::Handle;
use crate::levels::Levels;
use crate::preferences::Preferences;
use crate::region::Region;
use crate::strategy::Strategy;
use crate::values::{counts_dict, plain};
use crate::worker::Call;
use crate::{display, options};

/// The result of `Model.check`: the states from which improvements are possible or sure, and how
/// many.
///
/// `sasi` and `spi` are the levels; `target`, `almost_sure` and `positive` are the regions of each
/// objective. `classes` are the states with the same most preferred objectives, and `strategy`
/// returns the strategies. Several threads may use an analysis: their calls take turns.
#[pyclass(frozen, module = "meliora")]
pub(crate) struct Analysis {
    pub(crate) handle: Handle,
    pub(crate) origin: Arc<Origin>,
}

/// The objects and options of an analysis.
pub(crate) struct Origin {
    pub(crate) model: Py<PyAny>,
    /// The program of the model, without monitors.
    pub(crate) program: Arc<Program>,
    pub(crate) exploration: Py<PyAny>,
    pub(crate) preferences: Py<Preferences>,
    pub(crate) storage: Storage,
    pub(crate) scope: Scope,
    pub(crate) safety: Safety,
}

impl Analysis {
    /// Runs an analysis.
    ///
    /// # Errors
    /// A limit is reached, with the results so far.
    pub(crate) fn run(py: Python<'_>, handle: Handle, origin: Arc<Origin>, call: &Call) -> PyResult<Self> {
        let end = handle.run(py, call);
        Analysis::ended(py, handle, origin, end.err())
    }

    /// Returns an analysis that has ended.
    ///
    /// # Errors
    /// The failure that has ended it, with the results so far.
    pub(crate) fn ended(
        py: Python<'_>,
        handle: Handle,
        origin: Arc<Origin>,
        failure: Option<Failure>,
    ) -> PyResult<Self> {
        let analysis = Analysis { handle, origin };
        match failure {
            None => Ok(analysis),
            Some(failure) => Err(analysis.failed(py, failure)),
        }
    }

    /// Returns the exception of an incomplete analysis.
    fn failed(self, py: Python<'_>, failure: Failure) -> PyErr {
        failure.raise_with(py, |_| {
            let known = plain(py, to_string(&self.report_known()))?;
            Ok((Py::new(py, self)?.into_any(), known))
        })
    }

    /// Returns a report of the results so far. Does not wait for the analysis, which may be running.
    fn report_known(&self) -> CheckReport {
        let Origin { program, storage, scope, safety, .. } = &*self.origin;
        let Preferences { source, outline, .. } = self.origin.preferences.get();
        let header = Header::of_engine(program, *storage, *scope).with_preferences(&source.name, *safety);
        let mut report = CheckReport::new(header);
        report.read(program, outline.empty, outline.history);
        report.result = self.handle.known();
        report.complete = false;
        report
    }

    pub(crate) fn report(&self, py: Python<'_>) -> PyResult<CheckReport> {
        let source = Arc::clone(&self.origin.preferences.get().source);
        self.handle.long(py, move |analysis| analysis.report(&source.name))
    }

    fn levels(&self, kind: Kind) -> Levels {
        Levels { kind, handle: self.handle.clone() }
    }

    fn draw(&self, py: Python<'_>, call: &Call, drawing: Drawing, grid: Option<String>) -> PyResult<String> {
        let source = Arc::clone(&self.origin.preferences.get().source);
        self.handle
            .call(py, call, "picture", move |analysis| analysis.draw(&source.name, drawing, grid.as_deref()))
    }
}

#[pymethods]
impl Analysis {
    /// The model.
    #[getter]
    fn model(&self, py: Python<'_>) -> Py<PyAny> {
        self.origin.model.clone_ref(py)
    }

    /// The preferences.
    #[getter]
    fn preferences(&self, py: Python<'_>) -> Py<Preferences> {
        self.origin.preferences.clone_ref(py)
    }

    /// `"symbolic"` or `"explicit"`.
    #[getter]
    fn engine(&self) -> &'static str {
        self.origin.storage.name()
    }

    /// `"reachable"` or `"all"`.
    #[getter]
    fn scope(&self) -> &'static str {
        self.origin.scope.name()
    }

    /// `"action"`, `"transition"` or `"prefix"`.
    #[getter]
    fn safety(&self) -> &'static str {
        self.origin.safety.name()
    }

    /// The exploration that is analysed. With `history = play` its states have the variables of the
    /// monitors too.
    #[getter]
    fn exploration(&self, py: Python<'_>) -> Py<PyAny> {
        self.origin.exploration.clone_ref(py)
    }

    /// True if all results are known: no limit ended the work.
    #[getter]
    fn complete(&self, py: Python<'_>) -> PyResult<bool> {
        self.handle.quick(py, |analysis| Ok(Phase::ALL.iter().all(|&phase| analysis.is_done(phase))))
    }

    /// Continues after a limit; does nothing if the analysis is complete.
    #[pyo3(signature = (*, timeout=None, progress=None))]
    fn resume(
        &self,
        py: Python<'_>,
        timeout: Option<&Bound<'_, PyAny>>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<()> {
        let (handle, origin) = (self.handle.clone(), Arc::clone(&self.origin));
        Analysis::run(py, handle, origin, &Call::new(timeout, progress)?).map(drop)
    }

    /// The numbers of `states`, `choices`, `transitions`, `deadlocks` and `initial` states. With
    /// `history = play`, `model_states` is the number of states without monitors; with requirements,
    /// `unsafe` is the number of states from which they cannot be kept. None if a limit ended the
    /// work before.
    #[getter]
    fn counts<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        let counts = self.handle.known().counts;
        counts.map(|counts| counts_dict(py, &counts)).transpose()
    }

    /// The sizes of the improvement MDP: `states`, `transitions`, and the number of `dropped`
    /// transitions of the model. None with `safety="prefix"`, which has no such MDP, and if a limit
    /// ended the work before.
    #[getter]
    fn improvement<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        let Some(sizes) = self.handle.known().improvement else { return Ok(None) };
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
        let used = self.handle.quick(py, |analysis| Ok(analysis.engine().usage()))?;
        let dict = PyDict::new(py);
        dict.set_item("peak_nodes", used.peak_nodes)?;
        dict.set_item("bytes", used.bytes)?;
        dict.set_item("peak_rss_bytes", memory::peak_rss())?;
        Ok(dict)
    }

    /// The targets of the objectives by name, as far as they are known. The target of a temporal
    /// objective is the set of states from which its condition can be satisfied from then on,
    /// almost surely.
    #[getter]
    fn target<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.handle.objective_regions(py, "target")
    }

    /// The almost-sure regions by objective: some strategy reaches the target with probability one.
    #[getter]
    fn almost_sure<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.handle.objective_regions(py, "almost-sure")
    }

    /// The positive regions by objective: some strategy reaches the target with positive
    /// probability.
    #[getter]
    fn positive<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.handle.objective_regions(py, "positive")
    }

    /// The states of each class. The keys are the most preferred objectives, as tuples of names in
    /// the order of declaration; () is the class of the states without an almost-sure objective.
    /// Empty if a limit ended the work before.
    #[getter]
    fn classes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let found = self.handle.quick(py, |analysis| {
            let class = |class: &Class<_>| {
                let objectives = analysis.preferences().names(&class.most_preferred);
                let name = RegionName::Class(members(&objectives));
                let states = analysis.region(name).unwrap_or_else(|| analysis.exploration().deadlocks());
                (objectives.into_iter().map(str::to_owned).collect::<Vec<_>>(), states)
            };
            Ok(analysis.classes().into_iter().flat_map(|c| &c.list).map(class).collect::<Vec<_>>())
        })?;
        let all = PyDict::new(py);
        for (objectives, states) in found {
            all.set_item(PyTuple::new(py, objectives)?, Py::new(py, self.handle.space.region(states))?)?;
        }
        Ok(all)
    }

    /// Computes which most preferred objectives of each class one strategy achieves together, in the
    /// same path, almost surely. The keys are those of `classes`; the values are dictionaries from
    /// tuples of at least two objectives to the states of the class from which this is possible,
    /// larger sets first.
    ///
    /// Args:
    ///     timeout, progress: As in `Model.explore`.
    ///
    /// Raises:
    ///     UsageError: A class has more than 10 most preferred objectives, or a limit ended the work
    ///         before the classes were known.
    #[pyo3(signature = (*, timeout=None, progress=None))]
    fn jointly<'py>(
        &self,
        py: Python<'py>,
        timeout: Option<&Bound<'_, PyAny>>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let call = Call::new(timeout, progress)?;
        let all = PyDict::new(py);
        for (objectives, sets) in self.handle.call(py, &call, "jointly", meliora::Analysis::jointly)? {
            let of_class = PyDict::new(py);
            for (set, states) in sets {
                of_class.set_item(PyTuple::new(py, set)?, Py::new(py, self.handle.space.region(states))?)?;
            }
            all.set_item(PyTuple::new(py, objectives)?, of_class)?;
        }
        Ok(all)
    }

    /// Returns the most preferred objectives of a state, in the order of declaration.
    fn most_preferred<'py>(
        &self,
        py: Python<'py>,
        state: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyTuple>> {
        let state = self.handle.space.names.state(state)?;
        let names = self.handle.quick(py, |analysis| {
            Ok(analysis.most_preferred(&state)?.into_iter().map(str::to_owned).collect::<Vec<_>>())
        })?;
        PyTuple::new(py, names)
    }

    /// The names of all known regions: `target:A`, `almost-sure:A`, `class:A+B`, `sasi:1`, …, as in
    /// dumps.
    #[getter]
    fn region_names(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        self.handle.quick(py, |analysis| Ok(analysis.region_names()))
    }

    /// Returns the region with this name.
    ///
    /// Raises:
    ///     UsageError: The name is unknown, or the region is not computed yet.
    fn region(&self, py: Python<'_>, name: &str) -> PyResult<Region> {
        let found = self.handle.quick(py, |analysis| Ok(analysis.region(name)))?;
        let states = found.ok_or_else(|| usage(format!("no region has the name `{name}`")))?;
        Ok(self.handle.space.region(states))
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

    /// Computes how likely improvements are, how soon they come and at what cost; returns the list
    /// `states` of `meliora values --json`, with one dictionary per state. An unsafe state has `unsafe`
    /// and no numbers.
    ///
    /// Args:
    ///     states: States of the scope; None for the initial states.
    ///     levels: Greatest number of improvements; None for the levels found, at most 10.
    ///     reward: Reward structure that is the cost of a step; "steps": each step costs 1.
    ///     within: Compute also the probabilities of success within 0, 1, …, `within` steps.
    ///     exact: Compute with fractions; for small models.
    ///     timeout, progress: As in `Model.explore`.
    ///
    /// Raises:
    ///     UsageError: A state is not in the scope, or the model has no such reward structure.
    ///     InputError: A reward is negative or has no value in some state of the scope.
    #[pyo3(signature = (states=None, *, levels=None, reward="steps", within=None, exact=false, timeout=None, progress=None))]
    #[expect(clippy::too_many_arguments, reason = "they have names in Python")]
    fn values(
        &self,
        py: Python<'_>,
        states: Option<Vec<Bound<'_, PyAny>>>,
        levels: Option<i128>,
        reward: &str,
        within: Option<i128>,
        exact: bool,
        timeout: Option<&Bound<'_, PyAny>>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Py<PyAny>> {
        let levels = options::counted("levels", levels)?;
        let within = options::counted("within", within)?;
        let (call, states) = (Call::new(timeout, progress)?, self.handle.states(py, states)?);
        let wanted = Wanted { levels, reward: Some(reward.to_owned()), exact, within };
        let work = move |analysis: &meliora::Analysis| analysis.state_values(&states, &wanted);
        let found = self.handle.call(py, &call, "values", work)?;
        plain(py, to_string(&found))
    }

    /// Returns a strategy.
    ///
    /// Args:
    ///     kind: "sasi" or "spi" improves; "plan" makes all guaranteed improvements and then achieves a
    ///         most preferred objective; "achieve" achieves one objective, or several together. None for
    ///         "spi" with `choose="likely"`, else "sasi".
    ///     objective: The objective that "achieve" achieves ("C,D": both in one path), and that "plan"
    ///         pursues where it is a most preferred one; None for the first of these.
    ///     choose: The permitted action that the strategy takes: "first" that makes progress; "likely"
    ///         attains the greatest probability of all possible improvements (SPI) or of the objective
    ///         ("achieve"); "cheap" the least expected cost until the last certain one (SASI).
    ///     states: The states where paths may start with `choose="likely"` or "cheap"; None for the
    ///         initial states.
    ///     levels, reward: As in `values`.
    ///     timeout, progress: As in `Model.explore`.
    ///
    /// Raises:
    ///     UsageError: A limit ended the work before the levels of this kind were computed; or the
    ///         options do not fit together.
    #[pyo3(signature = (kind=None, *, objective=None, choose="first", states=None, levels=None, reward="steps", timeout=None, progress=None))]
    #[expect(clippy::too_many_arguments, reason = "they have names in Python")]
    fn strategy(
        &self,
        py: Python<'_>,
        kind: Option<&str>,
        objective: Option<String>,
        choose: &str,
        states: Option<Vec<Bound<'_, PyAny>>>,
        levels: Option<i128>,
        reward: &str,
        timeout: Option<&Bound<'_, PyAny>>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Strategy> {
        let levels = options::counted("levels", levels)?;
        let call = Call::new(timeout, progress)?;
        let choose = options::named("choose", choose, Choose::ALL, Choose::name)?;
        let fits = choose.kind();
        let kind = match kind {
            Some(kind) => options::strategy_kind(kind)?,
            None => fits.unwrap_or(Kind::Sasi).into(),
        };
        if let Some(fits) = fits.filter(|_| !choose.fits(kind)) {
            let (choose, kind, fits) = (choose.name(), kind.name(), fits.name());
            return Err(usage(format!("choose={choose:?} is for kind={fits:?}, not {kind:?}")));
        }
        let wanted = Wanted { levels, reward: Some(reward.to_owned()), ..Wanted::default() };
        let states = if fits.is_some() { self.handle.states(py, states)? } else { Vec::new() };
        Strategy::new((py, &call), &self.handle, (kind, objective), choose, states, wanted)
    }

    /// Returns the report of `meliora check --json` as a dictionary; its counts are decimal
    /// strings.
    fn to_dict(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        let mut report = self.report(py)?;
        report.complete = self.complete(py)?;
        plain(py, to_string(&report))
    }

    /// Returns all tables as text.
    fn to_text(&self, py: Python<'_>) -> PyResult<String> {
        let report = self.report(py)?;
        Ok(report.text(Style { color: false, width: None }))
    }

    /// Returns an HTML page with interactive maps that loads nothing from elsewhere.
    ///
    /// Args:
    ///     grid: The variables that span the maps: (row, column), or (column,). None for
    ///         those with names that suggest rows and columns. Maps need the symbolic engine.
    ///     timeout, progress: As in `Model.explore`.
    #[pyo3(signature = (grid=None, *, timeout=None, progress=None))]
    fn to_html(
        &self,
        py: Python<'_>,
        grid: Option<Vec<String>>,
        timeout: Option<&Bound<'_, PyAny>>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<String> {
        let (call, grid) = (Call::new(timeout, progress)?, self.handle.space.grid(grid)?);
        self.draw(py, &call, Drawing::Html, grid)
    }

    /// Returns a picture as SVG: "hasse" is the preference order; "sasi", "spi" and "classes" are
    /// maps, which need the symbolic engine. `grid`, `timeout` and `progress` as in `to_html`.
    #[pyo3(signature = (picture="hasse", grid=None, *, timeout=None, progress=None))]
    fn to_svg(
        &self,
        py: Python<'_>,
        picture: &str,
        grid: Option<Vec<String>>,
        timeout: Option<&Bound<'_, PyAny>>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<String> {
        let picture = options::named("picture", picture, Picture::ALL, Picture::name)?;
        let (call, grid) = (Call::new(timeout, progress)?, self.handle.space.grid(grid)?);
        self.draw(py, &call, Drawing::Svg(picture), grid)
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let known = self.handle.known();
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
