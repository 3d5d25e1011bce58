//! A model as a list of states with their choices.

use crate::error::{Limit, Result};

/// A model state by state.
#[derive(Debug, Clone, PartialEq)]
pub struct Graph {
    /// Every state has one choice, and choices have no names.
    pub is_dtmc: bool,
    /// What the values of states are of.
    pub columns: Vec<Column>,
    /// The values of each state.
    pub states: Vec<Vec<i64>>,
    /// The choices of each state; at least one.
    pub rows: Vec<Vec<Row>>,
    /// The numbers of the initial states, in ascending order.
    pub initial: Vec<usize>,
    /// Names with the numbers of the states that have them, in ascending order.
    pub labels: Vec<(String, Vec<usize>)>,
}

/// A variable as a column of values.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Column {
    /// Its name.
    pub name: String,
    /// Its values 0 and 1 stand for `false` and `true`.
    pub is_bool: bool,
}

impl Column {
    /// A value as PRISM writes it.
    pub fn show(&self, value: i64) -> String {
        if self.is_bool { (value != 0).to_string() } else { value.to_string() }
    }
}

/// A choice of a state.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Its name.
    pub action: String,
    /// Each successor once, with its probability.
    pub successors: Vec<(usize, f64)>,
}

impl Graph {
    /// How many choices all states have together.
    pub fn choices(&self) -> usize {
        self.rows.iter().map(Vec::len).sum()
    }

    /// How many successors all choices have together.
    pub fn transitions(&self) -> usize {
        self.rows.iter().flatten().map(|row| row.successors.len()).sum()
    }
}

/// The limit on states as an error, where a state would be one too many.
pub(super) fn fits(states: usize, limit: usize) -> Result<()> {
    if states < limit {
        return Ok(());
    }
    Err(Limit::Listed(limit as u64).into())
}
