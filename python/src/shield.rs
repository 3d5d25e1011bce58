//! Shields.

use std::path::PathBuf;
use std::sync::{Arc, Mutex};

use meliora::export::{read_shield, write_shield};
use meliora::model::State;
use meliora::planning::ShieldVariable;
use meliora::supervise::lock;
use meliora::{Missed, Position, ShieldTable};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyBytes, PyDict, PyList, PyString, PyTuple};

use crate::arrays;
use crate::errors::{Failure, usage};
use crate::values::{self, as_dict};

/// The permitted actions of all states, for an agent that acts step by step. A shield needs no
/// model, and follows levels, references and monitors.
///
/// Promise: where `secure` is True, no step that follows the shield ever weakens, from there on,
/// whatever the environment does, as long as it behaves as the model says. While `ahead` is
/// greater than 0, the permitted actions are those of the permissive strategy of the level: for
/// "sasi", an agent that takes each of them again and again improves almost surely. Where `secure` is
/// False, the permitted actions are those of the strategy or those that the safety mode keeps; if there
/// are none, those that keep the requirements, and all in an unsafe state. An action is permitted only
/// if all choices with its label are, so the promise holds for each of these. Steps are compared as the
/// safety mode says: with "action", with the state before the step; with "prefix", with the reference.
///
/// The shield of a game keeps its promise against every opponent, even one that knows the shield and our
/// next action. In a state of the opponent everything is permitted, and the episode follows its steps.
///
/// An episode starts with `reset`, or with the first state. A call with another state than the
/// present one is a step; a call with the present state is a step only after `correct`, or after
/// `step`. A state is a dictionary, or a sequence of values in the order of the variables (without
/// those of monitors), or a number if there is one variable; 0 and 1 are Booleans, too.
///
/// A shield of `Model.shield` is one by value: an action is permitted if the best probability of a formula after it is
/// within a threshold, or the best one. `values` has these probabilities, `secure` is True where the permitted
/// actions reach the threshold, and `correct` replaces a forbidden action by the best one.
///
/// A shield has one episode, and must not be used by several threads at once; `copy` is cheap.
#[pyclass(frozen, module = "meliora")]
pub(crate) struct Shield {
    table: Arc<ShieldTable>,
    /// The answers for the masks of the table.
    answers: Arc<[Answer]>,
    names: Vec<Py<PyString>>,
    at: Mutex<Position>,
}

impl Shield {
    pub(crate) fn new(py: Python<'_>, shield: meliora::Shield) -> PyResult<Self> {
        let table = ShieldTable::from(shield);
        let answer = |mask: &Vec<bool>| Answer::new(py, &table.shield.actions, mask);
        let answers = table.masks().iter().map(answer).collect::<PyResult<_>>()?;
        let names = table.variables().map(|variable| PyString::new(py, &variable.name).unbind()).collect();
        Ok(Shield { table: Arc::new(table), answers, names, at: Mutex::default() })
    }

    /// Returns the position. The lock is never held while Python runs: the methods of a
    /// state may call this shield.
    fn position(&self) -> Position {
        *lock(&self.at)
    }

    fn state(&self, state: &Bound<'_, PyAny>) -> PyResult<State> {
        let own = self.table.variables();
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
        // Arrays and scalars of NumPy become lists and numbers.
        let list = state.hasattr("tolist")?.then(|| state.call_method0("tolist")).transpose()?;
        let state = list.as_ref().unwrap_or(state);
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

    /// Returns the answer of the node that the episode is in when it observes a state.
    fn answer(&self, state: &Bound<'_, PyAny>) -> PyResult<&Answer> {
        Ok(&self.answers[self.table.mask_of(self.observe(state, false)?)])
    }

    /// Moves to the node of a state. `again` says that the present state is a step, too.
    fn observe(&self, state: &Bound<'_, PyAny>, again: bool) -> PyResult<usize> {
        let values = self.state(state)?;
        let found = self.table.observe(self.position(), &values, again);
        let node = found.map_err(|missed| self.missed(state, &missed))?;
        *lock(&self.at) = Position { node: Some(node), taken: None };
        Ok(node)
    }

    fn missed(&self, state: &Bound<'_, PyAny>, missed: &Missed) -> PyErr {
        let action = |a: usize| format!("`{}`", self.table.shield.actions[a]);
        usage(match missed {
            Missed::Start => format!("{state} is no state in which an episode may start"),
            Missed::Step(taken) => {
                let by = taken.map_or("an action".to_owned(), action);
                format!("{state} cannot follow by {by}; `reset` starts an episode")
            }
        })
    }

    /// Returns the mask of a state without an episode; `memory` is the number of its node.
    fn flags(&self, state: &Bound<'_, PyAny>, memory: Option<usize>) -> PyResult<&[bool]> {
        let values = self.state(state)?;
        let table = &*self.table;
        let Some(node) = memory else {
            return match table.mask_of_state(&values) {
                Some(Some(mask)) => Ok(&table.masks()[mask]),
                Some(None) => Err(usage(format!(
                    "the permitted actions in {state} depend on the memory; give what `memory` returned there"
                ))),
                None => Err(usage(format!("the shield does not know the state {state}"))),
            };
        };
        if node >= table.shield.nodes.len() || !table.is_at(node, &values) {
            return Err(usage(format!("the memory {node} is not one of the state {state}")));
        }
        Ok(&table.masks()[table.mask_of(node)])
    }

    /// Returns a shield with the same table and the same position.
    fn twin(&self, py: Python<'_>) -> Shield {
        let names = self.names.iter().map(|name| name.clone_ref(py)).collect();
        let (table, answers) = (Arc::clone(&self.table), Arc::clone(&self.answers));
        Shield { table, answers, names, at: Mutex::new(self.position()) }
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

fn read(variable: &ShieldVariable, value: &Bound<'_, PyAny>) -> PyResult<i64> {
    let name = |name: String| {
        let place = variable.values.iter().position(|known| *known == name)?;
        Some(variable.low + i64::try_from(place).ok()?)
    };
    let found = match value.extract::<i64>() {
        // Arrays of integers hold Booleans as 0 and 1; an integer is never a Boolean.
        Ok(number) if variable.boolean => (0..=1).contains(&number).then_some(number),
        Ok(_) if is_bool(value) => None,
        Ok(number) => Some(number),
        Err(_) if variable.boolean => value.extract::<bool>().ok().map(i64::from),
        Err(_) => value.extract::<String>().ok().and_then(name),
    };
    found.ok_or_else(|| usage(format!("`{}` cannot have the value {value}", variable.name)))
}

/// Returns whether a value is a Boolean, of Python or NumPy.
fn is_bool(value: &Bound<'_, PyAny>) -> bool {
    value.is_instance_of::<PyBool>() || value.extract::<bool>().is_ok()
}

/// The arguments that restore a pickled shield: the table, the node and the action taken there.
type Pickled<'py> = (Bound<'py, PyBytes>, Option<usize>, Option<usize>);

/// The permitted actions of nodes, as they are returned.
struct Answer {
    allowed: Py<PyTuple>,
    mask: Py<PyAny>,
}

impl Answer {
    fn new(py: Python<'_>, actions: &[String], flags: &[bool]) -> PyResult<Self> {
        let names = actions.iter().zip(flags).filter(|(_, flag)| **flag).map(|(name, _)| name);
        let allowed = PyTuple::new(py, names.collect::<Vec<_>>())?.unbind();
        let mask = match py.import("numpy") {
            Ok(_) => arrays::bools(py, flags, &[flags.len()])?,
            Err(_) => PyList::new(py, flags)?.into_any(),
        };
        if mask.hasattr("setflags")? {
            mask.call_method1("setflags", (false,))?;
        }
        Ok(Answer { allowed, mask: mask.unbind() })
    }
}

#[pymethods]
impl Shield {
    /// `"sasi"`, `"spi"`, `"plan"`, `"achieve"`, or `"safety"` for a shield by value.
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
        let values = self.state(state)?;
        let node = self.table.start(&values).map_err(|missed| self.missed(state, &missed))?;
        *lock(&self.at) = Position { node: Some(node), taken: None };
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
        Ok(self.answer(state)?.mask.clone_ref(py))
    }

    /// Returns masks of many states at once, without an episode, such as those of a replay buffer: a
    /// Boolean array with a row for each state. Needs NumPy.
    ///
    /// Args:
    ///     states: A sequence of states, or an array with a row for each.
    ///     memory: For each state, what `memory` returned when the episode was there. None if the
    ///         permitted actions of these states do not depend on the episode.
    ///
    /// Raises:
    ///     UsageError: The shield does not know a state; without `memory`, the permitted actions of a
    ///         state depend on the episode; with it, a number is not one of its state.
    #[pyo3(signature = (states, memory=None))]
    fn masks<'py>(
        &self,
        py: Python<'py>,
        states: &Bound<'py, PyAny>,
        memory: Option<Vec<usize>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let list = states.hasattr("tolist")?.then(|| states.call_method0("tolist")).transpose()?;
        let (mut flags, mut rows) = (Vec::new(), 0);
        for state in list.as_ref().unwrap_or(states).try_iter()? {
            let node = match &memory {
                None => None,
                Some(memory) => {
                    Some(*memory.get(rows).ok_or_else(|| usage("`memory` is shorter than `states`"))?)
                }
            };
            flags.extend_from_slice(self.flags(&state?, node)?);
            rows += 1;
        }
        if memory.is_some_and(|memory| memory.len() > rows) {
            return Err(usage("`memory` is longer than `states`"));
        }
        arrays::bools(py, &flags, &[rows, self.table.shield.actions.len()])
    }

    /// Returns the number of the state with the memory of the episode, for `masks`.
    ///
    /// Raises:
    ///     UsageError: The state does not follow the present one.
    fn memory(&self, state: &Bound<'_, PyAny>) -> PyResult<usize> {
        self.observe(state, false)
    }

    /// Returns the names of the permitted actions.
    fn allowed(&self, py: Python<'_>, state: &Bound<'_, PyAny>) -> PyResult<Py<PyTuple>> {
        Ok(self.answer(state)?.allowed.clone_ref(py))
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
        let taken = self.table.correct(node, asked);
        lock(&self.at).taken = Some(taken);
        Ok(match (taken == asked, action.is_instance_of::<PyString>()) {
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

    /// Returns the objectives that the shield pursues in this state, together if there are several: with
    /// permitted actions they stay sure.
    fn pursues<'py>(&self, state: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(state.py(), &self.table.shield.nodes[self.observe(state, false)?].pursues)
    }

    /// Returns True if the pursued objectives are achieved or, for those that no step achieves, kept from
    /// here on.
    fn achieved(&self, state: &Bound<'_, PyAny>) -> PyResult<bool> {
        Ok(self.table.shield.nodes[self.observe(state, false)?].achieved)
    }

    /// Returns the most preferred objectives of the present state.
    fn most_preferred<'py>(&self, state: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyTuple>> {
        let node = &self.table.shield.nodes[self.observe(state, false)?];
        PyTuple::new(state.py(), node.class.map_or(&[][..], |class| &self.table.shield.classes[class]))
    }

    /// The rule of a shield by value: its property, `maximises` for `Pmax`, the threshold, and whether that is `relative` to
    /// the best action; None for the shield of a strategy.
    #[getter]
    fn rule(&self, py: Python<'_>) -> PyResult<Option<Py<PyAny>>> {
        let rule = self.table.shield.rule.as_ref();
        rule.map(|rule| values::plain(py, serde_json::to_string(rule))).transpose()
    }

    /// Returns the bounds of the value of each enabled action in this state, by name: the best probability of the formula
    /// after it.
    ///
    /// Raises:
    ///     UsageError: The shield is not one by value.
    fn values<'py>(&self, py: Python<'py>, state: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyDict>> {
        let node = &self.table.shield.nodes[self.observe(state, false)?];
        let found = PyDict::new(py);
        for action in &node.actions {
            let [lower, upper] =
                action.value.ok_or_else(|| usage("the shield of a strategy has no values"))?;
            found.set_item(&self.table.shield.actions[action.action], (lower, upper))?;
        }
        Ok(found)
    }

    /// Writes the shield into a folder: its table, and a manifest with the hash of the table. An older
    /// shield there is replaced.
    ///
    /// Raises:
    ///     OSError: The folder contains something else, or cannot be written.
    fn save(&self, py: Python<'_>, folder: PathBuf) -> PyResult<()> {
        write_shield(&self.table.shield, &folder).map_err(|error| Failure::of(error).raise(py))
    }

    /// Reads a shield from a folder. Checks the hash, and that the promises follow from the table:
    /// every step is known, permitted steps of secure states stay in secure states and weaken nothing,
    /// and permitted steps can make the improvements that are ahead. Nothing occurs twice.
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

    /// Returns a shield with the same table and an episode of its own, for another environment. The
    /// episode is where this one is.
    fn copy(&self, py: Python<'_>) -> Shield {
        self.twin(py)
    }

    fn __copy__(&self, py: Python<'_>) -> Shield {
        self.twin(py)
    }

    fn __deepcopy__(&self, py: Python<'_>, _memo: &Bound<'_, PyAny>) -> Shield {
        self.twin(py)
    }

    /// Pickles the table and the position of the episode.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Pickled<'py>)> {
        let table = serde_json::to_vec(&self.table.shield).map_err(|e| usage(e.to_string()))?;
        let Position { node, taken } = self.position();
        let restore = py.get_type::<Shield>().getattr("_restore")?;
        Ok((restore, (PyBytes::new(py, &table), node, taken)))
    }

    #[staticmethod]
    fn _restore(py: Python<'_>, table: &[u8], node: Option<usize>, taken: Option<usize>) -> PyResult<Self> {
        let damaged = |fault: String| usage(format!("the pickled shield is damaged: {fault}"));
        let shield: meliora::Shield = serde_json::from_slice(table).map_err(|e| damaged(e.to_string()))?;
        shield.fault().map_or(Ok(()), |fault| Err(damaged(fault)))?;
        let is_known = |number: Option<usize>, count: usize| number.is_none_or(|number| number < count);
        if !is_known(node, shield.nodes.len()) || !is_known(taken, shield.actions.len()) {
            return Err(damaged("a number is out of range".to_owned()));
        }
        let shield = Shield::new(py, shield)?;
        *lock(&shield.at) = Position { node, taken };
        Ok(shield)
    }
}
