//! A model as a list of states with their choices.

use meliora_base::error::{Limit, Result};

/// A model with an explicit list of states.
#[derive(Debug, Clone, PartialEq)]
pub struct Graph {
    /// True for a Markov chain: every state has one choice, and choices have no names.
    pub is_dtmc: bool,
    /// The players of a game.
    pub players: Option<Players>,
    /// The variables of the states.
    pub columns: Vec<Column>,
    /// The values of each state.
    pub states: Vec<Vec<i64>>,
    /// The choices of each state; at least one.
    pub rows: Vec<Vec<Row>>,
    /// The numbers of the initial states, in ascending order.
    pub initial: Vec<usize>,
    /// Names of labels, each with the numbers of its states in ascending order.
    pub labels: Vec<(String, Vec<usize>)>,
}

/// The players of a game.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Players {
    /// Their names.
    pub names: Vec<String>,
    /// The player of each state, 0 for a deadlock.
    pub owners: Vec<usize>,
}

/// A variable as a column of values.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Column {
    /// Its name.
    pub name: String,
    /// True if the values 0 and 1 stand for `false` and `true`.
    pub is_bool: bool,
    /// The smallest and the largest value, if they are declared.
    pub range: Option<(i64, i64)>,
}

impl Column {
    /// Formats a value as PRISM does.
    pub(crate) fn show(&self, value: i64) -> String {
        if self.is_bool { (value != 0).to_string() } else { value.to_string() }
    }
}

/// A choice of a state.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// The name of its action.
    pub action: String,
    /// The successors with their probabilities, each successor once.
    pub successors: Vec<(usize, f64)>,
}

impl Graph {
    /// Returns the number of choices over all states.
    pub fn choices(&self) -> usize {
        self.rows.iter().map(Vec::len).sum()
    }

    /// Returns the number of transitions over all choices.
    pub fn transitions(&self) -> usize {
        self.rows.iter().flatten().map(|row| row.successors.len()).sum()
    }
}

/// Returns the error of the limit on states, if one more state would exceed it.
pub(super) fn fits(states: usize, limit: usize) -> Result<()> {
    if states < limit {
        return Ok(());
    }
    Err(Limit::Listed(limit as u64).into())
}
