//! Where a `dtmc` draws among several commands: PRISM and Storm warn of it, and so do we.

use super::expr::{Binary, ExprId, ExprPool};
use super::value::Value;
use super::{CommandId, Program};

impl Program {
    /// A predicate for the states in which two choices are enabled, put into the program's pool.
    ///
    /// Linear in the number of commands, and of small height: alternatives are joined in pairs, and
    /// two hold where one half has two of them, or each half has one.
    pub fn overlap(&mut self) -> ExprId {
        let pool = &mut self.pool;
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
        joined(pool, synchronised, no, either).two
    }
}

/// Where one of some alternatives is there at least, and where two are.
#[derive(Clone, Copy)]
struct Met {
    one: ExprId,
    two: ExprId,
}

/// Of two lots of alternatives: those of either.
fn either(pool: &mut ExprPool, a: Met, b: Met) -> Met {
    let each = pool.binary(Binary::And, a.one, b.one);
    let within = pool.binary(Binary::Or, a.two, b.two);
    let two = pool.binary(Binary::Or, within, each);
    Met { one: pool.binary(Binary::Or, a.one, b.one), two }
}

/// Of two lots that combine: a pair is an alternative.
fn both(pool: &mut ExprPool, a: Met, b: Met) -> Met {
    let one = pool.binary(Binary::And, a.one, b.one);
    let some = pool.binary(Binary::Or, a.two, b.two);
    Met { one, two: pool.binary(Binary::And, one, some) }
}

/// All lots joined pair by pair; `unit` holds where none is needed.
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
