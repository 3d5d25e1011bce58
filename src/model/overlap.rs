//! Where a `dtmc` draws among several commands: PRISM and Storm warn of it, and so do we.

use super::expr::{Binary, ExprId, ExprPool};
use super::value::{EvalError, Value};
use super::{CommandId, Program};

impl Program {
    /// A predicate for the states in which two choices are enabled, put into the program's pool.
    ///
    /// Linear in the number of commands: a choice meets one of those before it, or a factor of a
    /// synchronisation has two commands enabled while all others have one.
    ///
    /// # Errors
    /// None in practice: Boolean operations on guards always have a value.
    pub fn overlap(&mut self) -> Result<ExprId, EvalError> {
        let pool = &mut self.pool;
        let mut some = pool.value(Value::Bool(false));
        let mut two = some;
        for synchronisation in &self.synchronisations {
            let mut all = pool.value(Value::Bool(true));
            let mut twice = pool.value(Value::Bool(false));
            for factor in &synchronisation.factors {
                let guards = factor.iter().map(|c: &CommandId| self.commands[c.index()].guard);
                let (one, more) = seen(pool, guards)?;
                all = pool.binary(Binary::And, all, one)?;
                twice = pool.binary(Binary::Or, twice, more)?;
            }
            let again = pool.binary(Binary::Or, twice, some)?;
            let here = pool.binary(Binary::And, all, again)?;
            two = pool.binary(Binary::Or, two, here)?;
            some = pool.binary(Binary::Or, some, all)?;
        }
        Ok(two)
    }
}

/// One of the guards holds; two of them hold.
fn seen(pool: &mut ExprPool, guards: impl Iterator<Item = ExprId>) -> Result<(ExprId, ExprId), EvalError> {
    let mut one = pool.value(Value::Bool(false));
    let mut two = one;
    for guard in guards {
        let both = pool.binary(Binary::And, one, guard)?;
        two = pool.binary(Binary::Or, two, both)?;
        one = pool.binary(Binary::Or, one, guard)?;
    }
    Ok((one, two))
}
