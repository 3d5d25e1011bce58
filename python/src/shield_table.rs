//! The table of a shield with indices, and positions in it. Nothing here calls Python but
//! [`Answer`], so a position can be locked while it moves.

use std::collections::HashMap;
use std::sync::OnceLock;

use meliora::model::State;
use meliora::planning::{ShieldNode, ShieldVariable};
use pyo3::prelude::*;
use pyo3::types::{PyList, PyTuple};

use crate::arrays;

/// A shield with indices and results that are ready to return.
pub(crate) struct Table {
    pub(crate) shield: meliora::Shield,
    starts: HashMap<State, usize>,
    /// For each node, a position in `answers`.
    answer_of: Vec<usize>,
    answers: Vec<Answer>,
    /// For each state as an agent sees it, the answer of its nodes; `None` if they have several.
    of_states: OnceLock<HashMap<State, Option<usize>>>,
}

/// The permitted actions of nodes, as they are returned.
pub(crate) struct Answer {
    pub(crate) allowed: Py<PyTuple>,
    pub(crate) mask: Py<PyAny>,
    pub(crate) flags: Vec<bool>,
}

/// The position of an episode.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct At {
    pub(crate) node: Option<usize>,
    /// The action that was taken in the node.
    pub(crate) taken: Option<usize>,
}

/// The reason why an episode cannot go on in a state.
pub(crate) enum Missed {
    /// Episodes do not start in the state.
    Start,
    /// The action, or no action if it is not known, does not lead to the state.
    Step(Option<usize>),
}

impl Table {
    pub(crate) fn new(py: Python<'_>, shield: meliora::Shield) -> PyResult<Self> {
        let starts = shield.nodes[..shield.starts].iter().enumerate();
        let starts = starts.map(|(v, node)| (node.state.clone(), v)).collect();
        let (answer_of, answers, of_states) = (Vec::new(), Vec::new(), OnceLock::new());
        let mut table = Table { shield, starts, answer_of, answers, of_states };
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

    pub(crate) fn answer(&self, node: usize) -> &Answer {
        &self.answers[self.answer_of[node]]
    }

    /// Returns the variables that an agent knows: those of the model.
    pub(crate) fn variables(&self) -> impl Iterator<Item = &ShieldVariable> {
        self.shield.variables.iter().filter(|variable| variable.monitor.is_none())
    }

    /// Returns the values of a node's state without those of monitors.
    pub(crate) fn shown(&self, node: usize) -> impl Iterator<Item = i64> {
        let all = self.shield.variables.iter().zip(&self.shield.nodes[node].state);
        all.filter(|(variable, _)| variable.monitor.is_none()).map(|(_, value)| *value)
    }

    pub(crate) fn start(&self, values: &[i64]) -> Result<usize, Missed> {
        let mut values = values.iter();
        let of = |variable: &ShieldVariable| variable.monitor.or_else(|| values.next().copied());
        let state: Option<State> = self.shield.variables.iter().map(of).collect();
        state.and_then(|state| self.starts.get(&state).copied()).ok_or(Missed::Start)
    }

    /// Returns the node that an episode is in when it observes a state. `again` says that the present
    /// state is a step, too.
    pub(crate) fn observe(&self, at: At, values: &[i64], again: bool) -> Result<usize, Missed> {
        let Some(node) = at.node else { return self.start(values) };
        let stays = at.taken.is_none() && !again;
        if stays && self.shown(node).eq(values.iter().copied()) {
            return Ok(node);
        }
        self.after(node, at.taken, values).ok_or(Missed::Step(at.taken))
    }

    /// Returns the node that a step enters.
    fn after(&self, at: usize, taken: Option<usize>, values: &[i64]) -> Option<usize> {
        let actions = &self.shield.nodes[at].actions;
        let possible = actions.iter().filter(|action| taken.is_none_or(|taken| action.action == taken));
        let mut next = possible.flat_map(|action| &action.next).copied();
        next.find(|&to| self.shown(to).eq(values.iter().copied()))
    }

    /// Returns the answer of all nodes with a state; `None` if no node has it, and `Some(None)` if
    /// their answers differ.
    pub(crate) fn answer_of_state(&self, values: &[i64]) -> Option<Option<&Answer>> {
        let of_states = self.of_states.get_or_init(|| {
            let mut all = HashMap::new();
            for (node, &answer) in self.answer_of.iter().enumerate() {
                let known = all.entry(self.shown(node).collect()).or_insert(Some(answer));
                *known = known.filter(|&known| known == answer);
            }
            all
        });
        of_states.get(values).map(|answer| answer.map(|answer| &self.answers[answer]))
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
