//! Which commands of a participant need to be looked at in a state.

use super::bounds::Bounds;
use crate::model::expr::{Binary, ExprId, Node, Unary};
use crate::model::value::Value;
use crate::model::{CommandId, Program};

/// Variables with more values than this are no good for a table.
const MOST_ROWS: i128 = 1 << 12;

/// A table by the value of one variable, since most guards ask where their module stands.
pub(super) struct Dispatch {
    /// The variable and its smallest value.
    variable: usize,
    low: i64,
    /// For each value (or for all together) the commands that may be enabled, in order.
    rows: Vec<Vec<u32>>,
}

impl Dispatch {
    /// Tables the commands by the variable that most guards compare with a constant.
    ///
    /// A comparison counts when everything evaluated before it is total: then a guard that is not
    /// looked at would be false, and not without a value.
    pub(super) fn new(program: &Program, bounds: &Bounds, commands: &[CommandId]) -> Self {
        let tests: Vec<Vec<(usize, i64)>> = commands
            .iter()
            .map(|c| {
                let mut found = Vec::new();
                tests(program, bounds, program.commands[c.index()].guard, &mut found);
                found
            })
            .collect();
        let mut votes = vec![0usize; program.variables.len()];
        for &(variable, _) in tests.iter().flatten() {
            votes[variable] += 1;
        }
        let best = (0..votes.len()).filter(|&v| rows(program, v) <= MOST_ROWS).max_by_key(|&v| votes[v]);
        let all = || commands.iter().map(|c| c.0).collect();
        let Some(variable) = best.filter(|&v| votes[v] > 0 && commands.len() > 2) else {
            return Dispatch { variable: 0, low: 0, rows: vec![all()] };
        };
        let declared = &program.variables[variable];
        let candidates = |value: i64| {
            let may = |of: &[(usize, i64)]| of.iter().all(|&(v, c)| v != variable || c == value);
            commands.iter().zip(&tests).filter(|(_, of)| may(of)).map(|(c, _)| c.0).collect()
        };
        let rows = (declared.low..=declared.high).map(candidates).collect();
        Dispatch { variable, low: declared.low, rows }
    }

    /// The commands that may be enabled in a state, in the order of the program.
    #[inline]
    pub(super) fn candidates(&self, values: &[i64]) -> &[u32] {
        match &self.rows[..] {
            [all] => all,
            rows => &rows[values[self.variable].wrapping_sub(self.low) as usize],
        }
    }
}

fn rows(program: &Program, variable: usize) -> i128 {
    let declared = &program.variables[variable];
    i128::from(declared.high) - i128::from(declared.low) + 1
}

/// Collects the conjuncts `variable = constant`; false where the conjunction may have no value.
fn tests(program: &Program, bounds: &Bounds, e: ExprId, found: &mut Vec<(usize, i64)>) -> bool {
    let pool = &program.pool;
    match pool.node(e) {
        Node::Binary(Binary::And, a, b) => {
            tests(program, bounds, a, found) && tests(program, bounds, b, found)
        }
        Node::Binary(Binary::Eq, a, b) => {
            match (pool.node(a), pool.node(b)) {
                (Node::Var(v), Node::Literal(Value::Int(c)))
                | (Node::Literal(Value::Int(c)), Node::Var(v)) => {
                    found.push((v.index(), c));
                }
                _ => {}
            }
            bounds.is_total(e)
        }
        Node::Var(v) => {
            found.push((v.index(), 1));
            true
        }
        Node::Unary(Unary::Not, a) => {
            if let Node::Var(v) = pool.node(a) {
                found.push((v.index(), 0));
            }
            bounds.is_total(e)
        }
        _ => bounds.is_total(e),
    }
}
