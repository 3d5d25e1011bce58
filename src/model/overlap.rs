//! Detection of states in which a `dtmc` selects among several commands. PRISM and Storm warn about
//! it, as does this program.

use super::expr::{Binary, ExprId, ExprPool};
use super::predicate::{Predicate, Predicates};
use super::{CommandId, Program};
use meliora_base::value::Value;

impl Program {
    /// Returns the states in which two choices are enabled.
    ///
    /// The predicate has linear size in the number of commands and small height, because
    /// alternatives are joined in pairs. Two alternatives are enabled if one half has two of them
    /// or each half has one.
    pub fn overlap(&self) -> Predicate {
        let mut predicates = Predicates::over(self);
        let pool = predicates.pool();
        let mut synchronised = Vec::with_capacity(self.synchronisations.len());
        for synchronisation in &self.synchronisations {
            let mut factors = Vec::with_capacity(synchronisation.factors.len());
            for factor in &synchronisation.factors {
                let no = pool.value(Value::Bool(false));
                let alone = |c: &CommandId| Met { one: self.commands[c.index()].guard, two: no };
                factors.push(joined(pool, factor.iter().map(alone).collect(), no, either));
            }
            let yes = pool.value(Value::Bool(true));
            synchronised.push(joined(pool, factors, yes, both));
        }
        let no = pool.value(Value::Bool(false));
        let two = joined(pool, synchronised, no, either).two;
        predicates.get(two)
    }
}

/// Predicates for a group of alternatives: `one` is true if at least one is enabled, `two` if at
/// least two are.
#[derive(Clone, Copy)]
struct Met {
    one: ExprId,
    two: ExprId,
}

/// Joins two groups of alternatives of which one is taken.
fn either(pool: &mut ExprPool, a: Met, b: Met) -> Met {
    let each = pool.binary(Binary::And, a.one, b.one);
    let within = pool.binary(Binary::Or, a.two, b.two);
    let two = pool.binary(Binary::Or, within, each);
    Met { one: pool.binary(Binary::Or, a.one, b.one), two }
}

/// Joins two groups that are combined: an alternative is a pair, one from each group.
fn both(pool: &mut ExprPool, a: Met, b: Met) -> Met {
    let one = pool.binary(Binary::And, a.one, b.one);
    let some = pool.binary(Binary::Or, a.two, b.two);
    Met { one, two: pool.binary(Binary::And, one, some) }
}

/// Joins all groups pair by pair; `unit` is the result for no group.
fn joined(
    pool: &mut ExprPool,
    mut row: Vec<Met>,
    unit: ExprId,
    join: impl Fn(&mut ExprPool, Met, Met) -> Met,
) -> Met {
    while row.len() > 1 {
        let mut next = Vec::with_capacity(row.len().div_ceil(2));
        for pair in row.chunks(2) {
            next.push(if let [a, b] = *pair { join(pool, a, b) } else { pair[0] });
        }
        row = next;
    }
    let two = pool.value(Value::Bool(false));
    row.first().copied().unwrap_or(Met { one: unit, two })
}
