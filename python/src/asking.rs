//! Questions to models.

use std::path::PathBuf;
use std::sync::Arc;

use meliora::engine::Selection;
use meliora::question::WantedStrategies;
use meliora::question::shield::Threshold;
use meliora::{Limit, Properties, PropertyFile, Settings, SourceFile};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};
use serde_json::to_string;

use crate::analysis::Analysis;
use crate::errors::{Failure, usage};
use crate::exploration::{Exploration, Reachability};
use crate::model::Model;
use crate::options::{self, ExploreOptions};
use crate::preferences::{self, Preferences};
use crate::region::Space;
use crate::shield::Shield;
use crate::worker::Call;
use crate::{files, sweep, values};

impl Model {
    /// Returns a space with a new worker, the settings, and whether several ways race.
    fn space(&self, asked: &ExploreOptions<'_, '_>) -> PyResult<(Space, Settings, bool)> {
        let (settings, is_any, worker) = asked.settings()?;
        Ok((Space { worker, names: Arc::clone(&self.names) }, settings, is_any))
    }
}

#[pymethods]
impl Model {
    /// Explores the states of the scope. `check` does this first; explore once for several queries.
    ///
    /// Args:
    ///     scope: The valuations that are states: "reachable" from the initial states, or "all".
    ///     engine: The storage of states: "symbolic" for decision diagrams, "explicit" for a list,
    ///         "auto" for the first of both to know all states; in `check` and `reach`, the answer.
    ///     memory: Bytes for the tables of the engine, or a text such as "2GiB"; None for half of
    ///         the machine's memory.
    ///     order: The order of the bits in diagrams: "auto", "declared", or names of variables or
    ///         bits from the root down.
    ///     timeout: Seconds, or a text such as "5s", after which the work ends with OutOfTime.
    ///     progress: Called with a Progress at intervals, from the calling thread; an exception
    ///         raised by it ends the work.
    ///
    /// Raises:
    ///     InputError: An expression has no value in some state; the error shows an example.
    ///     LimitError: A limit was reached.
    #[pyo3(signature = (*, scope="reachable", engine="symbolic", memory=None, order=None, timeout=None, progress=None))]
    fn explore(
        slf: &Bound<'_, Self>,
        scope: &str,
        engine: &str,
        memory: Option<&Bound<'_, PyAny>>,
        order: Option<&Bound<'_, PyAny>>,
        timeout: Option<&Bound<'_, PyAny>>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Exploration> {
        let (space, settings, is_any) = slf.get().space(&ExploreOptions { scope, engine, memory, order })?;
        let call = Call::new(timeout, progress)?;
        Exploration::explore((&slf.get().inner, slf.clone().into_any()), space, (settings, is_any), &call)
    }

    /// Computes the states from which improvements are possible or sure, and how many. Explores the
    /// model and computes winning regions, classes, the improvement MDP and the levels of SASI and
    /// SPI.
    ///
    /// Args:
    ///     preferences: A Preferences, or the path of a preference file.
    ///     safety: How to treat actions that may weaken: "action", "transition" (the paper's
    ///         definition to the letter) or "prefix".
    ///     max_level: The search for levels ends after this level.
    ///     scope, engine, memory, order, timeout, progress: As in `explore`.
    ///
    /// Raises:
    ///     InputError: The preferences are invalid; each problem has its place.
    ///     LimitError: A limit was reached; its `analysis` has the results so far.
    #[pyo3(signature = (preferences, *, scope="reachable", safety="prefix", engine="symbolic", max_level=None, memory=None, order=None, timeout=None, progress=None))]
    #[expect(clippy::too_many_arguments, reason = "they have names in Python")]
    fn check(
        slf: &Bound<'_, Self>,
        preferences: &Bound<'_, PyAny>,
        scope: &str,
        safety: &str,
        engine: &str,
        max_level: Option<i128>,
        memory: Option<&Bound<'_, PyAny>>,
        order: Option<&Bound<'_, PyAny>>,
        timeout: Option<&Bound<'_, PyAny>>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Analysis> {
        let py = slf.py();
        let (space, settings, is_any) = slf.get().space(&ExploreOptions { scope, engine, memory, order })?;
        let options = options::planning(safety, max_level)?;
        let call = Call::new(timeout, progress)?;
        let preferences: Py<Preferences> = preferences::given(py, preferences, slf.get().inner.program())?;
        let given = (&slf.get().inner, slf.clone().into_any());
        if is_any {
            return Exploration::analyse_by_any(given, &space, settings, (preferences, options), &call);
        }
        Exploration::explore(given, space, (settings, false), &call)?.analyse(py, preferences, options, &call)
    }

    /// Computes the four qualitative regions of a target: `explore` followed by
    /// `Exploration.reach`.
    ///
    /// Args:
    ///     target: A condition in the model's language, such as 'x = 3 & "goal"', a temporal formula,
    ///         or a property such as 'P>=1 [ G F x = 3 ]'.
    ///     stop_at_target: Do not explore the states behind those that decide the question. In the initial
    ///         states the answer is the same; the regions are those of the part explored. Only with the
    ///         scope "reachable".
    ///     scope, engine, memory, order, timeout, progress: As in `explore`.
    ///
    /// Raises:
    ///     InputError: The text is wrong; with `stop_at_target`, also if no state decides it, as for `G F`.
    #[pyo3(signature = (target, *, stop_at_target=false, scope="reachable", engine="symbolic", memory=None, order=None, timeout=None, progress=None))]
    #[expect(clippy::too_many_arguments, reason = "they have names in Python")]
    fn reach(
        slf: &Bound<'_, Self>,
        target: &str,
        stop_at_target: bool,
        scope: &str,
        engine: &str,
        memory: Option<&Bound<'_, PyAny>>,
        order: Option<&Bound<'_, PyAny>>,
        timeout: Option<&Bound<'_, PyAny>>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Reachability> {
        let (space, settings, is_any) = slf.get().space(&ExploreOptions { scope, engine, memory, order })?;
        let call = Call::new(timeout, progress)?;
        let question = (&slf.get().inner, target.to_owned());
        if stop_at_target {
            return Exploration::reach_stopping(slf.py(), question, &space, (settings, is_any), &call);
        }
        if is_any {
            return Exploration::reach_by_any(slf.py(), question, &space, settings, &call);
        }
        let given = (question.0, slf.clone().into_any());
        Exploration::explore(given, space, (settings, false), &call)?.reach_text(slf.py(), question.1, &call)
    }

    /// The names of the properties that the model names, for `ask`.
    #[getter]
    fn properties(&self) -> Vec<String> {
        self.inner.properties().map(str::to_owned).collect()
    }

    /// Answers properties in the initial states, as `meliora reach --property` does: conditions on states, whose
    /// operators ask for probabilities, rewards, several objectives at once, filters. Properties share their regions. The
    /// states are not explored where the answers need only some of them.
    ///
    /// Args:
    ///     properties: A property such as 'Pmax=? [ F "goal" ]', the name of one of the model's, or a list of these. None
    ///         for the goal of a planning problem, or for all that the model names.
    ///     file: A property file in PRISM's language, instead of `properties`.
    ///     constants: Values of the constants that the file leaves undefined, by name.
    ///     only: The name of the only property of the file that is asked for.
    ///     require: Safe formulas such as 'G x < 3' that every strategy must keep.
    ///     stop_at_target: Do not explore the states behind those that decide the question, one property. The answer is
    ///         the same.
    ///     precision: The largest width of the bounds of a number, relative to the number above 1.
    ///     policy: Also return, as `policy`, what `meliora reach --policy` writes: the strategy that attains the answer to
    ///         the only property, the strategies of `multi`, or for `Pmax>=1 [ F … ]` a list of rules. None if there are
    ///         none. `Policy` follows it.
    ///     opponent_policy: Also return, as `opponent_policy`, the strategy of the opponent of a game.
    ///     strong: Also return, as `plan`, whether a strong plan exists: every path reaches the target within a bound.
    ///     engine: "auto" (default): the first way to end has the answer.
    ///     scope, memory, order, timeout, progress: As in `explore`. Of several properties, each has a share of the time.
    ///
    /// Returns:
    ///     The answer as a dictionary, or a list of these. One of several that has no answer has a `reason`.
    ///
    /// Raises:
    ///     InputError: A text is wrong, or the only property cannot be answered.
    ///     LimitError: A limit was reached; its `known["properties"]` has the answers so far.
    #[pyo3(signature = (properties=None, *, file=None, constants=None, only=None, require=None, stop_at_target=false, precision=1e-6, policy=false, opponent_policy=false, strong=false, scope="reachable", engine="auto", memory=None, order=None, timeout=None, progress=None))]
    #[expect(clippy::too_many_arguments, reason = "they have names in Python")]
    fn ask(
        slf: &Bound<'_, Self>,
        properties: Option<&Bound<'_, PyAny>>,
        file: Option<PathBuf>,
        constants: Option<&Bound<'_, PyDict>>,
        only: Option<String>,
        require: Option<Vec<String>>,
        stop_at_target: bool,
        precision: f64,
        policy: bool,
        opponent_policy: bool,
        strong: bool,
        scope: &str,
        engine: &str,
        memory: Option<&Bound<'_, PyAny>>,
        order: Option<&Bound<'_, PyAny>>,
        timeout: Option<&Bound<'_, PyAny>>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Py<PyAny>> {
        let (py, model) = (slf.py(), slf.get());
        let given = Texts::of(&model.inner, properties, (py, file, constants, only))?;
        if !(precision > 0.0 && precision < 1.0) {
            return Err(usage(format!("precision={precision}: expected a number between 0 and 1")));
        }
        let (space, settings, is_any) = model.space(&ExploreOptions { scope, engine, memory, order })?;
        let engine = selection(&settings, is_any);
        let opponent = opponent_policy;
        let (require, strategies) =
            (require.unwrap_or_default(), WantedStrategies { strong, policy, opponent });
        let ask = meliora::Ask { require, stops_at_target: stop_at_target, precision, strategies, engine };
        let (call, inner, is_one) = (Call::new(timeout, progress)?, model.inner.clone(), given.is_one());
        let found = space.worker.phase(py, &call, "properties", move || given.ask(&inner, &ask, settings))?;
        let answers = values::plain(py, to_string(&found.answers.properties))?;
        if let Some(limit) = found.limit {
            return Err(ended(py, &space, limit, ("properties", answers)));
        }
        let one = answers.bind(py).get_item(0)?;
        if policy {
            let text = found.policy_json().map_err(|error| Failure::of(error).raise(py))?;
            one.set_item("policy", text.map(|text| values::plain(py, Ok(text))).transpose()?)?;
        }
        if opponent_policy {
            let text = found.opponent_json().map_err(|error| Failure::of(error).raise(py))?;
            one.set_item("opponent_policy", text.map(|text| values::plain(py, Ok(text))).transpose()?)?;
        }
        if let Some(plan) = found.answers.one.and_then(|one| one.plan) {
            one.set_item("plan", values::plain(py, to_string(&plan))?)?;
        }
        Ok(if is_one { one.unbind() } else { answers })
    }

    /// Computes how safe each action of each state is, and permits those that are safe enough, as `meliora shield` does.
    /// The safety of an action is the best probability of the formula after it, for `Pmin` 1 minus it. In a game it holds
    /// against every strategy of the opponent.
    ///
    /// Args:
    ///     property: `Pmin=? [ … ]` of a bad event or `Pmax=? [ … ]` of a good one, or a shield expression
    ///         `<name, PreSafety, lambda=0.9> Pmax=? [ G !"crash" ]`, which has a threshold of its own.
    ///     threshold: The least safety of a permitted action. Where no action reaches it, those with the best safety are
    ///         permitted.
    ///     relative: The threshold is a factor of the best safety of each state.
    ///     limit: The maximum number of states.
    ///     engine: "auto" (default): the first engine to know all states.
    ///     scope, memory, order, timeout, progress: As in `explore`.
    ///
    /// Raises:
    ///     InputError: The property is wrong or not supported.
    ///     LimitError: A limit was reached.
    #[pyo3(signature = (property, threshold=None, *, relative=false, limit=1_000_000, scope="reachable", engine="auto", memory=None, order=None, timeout=None, progress=None))]
    #[expect(clippy::too_many_arguments, reason = "they have names in Python")]
    fn shield(
        slf: &Bound<'_, Self>,
        property: &str,
        threshold: Option<f64>,
        relative: bool,
        limit: i128,
        scope: &str,
        engine: &str,
        memory: Option<&Bound<'_, PyAny>>,
        order: Option<&Bound<'_, PyAny>>,
        timeout: Option<&Bound<'_, PyAny>>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Shield> {
        let (space, settings, is_any) = slf.get().space(&ExploreOptions { scope, engine, memory, order })?;
        let (limit, engine) = (options::count("limit", limit)?, selection(&settings, is_any));
        let threshold = threshold.map(|x| Threshold::parse(&x.to_string(), relative)).transpose();
        let threshold = threshold.map_err(|wrong| usage(format!("threshold={wrong}")))?;
        let (call, inner, property) =
            (Call::new(timeout, progress)?, slf.get().inner.clone(), property.to_owned());
        let work = move || inner.shield(&property, threshold, limit, engine, settings);
        Shield::new(slf.py(), space.worker.phase(slf.py(), &call, "shield", work)?)
    }

    /// Answers the properties of an instance of a sweep.
    #[pyo3(signature = (properties, *, scope, engine, memory, timeout))]
    fn _answers(
        &self,
        py: Python<'_>,
        properties: Vec<String>,
        scope: &str,
        engine: &str,
        memory: Option<&Bound<'_, PyAny>>,
        timeout: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<sweep::Answers> {
        let (space, settings, is_any) = self.space(&ExploreOptions { scope, engine, memory, order: None })?;
        let ask = meliora::Ask { engine: selection(&settings, is_any), ..meliora::Ask::default() };
        let (call, inner) = (Call::new(timeout, None)?, self.inner.clone());
        let work = move || {
            let texts = Vec::from_iter(properties.iter().map(String::as_str));
            inner.ask(Properties::Each(&texts), &ask, settings)
        };
        let found = space.worker.phase(py, &call, "properties", work)?;
        let answers = sweep::Answers { answers: found.answers, usage: found.usage };
        match found.limit {
            Some(limit) => Err(ended(py, &space, limit, ("answers", Py::new(py, answers)?.into_any()))),
            None => Ok(answers),
        }
    }
}

/// Returns the selection of an engine.
fn selection(settings: &Settings, is_any: bool) -> Selection {
    let named = Selection { storage: settings.storage, reason: None, is_open: false };
    if is_any { Selection::open() } else { named }
}

/// Returns the exception for a limit, with the answers so far.
pub(crate) fn ended(
    py: Python<'_>,
    space: &Space,
    limit: Limit,
    (name, answers): (&str, Py<PyAny>),
) -> PyErr {
    let failure = Failure::of(limit.into()).at(space.worker.supervisor.position());
    failure.raise_with(py, |_| {
        let known = PyDict::new(py);
        known.set_item(name, answers)?;
        Ok((py.None(), known.into_any().unbind()))
    })
}

/// A property file, the values of its constants, and the name of its only property.
type GivenFile<'a, 'py> = (Python<'py>, Option<PathBuf>, Option<&'a Bound<'py, PyDict>>, Option<String>);

/// The properties of a call of `ask`.
enum Texts {
    One(String),
    Several(Vec<String>),
    File { source: Arc<SourceFile>, constants: Arc<SourceFile>, only: Option<String> },
    Named,
}

impl Texts {
    fn of(
        model: &meliora::Model,
        properties: Option<&Bound<'_, PyAny>>,
        (py, file, constants, only): GivenFile<'_, '_>,
    ) -> PyResult<Self> {
        match (properties, file) {
            (Some(_), Some(_)) => Err(usage("`properties` and `file` exclude each other")),
            (None, Some(file)) => {
                let constants = SourceFile::new("constants", values::constants_text(constants)?);
                Ok(Texts::File { source: files::open(py, &file)?, constants, only })
            }
            _ if only.is_some() => Err(usage("`only` names a property of a file")),
            _ if constants.is_some() => Err(usage("`constants` are those of a property file")),
            (Some(given), None) if given.is_instance_of::<PyString>() => Ok(Texts::One(given.extract()?)),
            (Some(given), None) => match given.extract::<Vec<String>>()? {
                texts if texts.is_empty() => Err(usage("`properties` is empty")),
                texts => Ok(Texts::Several(texts)),
            },
            (None, None) => match model.goal_property() {
                Some(goal) => Ok(Texts::One(goal.to_owned())),
                None if model.properties().next().is_some() => Ok(Texts::Named),
                None => {
                    Err(usage("a property is missing: the model has no goal that must hold, and names none"))
                }
            },
        }
    }

    fn is_one(&self) -> bool {
        matches!(self, Texts::One(_))
    }

    fn ask(
        &self,
        model: &meliora::Model,
        ask: &meliora::Ask,
        settings: Settings,
    ) -> meliora::Result<meliora::AskResult> {
        match self {
            Texts::One(text) => model.ask(Properties::Texts(&[text]), ask, settings),
            Texts::Several(texts) => {
                let texts = Vec::from_iter(texts.iter().map(String::as_str));
                model.ask(Properties::Texts(&texts), ask, settings)
            }
            Texts::File { source, constants, only } => {
                let file = PropertyFile { source, constants, only: only.as_deref() };
                model.ask(Properties::File(file), ask, settings)
            }
            Texts::Named => model.ask(Properties::Named, ask, settings),
        }
    }
}
