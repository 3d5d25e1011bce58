//! Decision trees over the values of states.
//!
//! States are sorted by their values. A tree splits a range of the sorted states at a value of the
//! first variable that differs, near the middle of the range. The height of trees is therefore about
//! the logarithm of the number of states, plus the number of variables. Equal parts are shared by
//! the pool of expressions.

use super::Column;
use meliora_base::error::{Limit, Result};
use meliora_base::progress::Poll;
use meliora_base::value::{Type, Value};
use meliora_model::VarId;
use meliora_model::expr::{Binary, ExprId, ExprPool};

/// Maximum height of a tree.
const MOST_HEIGHT: usize = 1_000;

/// Builds trees over sorted states.
pub(super) struct Trees<'t> {
    pub(super) pool: &'t mut ExprPool,
    columns: &'t [Column],
    /// The states, sorted by their values.
    pub(super) sorted: Vec<usize>,
}

/// A position in the sorted states, with a value.
pub(super) type Leaf = (usize, ExprId);

/// Values of a variable with equal conditions on the variables after it.
struct ValueRange {
    low: i64,
    high: i64,
    rest: ExprId,
}

/// Sorts the states by their values. Returns `None` if two states have the same values.
pub(super) fn sorted(columns: &[Column], states: usize, poll: &mut Poll<'_>) -> Result<Option<Vec<usize>>> {
    let values = |state: usize| columns.iter().map(move |c| c.values[state]);
    let mut sorted: Vec<usize> = (0..states).collect();
    sorted.sort_unstable_by(|&a, &b| values(a).cmp(values(b)));
    for pair in sorted.windows(2) {
        poll.step()?;
        if values(pair[0]).eq(values(pair[1])) {
            return Ok(None);
        }
    }
    Ok(Some(sorted))
}

impl<'t> Trees<'t> {
    pub(super) fn new(pool: &'t mut ExprPool, columns: &'t [Column], sorted: Vec<usize>) -> Self {
        Trees { pool, columns, sorted }
    }

    /// Returns the value of a variable at a position.
    pub(super) fn at(&self, column: usize, position: usize) -> i64 {
        self.columns[column].values[self.sorted[position]]
    }

    /// Returns a literal of a value of a variable.
    pub(super) fn literal(&mut self, column: usize, value: i64) -> ExprId {
        self.pool.value(match self.columns[column].ty {
            Type::Bool => Value::Bool(value != 0),
            _ => Value::Int(value),
        })
    }

    /// Returns an expression with the value of each leaf in its state, and any of them in the
    /// states between. `leaves` are sorted and not empty.
    ///
    /// # Errors
    /// The tree is too high; a limit.
    pub(super) fn select(&mut self, leaves: &[Leaf], poll: &mut Poll<'_>) -> Result<ExprId> {
        self.select_from(leaves, 0, 0, poll)
    }

    fn select_from(
        &mut self,
        leaves: &[Leaf],
        mut column: usize,
        height: usize,
        poll: &mut Poll<'_>,
    ) -> Result<ExprId> {
        poll.step()?;
        let (first, last) = (leaves[0], leaves[leaves.len() - 1]);
        if leaves.iter().all(|leaf| leaf.1 == first.1) {
            return Ok(first.1);
        }
        too_high(height)?;
        // Sorted states that differ do so in some variable.
        while self.at(column, first.0) == self.at(column, last.0) {
            column += 1;
        }
        let (low, middle) = (self.at(column, first.0), self.at(column, leaves[leaves.len() / 2].0));
        let bound = if middle == low { low } else { middle - 1 };
        let cut = leaves.partition_point(|leaf| self.at(column, leaf.0) <= bound);
        let below = self.select_from(&leaves[..cut], column, height + 1, poll)?;
        let above = self.select_from(&leaves[cut..], column, height + 1, poll)?;
        Ok(self.split(column, bound, below, above))
    }

    /// Returns `column <= bound ? below : above`.
    fn split(&mut self, column: usize, bound: i64, below: ExprId, above: ExprId) -> ExprId {
        let variable = self.variable(column);
        if self.columns[column].ty == Type::Bool {
            return self.pool.ite(variable, above, below);
        }
        let bound = self.pool.value(Value::Int(bound));
        let condition = self.pool.binary(Binary::Le, variable, bound);
        self.pool.ite(condition, below, above)
    }

    fn variable(&mut self, column: usize) -> ExprId {
        let id = VarId(u32::try_from(column).unwrap_or(u32::MAX));
        self.pool.var(id, self.columns[column].ty)
    }

    /// Returns a condition that is true exactly in the states at these positions, which are sorted.
    ///
    /// # Errors
    /// The tree is too high; a limit.
    pub(super) fn member(&mut self, positions: &[usize], poll: &mut Poll<'_>) -> Result<ExprId> {
        if positions.is_empty() {
            return Ok(self.pool.value(Value::Bool(false)));
        }
        self.member_from(positions, 0, poll)
    }

    fn member_from(&mut self, positions: &[usize], column: usize, poll: &mut Poll<'_>) -> Result<ExprId> {
        poll.step()?;
        let Some(Column { low, high, .. }) = self.columns.get(column) else {
            return Ok(self.pool.value(Value::Bool(true)));
        };
        too_high(column)?;
        let (low, high) = (*low, *high);
        let mut ranges: Vec<ValueRange> = Vec::new();
        let mut left = positions;
        while let Some(&first) = left.first() {
            let value = self.at(column, first);
            let (equal, others) = left.split_at(left.partition_point(|&p| self.at(column, p) == value));
            left = others;
            let rest = self.member_from(equal, column + 1, poll)?;
            match ranges.last_mut() {
                Some(range) if range.rest == rest && range.high + 1 == value => range.high = value,
                _ => ranges.push(ValueRange { low: value, high: value, rest }),
            }
        }
        Ok(self.pick(column, &ranges, (low, high)))
    }

    /// Returns the condition of one of the ranges; the variable is known to be in a range.
    fn pick(&mut self, column: usize, ranges: &[ValueRange], (low, high): (i64, i64)) -> ExprId {
        if let [range] = ranges {
            let within = self.range(column, (range.low, range.high), (low, high));
            return self.pool.binary(Binary::And, within, range.rest);
        }
        let (before, after) = ranges.split_at(ranges.len() / 2);
        let bound = after[0].low - 1;
        let below = self.pick(column, before, (low, bound));
        let above = self.pick(column, after, (bound + 1, high));
        self.split(column, bound, below, above)
    }

    /// Returns the condition that a variable is in a range, given that it is in a larger one.
    fn range(&mut self, column: usize, (low, high): (i64, i64), known: (i64, i64)) -> ExprId {
        let variable = self.variable(column);
        if (low, high) == known {
            return self.pool.value(Value::Bool(true));
        }
        let [from, to] = [low, high].map(|v| self.literal(column, v));
        if low == high {
            return self.pool.binary(Binary::Eq, variable, from);
        }
        let always = self.pool.value(Value::Bool(true));
        let from = if low > known.0 { self.pool.binary(Binary::Le, from, variable) } else { always };
        let to = if high < known.1 { self.pool.binary(Binary::Le, variable, to) } else { always };
        self.pool.binary(Binary::And, from, to)
    }
}

fn too_high(height: usize) -> Result<()> {
    if height < MOST_HEIGHT {
        return Ok(());
    }
    let what = format!("a decision tree over the values of the states has more than {MOST_HEIGHT} levels");
    Err(Limit::Size { what }.into())
}
