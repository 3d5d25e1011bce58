//! Random runs as arrays.

use std::sync::Arc;

use meliora::planning::tally::{Commitment, Tally};
use meliora::planning::{Kind, StrategyKind};
use meliora::{Record, RecordedRun};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

use crate::arrays;
use crate::values::{Names, rank_of};

/// Random runs under a strategy. Arrays need NumPy.
#[pyclass(frozen, module = "meliora")]
pub(crate) struct Simulation {
    names: Arc<Names>,
    record: Record,
    /// The rank of the start state: an int, or `math.inf`.
    #[pyo3(get)]
    rank: Py<PyAny>,
    /// The number of runs that ended without a further improvement ahead; the others reached the
    /// limit on steps.
    #[pyo3(get)]
    settled: u64,
    /// The number of runs with a step that weakens the state before it. Steps after a commitment are
    /// not counted, here and below.
    #[pyo3(get)]
    weakened_step: u64,
    /// The number of runs with a state that weakens the start state.
    #[pyo3(get)]
    weakened_start: u64,
    /// The number of runs that entered an unsafe state: 0, because no strategy leads there.
    #[pyo3(get)]
    entered_unsafe: u64,
    /// The number of runs for each number of improvements.
    #[pyo3(get)]
    improvements: Py<PyDict>,
    /// The number of steps of all runs that each player of a game chose; {} for other models.
    #[pyo3(get)]
    moves: Py<PyDict>,
    /// The value that the strategy attains, computed and measured: a dictionary with the number of
    /// `improvements`, bounds of their `probability` and `cost`, `measured_probability`,
    /// `measured_cost`, their `probability_interval` and `cost_interval` with 99 % `confidence`, and
    /// `agrees`. None with `choose="first"`.
    #[pyo3(get)]
    value: Option<Py<PyAny>>,
    /// The number of runs that ended because they had achieved the objective that they pursued; None
    /// for strategies that achieve none.
    #[pyo3(get)]
    achieved_runs: Option<u64>,
    /// The number of other runs that kept the objective that they pursued: no step achieves it, and
    /// the run can go on to satisfy it. None for strategies that achieve none.
    #[pyo3(get)]
    kept_runs: Option<u64>,
    /// The commitments of plans: dictionaries with the `objective` that the runs then pursued, the
    /// objectives that they gave up (`gives_up`), and the number of these `runs`. Empty if no run commits.
    #[pyo3(get)]
    commits: Py<PyList>,
    /// Why no run has a step, so that `actions` and `improves` are empty; None if some run has one.
    #[pyo3(get)]
    reason: Option<&'static str>,
    /// The names of the objectives, in the order of declaration.
    objectives: Vec<String>,
}

/// Returns why no run has a step; `None` if some run has one.
fn reason(record: &Record, kind: (StrategyKind, Kind), tally: &Tally) -> Option<&'static str> {
    let counted = tally.achieved.as_ref();
    Some(match kind.0 {
        _ if record.longest() > 0 => return None,
        _ if tally.is_unsafe => "no strategy keeps the requirements from the start",
        _ if counted.is_some_and(|counted| counted.runs > 0) => {
            "the pursued objective is achieved in the start"
        }
        _ if counted.is_some_and(|counted| counted.kept > 0) => {
            "the pursued objective is kept by staying in the start"
        }
        StrategyKind::Achieve => "the strategy does not achieve the objective from the start",
        StrategyKind::Plan => "there is nothing to improve in the start, and no objective is sure",
        StrategyKind::Sasi if kind.1 == Kind::Sasi => {
            "no improvement is guaranteed from the start; kind=\"spi\" tries possible ones"
        }
        StrategyKind::Sasi | StrategyKind::Spi => "no improvement is possible from the start",
    })
}

impl Simulation {
    pub(crate) fn new(
        py: Python<'_>,
        names: &Arc<Names>,
        objectives: Vec<String>,
        (tally, value): (&Tally, Option<Py<PyAny>>),
        (record, kind): (Record, (StrategyKind, Kind)),
    ) -> PyResult<Self> {
        let improvements = PyDict::new(py);
        for (times, plays) in &tally.improvements {
            improvements.set_item(times, plays)?;
        }
        let moves = PyDict::new(py);
        let players = names.program.players.iter().flat_map(|players| &players.list);
        for (number, player) in players.enumerate() {
            moves.set_item(&player.name, tally.steps_of.get(&number).copied().unwrap_or(0))?;
        }
        let commits = PyList::empty(py);
        for (Commitment { objective, gives_up }, runs) in &tally.commitments {
            let one = PyDict::new(py);
            one.set_item("objective", &objectives[*objective])?;
            let given_up: Vec<&String> = gives_up.iter().map(|objective| &objectives[objective]).collect();
            one.set_item("gives_up", given_up)?;
            one.set_item("runs", runs)?;
            commits.append(one)?;
        }
        Ok(Simulation {
            names: Arc::clone(names),
            rank: rank_of(py, tally.rank)?.unbind(),
            settled: tally.settled,
            weakened_step: tally.weakened_step,
            weakened_start: tally.weakened_start,
            entered_unsafe: tally.entered_unsafe,
            improvements: improvements.unbind(),
            moves: moves.unbind(),
            value,
            achieved_runs: tally.achieved.as_ref().map(|achieved| achieved.runs),
            kept_runs: tally.achieved.as_ref().map(|achieved| achieved.kept),
            commits: commits.unbind(),
            reason: reason(&record, kind, tally),
            record,
            objectives,
        })
    }
}

#[pymethods]
impl Simulation {
    /// The number of runs.
    fn __len__(&self) -> usize {
        self.record.runs.len()
    }

    /// The names of the variables, in the order of the last axis of `states`.
    #[getter]
    fn variables<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        PyList::new(py, self.names.program.variables.iter().map(|v| &v.name))
    }

    /// The names of the actions taken, indexed by the numbers in `actions`; empty if no run has a step: see
    /// `reason`.
    #[getter]
    fn action_names<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        PyList::new(py, &self.record.actions)
    }

    /// The number of steps of each run: integers of shape (runs,).
    #[getter]
    fn lengths<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let lengths: Vec<i64> = self.record.runs.iter().map(|play| play.actions.len() as i64).collect();
        arrays::longs(py, &lengths, &[lengths.len()])
    }

    /// The states of each run, its start first: integers of shape (runs, longest + 1, variables),
    /// Booleans as 0 and 1. A run that has ended stays in its last state.
    #[getter]
    fn states<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let shape = [self.record.runs.len(), self.record.longest() + 1, self.record.start.len()];
        arrays::longs(py, &self.record.states(), &shape)
    }

    /// The actions of each run by their indices in `action_names`: integers of shape (runs,
    /// longest), -1 after the end of a run.
    #[getter]
    fn actions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let all = self.record.steps(|run| &run.actions, -1);
        arrays::longs(py, &all, &[self.record.runs.len(), self.record.longest()])
    }

    /// The steps that are improvements: Booleans of shape (runs, longest), False after the end of a
    /// run.
    #[getter]
    fn improves<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let all = self.record.steps(|run| &run.improves, false);
        arrays::bools(py, &all, &[self.record.runs.len(), self.record.longest()])
    }

    /// For each objective that some run achieved, the number of steps of each run until then: integers
    /// of shape (runs,), -1 for runs that did not achieve it. Empty for strategies that achieve none.
    #[getter]
    fn achieved<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let all = PyDict::new(py);
        for (objective, name) in self.objectives.iter().enumerate() {
            let step = |play: &RecordedRun| play.achieved.get(&objective).copied().unwrap_or(-1);
            let steps: Vec<i64> = self.record.runs.iter().map(step).collect();
            if steps.iter().any(|&step| step >= 0) {
                all.set_item(name, arrays::longs(py, &steps, &[steps.len()])?)?;
            }
        }
        Ok(all)
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let improvements = self.improvements.bind(py).repr()?;
        let reason = self.reason.map(|reason| format!(": {reason}")).unwrap_or_default();
        let runs = self.record.runs.len();
        Ok(format!("<Simulation of {runs} plays, improvements {improvements}{reason}>"))
    }
}
