//! Shields.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex};

use meliora::export::{read_shield, write_shield};
use meliora::model::State;
use meliora::planning::{ShieldNode, ShieldVariable};
use meliora::supervise::lock;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyList, PyString, PyTuple};

use crate::arrays;
use crate::errors::{Failure, unpicklable, usage};
use crate::values::as_dict;

/// The permitted actions of all states, for an agent that acts step by step. A shield needs no
/// model, and follows levels, references and monitors.
///
/// Promise: where `secure` is True, no step that follows the shield ever weakens, from there on,
/// whatever the environment does, as long as it behaves as the model says. While `ahead` is
/// greater than 0, the permitted actions are those of the permissive strategy of the level: for
/// "sasi", an agent that takes each of them again and again improves almost surely. Where `secure` is
/// False, the permitted actions are those of the strategy or those that the safety mode keeps; all, if
/// there are none. Steps are compared as the safety mode says: with "action", with the state before
/// the step; with "prefix", with the reference.
///
/// An episode starts with `reset`, or with the first state. A call with another state than the
/// present one is a step; a call with the present state is a step only after `correct`, or after
/// `step`. A state is a dictionary, or a sequence of values in the order of the variables (without
/// those of monitors), or a number if there is one variable.
///
/// Must not be used by several threads at once.
#[pyclass(frozen, module = "meliora")]
pub(crate) struct Shield {
    table: Arc<Table>,
    names: Vec<Py<PyString>>,
    at: Mutex<At>,
}

/// A shield with indices and results that are ready to return.
struct Table {
    shield: meliora::Shield,
    starts: HashMap<State, usize>,
    /// For each node, a position in `answers`.
    answer_of: Vec<usize>,
    answers: Vec<Answer>,
}

/// The permitted actions of nodes, as they are returned.
struct Answer {
    allowed: Py<PyTuple>,
    mask: Py<PyAny>,
    flags: Vec<bool>,
}

/// The position of an episode.
#[derive(Debug, Clone, Copy, Default)]
struct At {
    node: Option<usize>,
    /// The action that was taken in the node.
    taken: Option<usize>,
}

impl Table {
    fn new(py: Python<'_>, shield: meliora::Shield) -> PyResult<Self> {
        let starts =
            shield.nodes[..shield.starts].iter().enumerate().map(|(v, n)| (n.state.clone(), v)).collect();
        let mut table = Table { shield, starts, answer_of: Vec::new(), answers: Vec::new() };
        let mut known: HashMap<Vec<bool>, usize> = HashMap::new();
        for node in &table.shield.nodes {
            let flags = flags(node, table.shield.actions.len());
            let next = table.answers.len();
            let place = *known.entry(flags.clone()).or_insert(next);
            if place == next {
                table.answers.push(Answer::new(py, &table.shield.actions, flags)?);
            }
            table.answer_of.push(place);
        }
        Ok(table)
    }

    fn answer(&self, node: usize) -> &Answer {
        &self.answers[self.answer_of[node]]
    }

    /// Returns the values of a node's state without those of monitors.
    fn shown(&self, node: usize) -> impl Iterator<Item = i64> {
        let all = self.shield.variables.iter().zip(&self.shield.nodes[node].state);
        all.filter(|(variable, _)| variable.monitor.is_none()).map(|(_, value)| *value)
    }

    fn start(&self, values: &[i64]) -> Option<usize> {
        let mut values = values.iter();
        let of = |variable: &ShieldVariable| variable.monitor.or_else(|| values.next().copied());
        let state: Option<State> = self.shield.variables.iter().map(of).collect();
        self.starts.get(&state?).copied()
    }

    /// Returns the node that a step enters.
    fn after(&self, at: usize, taken: Option<usize>, values: &[i64]) -> Option<usize> {
        let actions = &self.shield.nodes[at].actions;
        let possible = actions.iter().filter(|action| taken.is_none_or(|taken| action.action == taken));
        possible
            .flat_map(|action| &action.next)
            .copied()
            .find(|&to| self.shown(to).eq(values.iter().copied()))
    }
}

fn flags(node: &ShieldNode, actions: usize) -> Vec<bool> {
    let mut flags = vec![false; actions];
    node.actions.iter().filter(|action| action.permitted).for_each(|action| flags[action.action] = true);
    flags
}

impl Answer {
    fn new(py: Python<'_>, actions: &[String], flags: Vec<bool>) -> PyResult<Self> {
        let names = actions.iter().zip(&flags).filter(|(_, flag)| **flag).map(|(name, _)| name);
        let allowed = PyTuple::new(py, names.collect::<Vec<_>>())?.unbind();
        let mask = match py.import("numpy") {
            Ok(_) => arrays::bools(py, &flags, &[flags.len()])?,
            Err(_) => PyList::new(py, &flags)?.into_any(),
        };
        if mask.hasattr("setflags")? {
            mask.call_method1("setflags", (false,))?;
        }
        Ok(Answer { allowed, mask: mask.unbind(), flags })
    }
}

impl Shield {
    pub(crate) fn new(py: Python<'_>, shield: meliora::Shield) -> PyResult<Self> {
        let own = shield.variables.iter().filter(|variable| variable.monitor.is_none());
        let names = own.map(|variable| PyString::new(py, &variable.name).unbind()).collect();
        Ok(Shield { table: Arc::new(Table::new(py, shield)?), names, at: Mutex::default() })
    }

    fn values(&self, state: &Bound<'_, PyAny>) -> PyResult<State> {
        let own = self.table.shield.variables.iter().filter(|variable| variable.monitor.is_none());
        let wrong = |problem: &str| usage(format!("{state} is not a state: {problem}"));
        if state.cast::<PyDict>().is_ok() || state.hasattr("items")? && !state.hasattr("shape")? {
            let dict = as_dict(state)?;
            let mut values = State::with_capacity(self.names.len());
            for (variable, name) in own.zip(&self.names) {
                let Some(value) = dict.get_item(name)? else {
                    return Err(wrong(&format!("it has no value for `{}`", variable.name)));
                };
                values.push(read(variable, &value)?);
            }
            return Ok(values);
        }
        if self.names.len() == 1 && !state.hasattr("__len__")? {
            return own.map(|variable| read(variable, state)).collect();
        }
        let values: Vec<Bound<'_, PyAny>> = state
            .try_iter()
            .map_err(|_| wrong("expected a dictionary or a sequence"))?
            .collect::<PyResult<_>>()?;
        if values.len() != self.names.len() {
            return Err(wrong(&format!("expected {} values", self.names.len())));
        }
        own.zip(&values).map(|(variable, value)| read(variable, value)).collect()
    }

    /// Moves to the node of a state. `again` says that the present state is a step, too.
    fn observe(&self, state: &Bound<'_, PyAny>, again: bool) -> PyResult<usize> {
        let values = self.values(state)?;
        let mut at = lock(&self.at);
        let node = match *at {
            At { node: None, .. } => self.table.start(&values).ok_or_else(|| not_in_scope(state))?,
            At { node: Some(node), taken: None }
                if !again && self.table.shown(node).eq(values.iter().copied()) =>
            {
                return Ok(node);
            }
            At { node: Some(node), taken } => self.table.after(node, taken, &values).ok_or_else(|| {
                let by =
                    taken.map_or("an action".to_owned(), |a| format!("`{}`", self.table.shield.actions[a]));
                usage(format!("{state} cannot follow by {by}; `reset` starts an episode"))
            })?,
        };
        *at = At { node: Some(node), taken: None };
        Ok(node)
    }

    /// Returns the number of an action that is given by its name or number.
    fn action(&self, action: &Bound<'_, PyAny>) -> PyResult<usize> {
        let actions = &self.table.shield.actions;
        let found = match action.extract::<String>() {
            Ok(name) => actions.iter().position(|known| *known == name),
            Err(_) => action.extract::<usize>().ok().filter(|number| *number < actions.len()),
        };
        found.ok_or_else(|| {
            usage(format!("there is no action {action}; the actions are {}", actions.join(", ")))
        })
    }
}

fn not_in_scope(state: &Bound<'_, PyAny>) -> PyErr {
    usage(format!("{state} is no state in which an episode may start"))
}

fn read(variable: &ShieldVariable, value: &Bound<'_, PyAny>) -> PyResult<i64> {
    let name = |name: String| {
        let place = variable.values.iter().position(|known| *known == name)?;
        Some(variable.low + i64::try_from(place).ok()?)
    };
    let found = match value.extract::<i64>() {
        _ if variable.boolean != is_bool(value) && !value.is_instance_of::<PyString>() => None,
        Ok(number) => Some(number),
        Err(_) => value.extract::<String>().ok().and_then(name),
    };
    found.ok_or_else(|| usage(format!("`{}` cannot have the value {value}", variable.name)))
}

/// Returns whether a value is a Boolean, of Python or NumPy.
fn is_bool(value: &Bound<'_, PyAny>) -> bool {
    value.is_instance_of::<PyBool>() || value.extract::<bool>().is_ok()
}

#[pymethods]
impl Shield {
    /// `"sasi"` or `"spi"`.
    #[getter]
    fn kind(&self) -> &str {
        &self.table.shield.kind
    }

    /// `"action"` or `"prefix"`.
    #[getter]
    fn safety(&self) -> &str {
        &self.table.shield.safety
    }

    /// The names of the actions, in the order of masks: the labels of the model, then unlabelled
    /// commands, and `deadlock` if the model has deadlocks.
    #[getter]
    fn actions(&self) -> Vec<String> {
        self.table.shield.actions.clone()
    }

    /// Starts an episode in a state, with fresh monitors.
    ///
    /// Raises:
    ///     UsageError: No episode may start in this state: it is not in the scope.
    fn reset(&self, state: &Bound<'_, PyAny>) -> PyResult<()> {
        let values = self.values(state)?;
        let node = self.table.start(&values).ok_or_else(|| not_in_scope(state))?;
        *lock(&self.at) = At { node: Some(node), taken: None };
        Ok(())
    }

    /// Moves to the state that a step led to, also if it is the present state.
    ///
    /// Raises:
    ///     UsageError: No action leads there from the present state.
    fn step(&self, state: &Bound<'_, PyAny>) -> PyResult<()> {
        self.observe(state, true).map(drop)
    }

    /// Returns for each of `actions` if it is permitted: a Boolean array that cannot be written, or a
    /// list if NumPy is not installed.
    ///
    /// Raises:
    ///     UsageError: The state does not follow the present one.
    fn mask(&self, py: Python<'_>, state: &Bound<'_, PyAny>) -> PyResult<Py<PyAny>> {
        Ok(self.table.answer(self.observe(state, false)?).mask.clone_ref(py))
    }

    /// Returns the names of the permitted actions.
    fn allowed(&self, py: Python<'_>, state: &Bound<'_, PyAny>) -> PyResult<Py<PyTuple>> {
        Ok(self.table.answer(self.observe(state, false)?).allowed.clone_ref(py))
    }

    /// Returns the action if it is permitted, else a permitted one that makes progress where there is
    /// one; a name for a name and a number for a number. The next state is the one that this action
    /// led to.
    fn correct<'py>(
        &self,
        py: Python<'py>,
        state: &Bound<'py, PyAny>,
        action: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let asked = self.action(action)?;
        let node = self.observe(state, false)?;
        let of_node = &self.table.shield.nodes[node];
        let is_permitted = self.table.answer(node).flags[asked];
        let taken = if is_permitted { asked } else { of_node.actions[of_node.pick].action };
        lock(&self.at).taken = Some(taken);
        Ok(match (is_permitted, action.is_instance_of::<PyString>()) {
            (true, _) => action.clone(),
            (_, true) => PyString::new(py, &self.table.shield.actions[taken]).into_any(),
            (_, false) => taken.into_pyobject(py)?.into_any(),
        })
    }

    /// Returns True if no permitted step ever weakens from this state on.
    fn secure(&self, state: &Bound<'_, PyAny>) -> PyResult<bool> {
        Ok(self.table.shield.nodes[self.observe(state, false)?].secure)
    }

    /// Returns the number of improvements that the shield still aims for in this state: an int, or
    /// `math.inf`.
    fn ahead<'py>(&self, py: Python<'py>, state: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        Ok(match self.table.shield.nodes[self.observe(state, false)?].ahead {
            Some(level) => level.into_pyobject(py)?.into_any(),
            None => f64::INFINITY.into_pyobject(py)?.into_any(),
        })
    }

    /// Returns the most preferred objectives of the present state.
    fn most_preferred<'py>(&self, state: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyTuple>> {
        let node = &self.table.shield.nodes[self.observe(state, false)?];
        PyTuple::new(state.py(), node.class.map_or(&[][..], |class| &self.table.shield.classes[class]))
    }

    /// Writes the shield into a folder: its table, and a manifest with the hash of the table. An older
    /// shield there is replaced.
    ///
    /// Raises:
    ///     OSError: The folder contains something else, or cannot be written.
    fn save(&self, py: Python<'_>, folder: PathBuf) -> PyResult<()> {
        write_shield(&self.table.shield, &folder).map_err(|error| Failure::of(error).raise(py))
    }

    /// Reads a shield from a folder. Checks the hash, and that the promise follows from the table:
    /// permitted steps of secure states stay in secure states, and weaken nothing.
    ///
    /// Raises:
    ///     Error: The table has changed, or the promise does not follow from it.
    ///     OSError: A file cannot be read.
    #[staticmethod]
    fn load(py: Python<'_>, folder: PathBuf) -> PyResult<Self> {
        let shield = read_shield(&folder).map_err(|error| Failure::of(error).raise(py))?;
        Shield::new(py, shield)
    }

    /// The number of states with memory.
    fn __len__(&self) -> usize {
        self.table.shield.nodes.len()
    }

    fn __repr__(&self) -> String {
        format!("<Shield of {}: {} states with memory>", self.kind(), self.table.shield.nodes.len())
    }

    fn __reduce__(&self) -> PyResult<Py<PyAny>> {
        Err(unpicklable("a Shield", "`save` it to a folder and `load` it"))
    }
}
