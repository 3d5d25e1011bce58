//! Random plays as arrays.

use std::collections::BTreeMap;
use std::sync::Arc;

use meliora::planning::simulate::{Tally, Trace};
use meliora::planning::{Setup, Simulation as Plays};
use meliora::{Result, embed};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

use crate::values::Names;
use crate::{arrays, levels};

/// Random plays under a strategy. Arrays need NumPy.
#[pyclass(frozen, module = "meliora")]
pub(crate) struct Simulation {
    names: Arc<Names>,
    record: Recorder,
    /// The rank of the state that the plays start in: an int, or `math.inf`.
    #[pyo3(get)]
    rank: Py<PyAny>,
    /// How many plays ended where no improvement is left; the others were given up.
    #[pyo3(get)]
    settled: u64,
    /// How many plays had a step that weakens the state before it.
    #[pyo3(get)]
    weakened_step: u64,
    /// How many plays had a state that weakens the one they started in.
    #[pyo3(get)]
    weakened_start: u64,
    /// How many plays improved how often.
    #[pyo3(get)]
    improvements: Py<PyDict>,
}

/// What happened in some plays.
pub(crate) struct Recorder {
    /// The values of the start.
    start: Vec<i64>,
    plays: Vec<Steps>,
    actions: Vec<String>,
}

/// The steps of one play.
#[derive(Default)]
struct Steps {
    /// The values of the states entered, one after the other.
    states: Vec<i64>,
    /// The actions, by their positions.
    actions: Vec<i64>,
    improves: Vec<bool>,
}

impl Recorder {
    /// Plays, and writes down what happens.
    ///
    /// # Errors
    /// A limit; a command without a meaning in some state.
    pub(crate) fn record(
        strategy: &mut embed::Strategy,
        setup: Setup,
        start: &[i64],
    ) -> Result<(Tally, Recorder)> {
        let mut numbers: BTreeMap<String, i64> = BTreeMap::new();
        let mut actions = Vec::new();
        let mut plays = Vec::new();
        let mut each = |trace: &Trace| {
            let mut steps = Steps::default();
            for turn in &trace.turns {
                steps.states.extend(&turn.state);
                steps.improves.push(turn.improves);
                let number = numbers.entry(turn.action.clone()).or_insert_with(|| {
                    actions.push(turn.action.clone());
                    actions.len() as i64 - 1
                });
                steps.actions.push(*number);
            }
            plays.push(steps);
        };
        let tally = Plays::new(strategy.book(), setup).run_each(start, &mut each)?;
        Ok((tally, Recorder { start: start.to_vec(), plays, actions }))
    }

    /// The steps of the longest play.
    fn longest(&self) -> usize {
        self.plays.iter().map(|play| play.actions.len()).max().unwrap_or(0)
    }
}

impl Simulation {
    pub(crate) fn new(py: Python<'_>, names: &Arc<Names>, tally: &Tally, record: Recorder) -> PyResult<Self> {
        let improvements = PyDict::new(py);
        for (times, plays) in &tally.improvements {
            improvements.set_item(times, plays)?;
        }
        Ok(Simulation {
            names: Arc::clone(names),
            record,
            rank: levels::rank_of(py, tally.rank)?.unbind(),
            settled: tally.settled,
            weakened_step: tally.weakened_step,
            weakened_start: tally.weakened_start,
            improvements: improvements.unbind(),
        })
    }
}

#[pymethods]
impl Simulation {
    /// How many plays there are.
    fn __len__(&self) -> usize {
        self.record.plays.len()
    }

    /// The names of the variables, in the order of the last axis of `states`.
    #[getter]
    fn variables<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        PyList::new(py, self.names.program.variables.iter().map(|v| &v.name))
    }

    /// The names of the actions taken, by the numbers in `actions`.
    #[getter]
    fn action_names<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        PyList::new(py, &self.record.actions)
    }

    /// The steps of each play: integers of shape (plays,).
    #[getter]
    fn lengths<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let lengths: Vec<i64> = self.record.plays.iter().map(|play| play.actions.len() as i64).collect();
        arrays::longs(py, &lengths, &[lengths.len()])
    }

    /// The states of each play, its start first: integers of shape (plays, longest + 1, variables), Booleans as 0 and
    /// 1. After its end a play stays in its last state.
    #[getter]
    fn states<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let (width, longest) = (self.record.start.len(), self.record.longest());
        let mut all = Vec::with_capacity(self.record.plays.len() * (longest + 1) * width);
        for play in &self.record.plays {
            all.extend(&self.record.start);
            all.extend(&play.states);
            for _ in play.actions.len()..longest {
                all.extend_from_within(all.len() - width..);
            }
        }
        arrays::longs(py, &all, &[self.record.plays.len(), longest + 1, width])
    }

    /// The actions of each play by their positions in `action_names`: integers of shape (plays, longest), -1 after
    /// its end.
    #[getter]
    fn actions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let longest = self.record.longest();
        let mut all = Vec::with_capacity(self.record.plays.len() * longest);
        for play in &self.record.plays {
            all.extend(&play.actions);
            all.extend((play.actions.len()..longest).map(|_| -1));
        }
        arrays::longs(py, &all, &[self.record.plays.len(), longest])
    }

    /// Which steps are improvements: Booleans of shape (plays, longest), False after the end of a play.
    #[getter]
    fn improves<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let longest = self.record.longest();
        let mut all = Vec::with_capacity(self.record.plays.len() * longest);
        for play in &self.record.plays {
            all.extend(&play.improves);
            all.extend((play.actions.len()..longest).map(|_| false));
        }
        arrays::bools(py, &all, &[self.record.plays.len(), longest])
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let improvements = self.improvements.bind(py).repr()?;
        Ok(format!("<Simulation of {} plays, improvements {improvements}>", self.record.plays.len()))
    }
}
