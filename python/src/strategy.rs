//! Strategies.

use std::sync::{Arc, Mutex};

use meliora::commands::strategies::PolicyNodes;
use meliora::model::State;
use meliora::output::choose::{Attains, Comparison};
use meliora::output::reason::Words;
use meliora::planning::explain::Explanation as Explained;
use meliora::planning::{Memory, Scheduler, Setup};
use meliora::supervise::{Reporter, lock};
use meliora::{Choose, Error, Record, Result, StrategyKind, ValuedRule, Wanted};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use serde_json::to_string;

use crate::errors::{unpicklable, usage};
use crate::explanation::Explanation;
use crate::handle::Handle;
use crate::play::Play;
use crate::region::Space;
use crate::shield::Shield;
use crate::simulation::Simulation;
use crate::values::plain;
use crate::worker::Call;
use crate::{arrays, options};

/// A strategy: the strategies of all levels of one kind, a plan, or a strategy that achieves one
/// objective.
///
/// Actions are named by their labels. An unlabelled command is `module#k`. If a label has several
/// choices in a state, the names distinguish them: `label(m1#2,m2#1)`.
#[pyclass(frozen, module = "meliora")]
pub(crate) struct Strategy {
    shared: SharedStrategy,
    /// The analysis that it comes from, and the objective that the user named.
    origin: (Handle, Option<String>),
}

/// The data shared by a strategy and its runs.
#[derive(Clone)]
pub(crate) struct SharedStrategy {
    kind: StrategyKind,
    inner: Arc<Mutex<meliora::Strategy>>,
    choose: Choose,
    /// The rule that chooses by value.
    chooser: Option<Arc<dyn ValuedRule>>,
    pub(crate) space: Space,
}

/// The selection of actions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Which {
    Permitted,
    Progress,
    Chosen,
    Kept,
}

impl Which {
    pub(crate) fn named(name: &str) -> PyResult<Self> {
        match name {
            "permitted" => Ok(Which::Permitted),
            "progress" => Ok(Which::Progress),
            "chosen" => Ok(Which::Chosen),
            "kept" => Ok(Which::Kept),
            _ => Err(usage(format!(
                "which={name:?}: it is one of \"permitted\", \"progress\", \"chosen\", \"kept\""
            ))),
        }
    }

    pub(crate) fn names(self, at: &Explained) -> Vec<String> {
        let first = at.actions.iter().position(|action| action.progress);
        let actions = at.actions.iter().enumerate().filter(|(index, action)| match self {
            Which::Permitted => action.permitted,
            Which::Progress => first == Some(*index),
            Which::Chosen => at.pick == Some(*index),
            Which::Kept => action.kept && !at.is_theirs(),
        });
        actions.map(|(_, action)| action.name.clone()).collect()
    }
}

impl SharedStrategy {
    /// Explains a state; on a worker thread if a strategy must be computed first.
    pub(crate) fn explain(
        &self,
        py: Python<'_>,
        state: State,
        memory: Option<Memory>,
    ) -> PyResult<Explained> {
        let inner = Arc::clone(&self.inner);
        let memory_of = move |strategy: &meliora::Strategy, state: &[i64]| {
            memory.map_or_else(|| strategy.start(state), Ok)
        };
        if !self.may_compute() {
            let known = self.space.worker.quick(py, || {
                let mut strategy = lock(&self.inner);
                let memory = memory_of(&strategy, &state)?;
                strategy.knows(memory).then(|| strategy.explain(&state, memory)).transpose()
            })?;
            if let Some(found) = known {
                return Ok(found);
            }
        }
        self.space.worker.phase(py, &Call::plain(), "strategy", move || {
            let mut strategy = lock(&inner);
            let memory = memory_of(&strategy, &state)?;
            strategy.explain(&state, memory)
        })
    }

    /// Returns whether even the memory of a state may need a computation: a plan determines which
    /// objectives kept actions achieve when it first asks.
    fn may_compute(&self) -> bool {
        self.kind == StrategyKind::Plan
    }

    /// Returns what a query returns; on a worker thread if it may need a computation.
    pub(crate) fn query<T: Send + 'static>(
        &self,
        py: Python<'_>,
        query: impl FnOnce(&meliora::Strategy) -> Result<T> + Send + 'static,
    ) -> PyResult<T> {
        if !self.may_compute() {
            return self.quick(py, query);
        }
        let inner = Arc::clone(&self.inner);
        self.space.worker.long(py, move || query(&lock(&inner)))
    }

    /// Returns what a short query of the strategy returns.
    pub(crate) fn quick<T>(
        &self,
        py: Python<'_>,
        query: impl FnOnce(&meliora::Strategy) -> Result<T>,
    ) -> PyResult<T> {
        self.space.worker.quick(py, || query(&lock(&self.inner)))
    }

    /// Returns a state; it must be in the scope.
    pub(crate) fn state(&self, py: Python<'_>, state: &Bound<'_, PyAny>) -> PyResult<State> {
        let state = self.space.names.state(state)?;
        if self.quick(py, |strategy| strategy.is_state(&state))? {
            return Ok(state);
        }
        let shown = self.space.names.program.show_state(&state);
        Err(usage(format!("{shown} is not a state of the scope")))
    }

    /// Returns for each action if one with its label is selected.
    pub(crate) fn mask<'py>(
        &self,
        py: Python<'py>,
        at: &Explained,
        actions: Option<Vec<String>>,
        which: &str,
    ) -> PyResult<Bound<'py, PyAny>> {
        let actions = actions.unwrap_or_else(|| self.space.names.actions.clone());
        let names = Which::named(which)?.names(at);
        // A choice among several with one label is called `label(…)`.
        let label = |name: &str, action: &str| {
            name.strip_prefix(action).is_some_and(|rest| rest.is_empty() || rest.starts_with('('))
        };
        let mask: Vec<bool> =
            actions.iter().map(|action| names.iter().any(|name| label(name, action))).collect();
        arrays::bools(py, &mask, &[mask.len()])
    }

    pub(crate) fn explanation(&self, py: Python<'_>, at: &Explained) -> PyResult<Explanation> {
        // The objects of Python are made without the lock: its collector may run any code.
        let (rank, preferences, levels) = self.quick(py, |strategy| {
            Ok((strategy.rank(&at.state)?, strategy.preferences().clone(), strategy.levels()))
        })?;
        let (program, preferences) = (&*self.space.names.program, &preferences);
        let words = Words { program, preferences, kind: self.kind, levels };
        Explanation::new(py, &self.space.names, at, rank, words)
    }
}

impl Strategy {
    /// Returns a strategy of a kind, for runs from some states if it chooses by value. The limits are
    /// those of a call.
    pub(crate) fn new(
        (py, call): (Python<'_>, &Call),
        handle: &Handle,
        (kind, objective): (StrategyKind, Option<String>),
        choose: Choose,
        states: Vec<State>,
        wanted: Wanted,
    ) -> PyResult<Self> {
        let origin = (handle.clone(), objective.clone());
        let (inner, chooser) = handle.call(py, call, "strategy", move |analysis| {
            let levels = choose.levels(kind);
            if analysis.levels(levels).end.is_none() {
                let message = format!("the levels of {levels} are not known: `resume` the analysis first");
                return Err(Error::Usage(message));
            }
            let mut strategy = analysis.strategy_of(kind, choose, objective.as_deref())?;
            let chooser = analysis.choose_by(&mut strategy, choose, &states, &wanted)?;
            Ok((strategy, chooser))
        })?;
        let inner = Arc::new(Mutex::new(inner));
        let shared = SharedStrategy { kind, inner, choose, chooser, space: handle.space.clone() };
        Ok(Strategy { shared, origin })
    }
}

#[pymethods]
impl Strategy {
    /// `"sasi"`, `"spi"`, `"plan"` or `"achieve"`.
    #[getter]
    fn kind(&self) -> &'static str {
        self.shared.kind.name()
    }

    /// `"first"`, `"likely"` or `"cheap"`: how the strategy chooses among the permitted actions.
    #[getter]
    fn choose(&self) -> &'static str {
        self.shared.choose.name()
    }

    /// Returns the value of the strategy from a state: a dictionary with the number of
    /// `improvements` that it aims at, bounds of their `probability`, and bounds of the expected
    /// `cost` (None if they are not certain). None with `choose="first"`, and for unsafe states.
    ///
    /// Raises:
    ///     UsageError: The values of the state were not computed; see `Analysis.strategy`.
    fn attains(&self, py: Python<'_>, state: &Bound<'_, PyAny>) -> PyResult<Option<Py<PyAny>>> {
        let state = self.shared.state(py, state)?;
        let Some(chooser) = &self.shared.chooser else { return Ok(None) };
        if self.shared.quick(py, |strategy| strategy.is_unsafe(&state))? {
            return Ok(None);
        }
        let Some(attained) = chooser.attained(&state) else {
            let shown = self.shared.space.names.program.show_state(&state);
            return Err(usage(format!("the values of the state {shown} were not computed")));
        };
        plain(py, to_string(&Attains::new(&attained))).map(Some)
    }

    /// Returns the actions of a start state: the permitted ones, the one of the progress strategy,
    /// the one that the strategy chooses, or those that the safety mode keeps, even if they do not
    /// lead to an improvement. Empty where there is none, for example at rank 0 or where the opponent
    /// of a game chooses; `explain` has the reason for each action.
    ///
    /// Args:
    ///     state: A dictionary with a value for every variable.
    ///     which: "permitted", "progress", "chosen" or "kept".
    ///
    /// Raises:
    ///     UsageError: The state is not in the scope.
    #[pyo3(signature = (state, which="permitted"))]
    fn actions(&self, py: Python<'_>, state: &Bound<'_, PyAny>, which: &str) -> PyResult<Vec<String>> {
        let which = Which::named(which)?;
        let state = self.shared.state(py, state)?;
        Ok(which.names(&self.shared.explain(py, state, None)?))
    }

    /// Returns the successors of the enabled actions: for each action a list of pairs (probability,
    /// state).
    fn successors<'py>(&self, py: Python<'py>, state: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyDict>> {
        let state = self.shared.state(py, state)?;
        let at = self.shared.explain(py, state, None)?;
        let all = PyDict::new(py);
        for action in &at.actions {
            let successors = action
                .successors
                .iter()
                .map(|s| Ok((s.probability, self.shared.space.names.dict(py, &s.state)?)));
            all.set_item(&action.name, PyList::new(py, successors.collect::<PyResult<Vec<_>>>()?)?)?;
        }
        Ok(all)
    }

    /// Explains every enabled action of a start state: if it is permitted, its successors, and the
    /// reason.
    fn explain(&self, py: Python<'_>, state: &Bound<'_, PyAny>) -> PyResult<Explanation> {
        let state = self.shared.state(py, state)?;
        let at = self.shared.explain(py, state, None)?;
        self.shared.explanation(py, &at)
    }

    /// Returns an action mask for reinforcement learning: a Boolean array with an entry for each of
    /// `actions`; None for the labels of the model in the order of `Model.actions`. Needs NumPy.
    /// An entry is True if some choice with the label is permitted; a shield wants all of them.
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
        let state = self.shared.state(py, state)?;
        let at = self.shared.explain(py, state, None)?;
        self.shared.mask(py, &at, actions, which)
    }

    /// Returns a shield: a table of the permitted actions of all states of the scope, with the
    /// memory of the strategy. It needs no model, and answers in microseconds.
    ///
    /// Args:
    ///     limit: Maximum number of states with memory.
    ///     timeout, progress: As in `Model.explore`.
    ///
    /// Raises:
    ///     UsageError: The strategy chooses by value, or the safety mode is "transition", which promises
    ///         nothing about single steps; or choices with one label cannot be permitted together.
    ///     TooLarge: There are more than `limit` states with memory.
    #[pyo3(signature = (*, limit=1_000_000, timeout=None, progress=None))]
    fn shield(
        &self,
        py: Python<'_>,
        limit: i128,
        timeout: Option<&Bound<'_, PyAny>>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Shield> {
        let limit = options::count("limit", limit)?;
        let (call, inner) = (Call::new(timeout, progress)?, Arc::clone(&self.shared.inner));
        let work = move || meliora::Shield::new(&mut lock(&inner), limit);
        Shield::new(py, self.shared.space.worker.phase(py, &call, "shield", work)?)
    }

    /// Returns a policy with memory, as `meliora strategy --policy` writes it: a dictionary that `Model.verify_policy`
    /// checks, and `json.dump` writes. Paths start in the initial states, where it promises what the kind of the
    /// strategy says.
    ///
    /// Args:
    ///     picks: "progress" for one action in each state, "permissive" for all permitted ones.
    ///     everywhere: Paths may start in all states of the scope from which the strategy does something sure.
    ///     limit: Maximum number of states with memory.
    ///     timeout, progress: As in `Model.explore`.
    ///
    /// Raises:
    ///     UsageError: No policy keeps the promise from the initial states, or the safety mode is "transition".
    ///     TooLarge: There are more than `limit` states with memory.
    #[pyo3(signature = (*, picks="progress", everywhere=false, limit=1_000_000, timeout=None, progress=None))]
    fn policy(
        &self,
        py: Python<'_>,
        picks: &str,
        everywhere: bool,
        limit: i128,
        timeout: Option<&Bound<'_, PyAny>>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Py<PyAny>> {
        let (scheduler, limit) = (options::picks(picks)?, options::count("limit", limit)?);
        let (call, inner) = (Call::new(timeout, progress)?, Arc::clone(&self.shared.inner));
        let (handle, objective) = self.origin.clone();
        let text = handle.call(py, &call, "strategy", move |analysis| {
            let (program, objective) = (analysis.program(), objective.as_deref());
            let nodes = PolicyNodes { program, objective, scheduler, all: everywhere, limit };
            let mut text = String::new();
            nodes.write(analysis, &mut lock(&inner), &mut |piece| {
                text.push_str(piece);
                Ok(())
            })?;
            Ok(text)
        })?;
        plain(py, Ok(text))
    }

    /// Starts a run in a state; it keeps the memory of the strategy.
    fn play(&self, py: Python<'_>, state: &Bound<'_, PyAny>) -> PyResult<Play> {
        let state = self.shared.state(py, state)?;
        Play::start(py, self.shared.clone(), state)
    }

    /// Simulates random runs from a state, as arrays. The same seed gives the same runs, with any
    /// engine, on any machine.
    ///
    /// Args:
    ///     state: The start state of the runs.
    ///     runs: Number of runs.
    ///     steps: Maximum number of steps of a run.
    ///     seed: An integer from 0.
    ///     picks: "progress" takes the action that the strategy chooses; "permissive" draws
    ///         uniformly from the permitted actions, which is for `choose="first"` only.
    ///     opponent: How the opponent of a game chooses: "random" draws uniformly from its actions;
    ///         "worst" keeps the next improvement, or the pursued objective, away longest.
    ///     timeout, progress: As in `Model.explore`.
    #[pyo3(signature = (state, *, runs=1000, steps=1000, seed=1, picks="progress", opponent="random", timeout=None, progress=None))]
    #[expect(clippy::too_many_arguments, reason = "they have names in Python")]
    fn simulate(
        &self,
        py: Python<'_>,
        state: &Bound<'_, PyAny>,
        runs: i128,
        steps: i128,
        seed: i128,
        picks: &str,
        opponent: &str,
        timeout: Option<&Bound<'_, PyAny>>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Simulation> {
        let opponent = options::opponent(opponent)?;
        let (runs, steps) = (options::count("runs", runs)?, options::count("steps", steps)?);
        let seed = options::count("seed", seed)?;
        let setup = Setup { scheduler: options::picks(picks)?, runs, steps, seed };
        let call = Call::new(timeout, progress)?;
        let start = self.shared.state(py, state)?;
        if setup.scheduler == Scheduler::Permissive && self.shared.choose != Choose::First {
            let name = self.shared.choose.name();
            return Err(usage(format!(
                "picks=\"permissive\" takes all permitted actions; choose={name:?} takes one"
            )));
        }
        let attained = self.shared.chooser.as_ref().and_then(|chooser| chooser.attained(&start));
        let inner = Arc::clone(&self.shared.inner);
        let work = move |reporter: &Reporter<'_>| {
            reporter.report("plays", format!("{runs} plays"));
            Record::simulate(&mut lock(&inner), (setup, opponent), &start)
        };
        let worker = &self.shared.space.worker;
        let (objectives, kind) = self.shared.quick(py, |strategy| {
            let names = strategy.preferences().objectives.iter().map(|o| o.name.clone());
            Ok((names.collect(), (strategy.kind(), strategy.levels())))
        })?;
        let (tally, record) = worker.run(py, &call, work).map_err(|failure| failure.raise(py))?;
        let attained = attained.as_ref().map(Attains::new).zip(tally.sample.clone());
        let value = attained
            .map(|(value, sample)| plain(py, to_string(&Comparison { value, sample })))
            .transpose()?;
        Simulation::new(py, &self.shared.space.names, objectives, (&tally, value), (record, kind))
    }

    fn __repr__(&self) -> String {
        format!("<Strategy of {}>", self.shared.kind.name())
    }

    fn __reduce__(&self) -> PyResult<Py<PyAny>> {
        Err(unpicklable("a Strategy", "explanations as text and arrays can be pickled"))
    }
}
