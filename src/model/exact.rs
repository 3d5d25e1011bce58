//! Exact values of real expressions, as fractions.
//!
//! [`ExprPool::eval`](super::expr::ExprPool::eval) computes with doubles, as PRISM does. Quantities
//! need the model as it is written: `0.1` is one tenth, and `1/3` is a third. The pool therefore
//! keeps a fraction for each real literal, also for those that it folded from others.
//!
//! A literal is the decimal number of its text; without a text, it is the shortest decimal that
//! rounds to its double. `+`, `-`, `*`, `/`, `min`, `max` and powers with a small whole exponent are
//! exact. Logarithms and all other powers are irrational in general: their double is taken as exact.
//!
//! This file and `expr` import each other: the pool folds literals with these operations, and exact
//! evaluation walks its nodes.

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{FromPrimitive, One, Pow, ToPrimitive, Zero};

use super::expr::{ExprId, ExprPool, Node};
use super::value::{self, Binary, EvalError, Type, Unary, Value};
use crate::stack;

/// An exact fraction.
pub type Ratio = BigRational;

/// Largest absolute value of an exponent whose power is computed exactly, decimal exponents
/// included: doubles have exponents below 400.
const LARGEST_EXPONENT: u64 = 1100;

/// Parses a decimal number such as `0.25` or `1.5e-3`; `None` if the text is not one.
pub(crate) fn decimal(text: &str) -> Option<Ratio> {
    let (mantissa, exponent) = match text.split_once(['e', 'E']) {
        Some((mantissa, exponent)) => (mantissa, exponent.parse::<i64>().ok()?),
        None => (text, 0),
    };
    let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
    let digits: BigInt = format!("{whole}{fraction}").parse().ok()?;
    let exponent = exponent.checked_sub(i64::try_from(fraction.len()).ok()?)?;
    if exponent.unsigned_abs() > LARGEST_EXPONENT {
        return None;
    }
    let power = BigInt::from(10).pow(u32::try_from(exponent.unsigned_abs()).ok()?);
    Some(if exponent < 0 { Ratio::new(digits, power) } else { Ratio::from(digits * power) })
}

/// Returns the shortest decimal that rounds to a double; `None` if the double is not finite.
pub(crate) fn shortest(x: f64) -> Option<Ratio> {
    decimal(&format!("{x:e}"))
}

/// Returns the double as a fraction; `None` if it is not finite.
fn double(x: f64) -> Option<Ratio> {
    Ratio::from_f64(x)
}

/// Computes `op x`; `None` if the result is not a real.
pub(super) fn unary(op: Unary, x: &Ratio) -> Option<Ratio> {
    match op {
        Unary::Neg => Some(-x),
        Unary::ToReal => Some(x.clone()),
        Unary::Not | Unary::Floor | Unary::Ceil | Unary::Round => None,
    }
}

/// Computes `x op y` for an operation with a real result; `None` if it has no finite value.
pub(super) fn binary(op: Binary, x: &Ratio, y: &Ratio) -> Option<Ratio> {
    match op {
        Binary::Add => Some(x + y),
        Binary::Sub => Some(x - y),
        Binary::Mul => Some(x * y),
        Binary::Div => (!y.is_zero()).then(|| x / y),
        Binary::Min => Some(x.min(y).clone()),
        Binary::Max => Some(x.max(y).clone()),
        Binary::Pow => power(x, y),
        _ => None,
    }
}

fn power(x: &Ratio, y: &Ratio) -> Option<Ratio> {
    let exponent = y.is_integer().then(|| y.to_integer().to_i64()).flatten();
    match exponent {
        Some(n) if n.unsigned_abs() <= LARGEST_EXPONENT && (n >= 0 || !x.is_zero()) => {
            let power = Pow::pow(x, u32::try_from(n.unsigned_abs()).ok()?);
            Some(if n < 0 { Ratio::one() / power } else { power })
        }
        _ => None,
    }
}

impl ExprPool {
    /// Evaluates an expression of type `int` or `double` exactly. Conditions, and integers such as
    /// `floor(x/3)`, are those of [`ExprPool::eval`].
    ///
    /// # Errors
    /// An operation has no value; [`EvalError::NotAnInteger`] never occurs for reals, so it stands
    /// for a value that is not finite.
    pub fn eval_exact(&self, id: ExprId, state: &[i64]) -> Result<Ratio, EvalError> {
        stack::level(|| self.eval_exact_node(id, state))
    }

    fn eval_exact_node(&self, id: ExprId, state: &[i64]) -> Result<Ratio, EvalError> {
        if self.ty(id) != Type::Real {
            return match self.eval(id, state)? {
                Value::Int(i) => Ok(Ratio::from(BigInt::from(i))),
                _ => Err(EvalError::NotAnInteger),
            };
        }
        let exact = match self.node(id) {
            Node::Literal(_) => self.exact_literal(id).cloned(),
            Node::Unary(op, a) => unary(op, &self.eval_exact(a, state)?),
            Node::Binary(op, a, b) => binary(op, &self.eval_exact(a, state)?, &self.eval_exact(b, state)?),
            Node::Ite(c, a, b) => {
                let branch = if self.eval(c, state)? == Value::Bool(false) { b } else { a };
                Some(self.eval_exact(branch, state)?)
            }
            Node::Var(_) => None,
        };
        match exact {
            Some(exact) => Ok(exact),
            None => double(self.eval(id, state)?.to_f64()).ok_or(EvalError::NotAnInteger),
        }
    }

    /// Returns the exact value of a literal number, if it is finite.
    fn exact_number(&self, id: ExprId) -> Option<Ratio> {
        match self.literal(id)? {
            Value::Int(i) => Some(Ratio::from(BigInt::from(i))),
            Value::Real(_) => self.exact_literal(id).cloned(),
            Value::Bool(_) => None,
        }
    }

    /// Returns the exact value of `op a` on a literal, if it is exact where the double `value` need
    /// not be.
    pub(super) fn folded_unary(&self, op: Unary, a: ExprId, value: Value) -> Option<Ratio> {
        matches!(value, Value::Real(_)).then(|| unary(op, &self.exact_number(a)?))?
    }

    /// Returns the exact value of `a op b` on literals; see [`ExprPool::folded_unary`].
    pub(super) fn folded_binary(&self, op: Binary, a: ExprId, b: ExprId, value: Value) -> Option<Ratio> {
        matches!(value, Value::Real(_)).then(|| binary(op, &self.exact_number(a)?, &self.exact_number(b)?))?
    }
}

/// Returns the exact value of a real literal without a text of its own.
pub(super) fn of_value(value: Value) -> Option<Ratio> {
    match value {
        value::Value::Real(x) => shortest(x),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ratio(numerator: i64, denominator: i64) -> Ratio {
        Ratio::new(numerator.into(), denominator.into())
    }

    #[test]
    fn decimals_are_fractions_of_powers_of_ten() {
        for (text, n, d) in [("0.1", 1, 10), ("1.5e-3", 3, 2000), ("12.50", 25, 2), ("2e3", 2000, 1)] {
            assert_eq!(decimal(text), Some(ratio(n, d)), "{text}");
        }
        for text in ["", "x", "1e", "1e99999", "1e-9223372036854775808", "inf", "NaN"] {
            assert_eq!(decimal(text), None, "{text}");
        }
        assert_eq!(shortest(0.1), Some(ratio(1, 10)));
        assert_eq!(shortest(f64::INFINITY), None);
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
    fn powers_are_exact_for_whole_exponents_only() {
        assert_eq!(power(&ratio(1, 2), &ratio(-3, 1)), Some(ratio(8, 1)));
        assert_eq!(power(&ratio(1, 2), &ratio(1, 2)), None);
        assert_eq!(power(&ratio(0, 1), &ratio(-1, 1)), None);
        assert_eq!(power(&ratio(1, 2), &ratio(i64::MIN, 1)), None);
    }
}
