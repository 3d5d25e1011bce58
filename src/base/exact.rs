//! Exact values, and the operations on them.

pub use super::decimal::{NoDecimal, decimal, shortest};
pub use super::real::{Ratio, Real};
use super::value::{self, Binary, EvalError, Type, Unary, Value};

/// The exact value of an expression.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum Exact {
    /// A truth value.
    Bool(bool),
    /// An integer.
    Int(i64),
    /// A real.
    Real(Real),
}

impl Exact {
    /// Returns the value as a real; Booleans count as 0 and 1.
    pub fn into_real(self) -> Real {
        match self {
            Exact::Bool(b) => Real::from(b),
            Exact::Int(i) => Real::from(i),
            Exact::Real(x) => x,
        }
    }

    /// Returns the value; a real becomes the nearest double.
    pub fn rounded(&self) -> Value {
        match self {
            Exact::Bool(b) => Value::Bool(*b),
            Exact::Int(i) => Value::Int(*i),
            Exact::Real(x) => Value::Real(x.to_f64()),
        }
    }

    /// Returns the type of the value.
    pub fn ty(&self) -> Type {
        match self {
            Exact::Bool(_) => Type::Bool,
            Exact::Int(_) => Type::Int,
            Exact::Real(_) => Type::Real,
        }
    }
}

/// Computes `op x`.
///
/// # Errors
/// The operation has no value; see [`EvalError`].
pub fn unary(op: Unary, x: Exact) -> Result<Exact, EvalError> {
    Ok(match (op, x) {
        (Unary::Not, Exact::Bool(b)) => Exact::Bool(!b),
        (Unary::Not, x) => Exact::Bool(x.into_real().is_zero()),
        (Unary::Neg, Exact::Int(i)) => Exact::Int(i.checked_neg().ok_or(EvalError::Overflow)?),
        (Unary::Neg, x) => Exact::Real(x.into_real().negated()),
        (Unary::Floor | Unary::Ceil | Unary::Round, Exact::Int(i)) => Exact::Int(i),
        (Unary::Floor | Unary::Ceil | Unary::Round, x) => Exact::Int(x.into_real().whole(op)?),
        (Unary::ToReal, x) => Exact::Real(x.into_real()),
    })
}

/// Computes `x op y`. On reals, `=` compares numbers: an undefined one equals nothing.
///
/// # Errors
/// The operation has no value; see [`EvalError`].
pub fn binary(op: Binary, x: &Exact, y: &Exact) -> Result<Exact, EvalError> {
    let known = match (x, y) {
        (Exact::Bool(a), Exact::Bool(b)) => Some(value::logical(op, *a, *b)),
        (Exact::Int(a), Exact::Int(b)) => value::whole(op, *a, *b)?,
        _ => None,
    };
    match known {
        Some(value) => Ok(value),
        None => reals(op, &x.clone().into_real(), &y.clone().into_real()),
    }
}

/// Computes `x op y` on reals.
///
/// # Errors
/// See [`binary`].
pub fn reals(op: Binary, x: &Real, y: &Real) -> Result<Exact, EvalError> {
    Ok(match op {
        Binary::Lt => Exact::Bool(x.compare(y).is_some_and(|order| order.is_lt())),
        Binary::Le => Exact::Bool(x.compare(y).is_some_and(|order| order.is_le())),
        Binary::Eq | Binary::And | Binary::Or => Exact::Bool(x.compare(y).is_some_and(|order| order.is_eq())),
        _ => Exact::Real(Real::combine(op, x, y)?),
    })
}
