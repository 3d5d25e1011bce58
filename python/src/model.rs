//! Models.

use std::io::Read;
use std::path::PathBuf;
use std::sync::Arc;

use meliora::SourceFile;
use meliora::error::render;
use meliora::lang::{Document, Given};
use meliora::model::ModelKind;
use meliora::supervise::memory;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyList, PyTuple};

use crate::errors::{Failure, usage};
use crate::values::{self, Names};
use crate::variable::Variable;
use crate::worker::{Call, Worker};
use crate::{display, files};

/// The name and the text of a file.
type NamedText = (String, String);
/// Two files that may be missing.
type TwoFiles = (Option<NamedText>, Option<NamedText>);

/// A model in PRISM's language or in JANI, or a list of its states: read, checked and flat, but not
/// explored.
///
/// Models are immutable values: they can be pickled, and used by several threads.
#[pyclass(frozen, module = "meliora")]
pub(crate) struct Model {
    pub(crate) inner: meliora::Model,
    pub(crate) names: Arc<Names>,
    constants: String,
    bounds: String,
    /// The file that it was read from.
    document: Document,
    /// The players of `with_coalition`.
    coalition: Option<Vec<String>>,
}

impl Model {
    /// Reads the bytes of an archive or a text.
    fn from_bytes(py: Python<'_>, name: &str, bytes: &[u8], call: &Call) -> PyResult<Self> {
        let document = Document::read(name, bytes).map_err(|error| Failure::of(error).raise(py))?;
        Model::load(py, document, (String::new(), String::new()), call)
    }

    /// Reads a document on a worker thread.
    fn load(
        py: Python<'_>,
        document: Document,
        (constants, bounds): (String, String),
        call: &Call,
    ) -> PyResult<Self> {
        let given = Given {
            constants: SourceFile::new("constants", constants.as_str()),
            bounds: SourceFile::new("bounds", bounds.as_str()),
        };
        let worker = Worker::new(memory::default_memory());
        let supervisor = Arc::clone(&worker.supervisor);
        let read = document.clone();
        let work = move || meliora::Model::loaded(&read, &given, &*supervisor);
        let inner = worker.phase(py, call, "model", work)?;
        let names = Names::new(py, inner.program());
        Ok(Model { inner, names, constants, bounds, document, coalition: None })
    }

    /// Returns the game in which these players are ours.
    fn played_by(&self, py: Python<'_>, players: Vec<String>) -> PyResult<Self> {
        let inner = self.inner.with_coalition(&players).map_err(|error| Failure::of(error).raise(py))?;
        let names = Names::new(py, inner.program());
        let (constants, bounds) = (self.constants.clone(), self.bounds.clone());
        let (document, coalition) = (self.document.clone(), Some(players));
        Ok(Model { inner, names, constants, bounds, document, coalition })
    }

    fn name(&self) -> &str {
        &self.inner.program().source.name
    }
}

#[pymethods]
impl Model {
    /// Reads a model from a file. The content tells if it is in PRISM's language or in JANI, an archive
    /// (UMB), or a list of states: DRN, or PRISM's `.tra` with the `.sta` and `.lab` next to it.
    ///
    /// Args:
    ///     path: The file.
    ///     constants: Values of the undefined constants, by name; a `fractions.Fraction` stays exact.
    ///     bounds: (low, high) for integers of a JANI model without bounds, by name.
    ///     timeout: Seconds, or a text such as "5s", after which reading ends with OutOfTime.
    ///     progress: Called with a Progress at intervals.
    ///
    /// Raises:
    ///     InputError: The text is invalid; each problem has its place.
    ///     OSError: The file cannot be read.
    #[staticmethod]
    #[pyo3(signature = (path, *, constants=None, bounds=None, timeout=None, progress=None))]
    fn from_file(
        py: Python<'_>,
        path: PathBuf,
        constants: Option<&Bound<'_, PyDict>>,
        bounds: Option<&Bound<'_, PyDict>>,
        timeout: Option<&Bound<'_, PyAny>>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Self> {
        let given = (values::constants_text(constants)?, values::bounds_text(bounds)?);
        Model::load(py, files::document(py, &path)?, given, &Call::new(timeout, progress)?)
    }

    /// Reads a model from a string, as `from_file` does from a file. Messages call the model
    /// `name`.
    #[staticmethod]
    #[pyo3(signature = (text, *, constants=None, bounds=None, name="model", timeout=None, progress=None))]
    fn from_string(
        py: Python<'_>,
        text: String,
        constants: Option<&Bound<'_, PyDict>>,
        bounds: Option<&Bound<'_, PyDict>>,
        name: &str,
        timeout: Option<&Bound<'_, PyAny>>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Self> {
        let given = (values::constants_text(constants)?, values::bounds_text(bounds)?);
        Model::load(py, Document::new(SourceFile::new(name, text)), given, &Call::new(timeout, progress)?)
    }

    /// Reads a planning problem in PDDL: two files, in any order. See `ask` for whether a plan exists.
    ///
    /// Args:
    ///     domain, problem: The files.
    ///     timeout, progress: As in `from_file`.
    ///
    /// Raises:
    ///     InputError: A text is invalid, or has something that is not supported.
    ///     OSError: A file cannot be read.
    #[staticmethod]
    #[pyo3(signature = (domain, problem, *, timeout=None, progress=None))]
    fn from_pddl(
        py: Python<'_>,
        domain: PathBuf,
        problem: PathBuf,
        timeout: Option<&Bound<'_, PyAny>>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Self> {
        let call = Call::new(timeout, progress)?;
        let document = Document::of_parts([files::open(py, &domain)?, files::open(py, &problem)?])
            .map_err(|error| Failure::of(error).raise(py))?;
        Model::load(py, document, Default::default(), &call)
    }

    /// Reads a model from an archive in the unified Markov binary format (UMB).
    ///
    /// Args:
    ///     source: The path of the archive, or its bytes.
    ///     timeout, progress: As in `from_file`.
    ///
    /// Raises:
    ///     InputError: The archive has an invalid model, or something that is not supported.
    ///     OSError: The file cannot be read, or is not an archive.
    #[staticmethod]
    #[pyo3(signature = (source, *, timeout=None, progress=None))]
    fn from_umb(
        py: Python<'_>,
        source: &Bound<'_, PyAny>,
        timeout: Option<&Bound<'_, PyAny>>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Self> {
        let call = Call::new(timeout, progress)?;
        if let Ok(bytes) = source.cast::<PyBytes>() {
            return Model::from_bytes(py, "model", bytes.as_bytes(), &call);
        }
        let path: PathBuf = source.extract()?;
        let (mut file, mut bytes) = (files::opened(py, &path)?, Vec::new());
        file.read_to_end(&mut bytes)?;
        Model::from_bytes(py, &path.display().to_string(), &bytes, &call)
    }

    /// Reads a model from a table of transitions. The only variable is `state`: the name of the
    /// state, or its number if states have no names.
    ///
    /// Args:
    ///     transitions: Gymnasium's `env.unwrapped.P`, a dictionary `P[state][action]` of lists of
    ///         tuples (probability, next state, reward, terminated), of dictionaries from next
    ///         states to probabilities, or of a single next state; or a NumPy array of the shape
    ///         (states, actions, states); or one matrix (states, states) per action, of NumPy or
    ///         scipy, as a list, or as a dictionary by the name of the action. Nested lists may
    ///         stand for arrays. The keys of a dictionary of states name them, unless they are the
    ///         numbers from 0 on. An array of the shape (actions, states, states) is read as such if the
    ///         numbers of states and actions differ. An action whose row has only zeros is not available in that
    ///         state. A state that a terminated transition enters is absorbing: each of its
    ///         actions stays there; the label "done" marks these states, unless `labels` has it.
    ///         The rewards of tuples are not used.
    ///     rewards: Reward structures: for each name an array (states) or (states, actions), or a
    ///         dictionary by states, where others earn 0.
    ///     labels: For each name the states that have it: names or numbers, each once, or a Boolean (or
    ///         0.0 and 1.0) for each state. Preferences use them as `F "goal"`.
    ///     start: The initial states: a state, states, a Boolean for each state, or a distribution
    ///         such as `env.unwrapped.initial_state_distrib`; None for all states.
    ///     actions: The names of the actions; None for `a0`, `a1`, …, or the keys if they are names.
    ///     states: The names of the states in their order; None for the keys of a dictionary, unless
    ///         these are the numbers from 0 on.
    ///     timeout, progress: As in `from_file`.
    ///
    /// Raises:
    ///     UsageError: A shape, a sum of probabilities, a state or a name is wrong.
    #[staticmethod]
    #[pyo3(signature = (transitions, rewards=None, labels=None, start=None, *, actions=None, states=None, timeout=None, progress=None))]
    #[expect(clippy::too_many_arguments, reason = "they have names in Python")]
    fn from_transitions(
        py: Python<'_>,
        transitions: &Bound<'_, PyAny>,
        rewards: Option<&Bound<'_, PyAny>>,
        labels: Option<&Bound<'_, PyAny>>,
        start: Option<&Bound<'_, PyAny>>,
        actions: Option<&Bound<'_, PyAny>>,
        states: Option<&Bound<'_, PyAny>>,
        timeout: Option<&Bound<'_, PyAny>>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Self> {
        let (given, call) =
            ((transitions, rewards, labels, start, actions, states), Call::new(timeout, progress)?);
        let text: String = py.import("meliora._tables")?.call_method1("drn", given)?.extract()?;
        Model::load(py, Document::new(SourceFile::new("transitions", text)), Default::default(), &call)
    }

    #[staticmethod]
    #[pyo3(signature = (name, text, constants, bounds, archive=None, coalition=None, beside=(None, None), rewards=Vec::new()))]
    #[expect(clippy::too_many_arguments, reason = "they are those of `__reduce__`")]
    fn _restore(
        py: Python<'_>,
        name: &str,
        text: String,
        constants: String,
        bounds: String,
        archive: Option<Vec<u8>>,
        coalition: Option<Vec<String>>,
        beside: TwoFiles,
        rewards: Vec<TwoFiles>,
    ) -> PyResult<Self> {
        let file = |(name, text): NamedText| SourceFile::new(name, text);
        let files = |both: TwoFiles| [both.0.map(file), both.1.map(file)];
        let model = match archive {
            Some(bytes) => Model::from_bytes(py, name, &bytes, &Call::plain())?,
            None => {
                let document = Document::new(SourceFile::new(name, text)).with_beside(files(beside));
                let document = document.with_rewards(rewards.into_iter().map(files).collect());
                Model::load(py, document, (constants, bounds), &Call::plain())?
            }
        };
        match coalition {
            Some(players) => model.played_by(py, players),
            None => Ok(model),
        }
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let restore = py.get_type::<Model>().getattr("_restore")?;
        let source = &self.inner.program().source;
        let archive = self.document.archive().map(|bytes| PyBytes::new(py, bytes));
        let (constants, bounds, coalition) = (&self.constants, &self.bounds, &self.coalition);
        let named =
            |file: &Option<Arc<SourceFile>>| file.as_ref().map(|f| (f.name.clone(), f.original().to_owned()));
        let files = |both: &[Option<Arc<SourceFile>>; 2]| (named(&both[0]), named(&both[1]));
        let rewards: Vec<TwoFiles> = self.document.rewards().iter().map(files).collect();
        let beside = files(self.document.beside());
        let arguments =
            (&source.name, source.original(), constants, bounds, archive, coalition, beside, rewards);
        (restore, arguments).into_pyobject(py)
    }

    /// The name in messages: the path of the file.
    #[getter(name)]
    fn get_name(&self) -> &str {
        self.name()
    }

    /// The text.
    #[getter]
    fn text(&self) -> &str {
        self.inner.program().source.original()
    }

    /// `"mdp"`, `"dtmc"` or `"smg"`.
    #[getter]
    fn kind(&self) -> &'static str {
        match self.inner.kind() {
            ModelKind::Mdp => "mdp",
            ModelKind::Dtmc => "dtmc",
            ModelKind::Smg => "smg",
        }
    }

    /// The variables by name, in the order of declaration.
    #[getter]
    fn variables<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let all = PyDict::new(py);
        for v in &self.inner.program().variables {
            all.set_item(&v.name, Py::new(py, Variable::new(py, v)?)?)?;
        }
        Ok(all)
    }

    /// The players of a game, in the order of declaration; () for other models.
    #[getter]
    fn players<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(py, self.inner.players().iter().map(|player| &player.name))
    }

    /// The players that we are; all others are the opponent. Unless `with_coalition` named them, a
    /// preference file may name others.
    #[getter]
    fn coalition<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let ours: Vec<&String> =
            self.inner.players().iter().filter(|player| player.ours).map(|player| &player.name).collect();
        PyTuple::new(py, ours)
    }

    /// Returns the game in which we are these players, each given by its name or its number from 1 on; all
    /// others are the opponent. A preference file does not change this. Without it, we are the players
    /// that the preference file names, else the first player.
    ///
    /// Raises:
    ///     InputError: The model is not a game, or has no such player.
    #[pyo3(signature = (*players))]
    fn with_coalition(&self, py: Python<'_>, players: &Bound<'_, PyTuple>) -> PyResult<Self> {
        let name = |player: Bound<'_, PyAny>| match player.extract::<u32>() {
            Ok(number) => Ok(number.to_string()),
            Err(_) => player
                .extract::<String>()
                .map_err(|_| usage(format!("a player is given by its name or its number, not {player}"))),
        };
        self.played_by(py, players.iter().map(name).collect::<PyResult<_>>()?)
    }

    /// All constants with their values, in the order of declaration.
    #[getter]
    fn constants<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let all = PyDict::new(py);
        for (name, value) in &self.inner.program().constants {
            all.set_item(name, values::constant(py, value.rounded())?)?;
        }
        Ok(all)
    }

    /// The names of the action labels.
    #[getter]
    fn actions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        PyList::new(py, &self.inner.program().actions)
    }

    /// The names of the labels.
    #[getter]
    fn labels<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        PyList::new(py, self.inner.program().labels.iter().map(|(name, _)| name))
    }

    /// The warnings about the text, each with its place, as text.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.inner.warnings().iter().map(|w| render(std::slice::from_ref(w), false)).collect()
    }

    /// Returns a state as a dictionary: the given values, and the initial values of all other
    /// variables.
    ///
    /// Raises:
    ///     UsageError: An unknown variable, a value of the wrong type or out of range, or a
    ///         variable without a value and without a single initial value.
    #[pyo3(signature = (**values))]
    fn state<'py>(
        &self,
        py: Python<'py>,
        values: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let program = self.inner.program();
        let mut state: Vec<Option<i64>> = program.variables.iter().map(|v| v.initial).collect();
        for (id, value) in values.map_or(Ok(Vec::new()), |v| self.names.fixed(v))? {
            let variable = &program.variables[id.index()];
            if !(variable.low..=variable.high).contains(&value) {
                let (low, high) = (variable.low, variable.high);
                let message = format!("{}={value} is outside of its range {low}..{high}", variable.name);
                return Err(usage(message));
            }
            state[id.index()] = Some(value);
        }
        let mut complete = Vec::with_capacity(state.len());
        for (variable, value) in program.variables.iter().zip(state) {
            complete.push(value.ok_or_else(|| {
                usage(format!("no value for `{}`, and it has no single initial value", variable.name))
            })?);
        }
        self.names.dict(py, &complete)
    }

    fn __repr__(&self) -> String {
        let variables = self.inner.program().variables.len();
        let plural = if variables == 1 { "" } else { "s" };
        format!("<Model {:?}: {}, {variables} variable{plural}>", self.name(), self.kind())
    }

    fn _repr_html_(slf: &Bound<'_, Self>) -> PyResult<String> {
        display::html(slf.as_any(), "model")
    }
}
