//! Exact values of expressions.
//!
//! Values are decided by the model as it is written: `0.1` is one tenth, `1/3` is a third, and
//! `0.1+0.2` equals `0.3`. The pool therefore keeps the fraction of each real literal, also of those
//! that it folded from others, and evaluation computes with fractions ([`meliora_base::real`]).
//!
//! A literal is the decimal number of its text; without a text, it is the shortest decimal that
//! rounds to its double.

use ahash::AHashMap;

use crate::expr::{ExprId, ExprPool, Node};
use meliora_base::exact::{self, Exact, Ratio, Real, binary, unary};
use meliora_base::stack;
use meliora_base::value::{Binary, EvalError, Type, Value};

/// Maximum number of operators, counted once per use, of an expression whose parts are not
/// remembered.
const MOST_OPERATORS: u32 = 1 << 12;

/// The evaluation of an expression in a state.
struct Evaluation<'p> {
    pool: &'p ExprPool,
    state: &'p [i64],
    /// The values of parts, if they are remembered.
    known: Option<AHashMap<ExprId, Result<Exact, EvalError>>>,
}

impl Evaluation<'_> {
    fn value(&mut self, id: ExprId) -> Result<Exact, EvalError> {
        match self.pool.node(id) {
            Node::Literal(v) => Ok(self.pool.exact_of(id, v)),
            Node::Var(v) => Ok(match self.pool.ty(id) {
                Type::Bool => Exact::Bool(self.state[v.index()] != 0),
                _ => Exact::Int(self.state[v.index()]),
            }),
            // A leaf needs no stack.
            node => stack::level(|| self.remembered(id, node)),
        }
    }

    fn remembered(&mut self, id: ExprId, node: Node) -> Result<Exact, EvalError> {
        if let Some(value) = self.known.as_ref().and_then(|known| known.get(&id)) {
            return value.clone();
        }
        let value = self.computed(node);
        if let Some(known) = &mut self.known {
            known.insert(id, value.clone());
        }
        value
    }

    fn computed(&mut self, node: Node) -> Result<Exact, EvalError> {
        match node {
            Node::Unary(op, a) => unary(op, self.value(a)?),
            Node::Binary(op, a, b) => {
                let x = self.value(a)?;
                match (op, &x) {
                    (Binary::And, Exact::Bool(false)) | (Binary::Or, Exact::Bool(true)) => Ok(x),
                    _ => binary(op, &x, &self.value(b)?),
                }
            }
            Node::Ite(c, a, b) => match self.value(c)? {
                Exact::Bool(false) => self.value(b),
                _ => self.value(a),
            },
            Node::Literal(_) | Node::Var(_) => Err(EvalError::NotAnInteger),
        }
    }
}

/// A value that is not a real.
#[derive(Debug, Clone, Copy)]
enum Plain {
    Bool(bool),
    Int(i64),
}

impl Plain {
    fn new(value: &Exact) -> Option<Plain> {
        match *value {
            Exact::Bool(b) => Some(Plain::Bool(b)),
            Exact::Int(i) => Some(Plain::Int(i)),
            Exact::Real(_) => None,
        }
    }
}

impl From<Plain> for Exact {
    fn from(value: Plain) -> Self {
        match value {
            Plain::Bool(b) => Exact::Bool(b),
            Plain::Int(i) => Exact::Int(i),
        }
    }
}

impl ExprPool {
    /// Evaluates `id` in a state; see [`ExprPool::eval`]. An expression whose parts are shared is
    /// evaluated part by part, each once.
    ///
    /// # Errors
    /// An operation has no value, for example an overflow or `mod` by zero.
    pub fn exact(&self, id: ExprId, state: &[i64]) -> Result<Exact, EvalError> {
        let is_long = self.operators(id) > MOST_OPERATORS;
        if !is_long && let Some(value) = self.plain(id, state) {
            return Ok(value.into());
        }
        Evaluation { pool: self, state, known: is_long.then(AHashMap::new) }.value(id)
    }

    /// Evaluates an expression without reals, as [`Evaluation::value`] does; `None` if it has a real part
    /// that is needed, or no value. Guards are evaluated in each state that is explained or simulated, and
    /// moving fractions around takes most of the time of an [`Evaluation`].
    fn plain(&self, id: ExprId, state: &[i64]) -> Option<Plain> {
        match self.node(id) {
            Node::Literal(Value::Bool(b)) => Some(Plain::Bool(b)),
            Node::Literal(Value::Int(i)) => Some(Plain::Int(i)),
            Node::Literal(Value::Real(_)) => None,
            Node::Var(v) => Some(match self.ty(id) {
                Type::Bool => Plain::Bool(state[v.index()] != 0),
                _ => Plain::Int(state[v.index()]),
            }),
            node => stack::level(|| self.plain_of(node, state)),
        }
    }

    fn plain_of(&self, node: Node, state: &[i64]) -> Option<Plain> {
        let value = |id| self.plain(id, state);
        let found = match node {
            Node::Unary(op, a) => unary(op, value(a)?.into()).ok()?,
            Node::Binary(op, a, b) => match (op, value(a)?) {
                (Binary::And, Plain::Bool(false)) => Exact::Bool(false),
                (Binary::Or, Plain::Bool(true)) => Exact::Bool(true),
                (op, Plain::Bool(a)) => match value(b)? {
                    Plain::Bool(b) => exact::logical(op, a, b),
                    Plain::Int(_) => return None,
                },
                (op, Plain::Int(a)) => match value(b)? {
                    Plain::Int(b) => exact::whole(op, a, b).ok()??,
                    Plain::Bool(_) => return None,
                },
            },
            Node::Ite(c, a, b) => match value(c)? {
                Plain::Bool(false) => return value(b),
                _ => return value(a),
            },
            Node::Literal(_) | Node::Var(_) => return None,
        };
        Plain::new(&found)
    }

    /// Evaluates a number exactly.
    ///
    /// # Errors
    /// An operation has no value, or the number is not finite.
    pub fn eval_exact(&self, id: ExprId, state: &[i64]) -> Result<Ratio, EvalError> {
        match self.exact(id, state)?.into_real() {
            Real::Finite(exact) => Ok(exact),
            Real::Infinite(_) | Real::Undefined => Err(EvalError::NotFinite),
        }
    }

    /// Returns the exact value if `id` is a literal.
    pub fn exact_literal(&self, id: ExprId) -> Option<Exact> {
        self.literal(id).map(|v| self.exact_of(id, v))
    }

    fn exact_of(&self, id: ExprId, v: Value) -> Exact {
        match v {
            Value::Bool(b) => Exact::Bool(b),
            Value::Int(i) => Exact::Int(i),
            Value::Real(x) => Exact::Real(
                self.fraction(id).map_or_else(|| Real::from(x), |exact| Real::Finite(exact.clone())),
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use meliora_base::value::Unary;

    fn ratio(numerator: i64, denominator: i64) -> Ratio {
        Ratio::new(numerator.into(), denominator.into())
    }

    #[test]
    fn literals_that_are_folded_stay_exact() {
        let mut pool = ExprPool::default();
        let [one, three] = [1.0, 3.0].map(|x| pool.value(Value::Real(x)));
        let third = pool.binary(Binary::Div, one, three);
        let rounded = pool.value(Value::Real(1.0 / 3.0));
        assert_eq!(pool.eval_exact(third, &[]), Ok(ratio(1, 3)));
        assert_ne!(pool.eval_exact(rounded, &[]), Ok(ratio(1, 3)));
        let whole = pool.binary(Binary::Mul, third, three);
        assert_eq!(pool.eval_exact(whole, &[]), Ok(ratio(1, 1)));
        assert_eq!(pool.literal(whole), Some(Value::Real(1.0)));
    }

    #[test]
    fn comparisons_and_rounding_are_exact() {
        let mut pool = ExprPool::default();
        let [a, b, c] = [0.1, 0.2, 0.3].map(|x| pool.value(Value::Real(x)));
        let sum = pool.binary(Binary::Add, a, b);
        let equal = pool.binary(Binary::Eq, sum, c);
        assert_eq!(pool.literal(equal), Some(Value::Bool(true)));
        let ten = pool.value(Value::Real(10.0));
        let tenfold = pool.binary(Binary::Mul, sum, ten);
        let ceiling = pool.unary(Unary::Ceil, tenfold);
        assert_eq!(pool.literal(ceiling), Some(Value::Int(3)));
    }
}
