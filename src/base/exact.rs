//! Exact values, and the operations on them: here on integers and Booleans, in [`super::real`] on reals.
//!
//! Integers are 64 bits wide and never wrap: an overflow is an error.

pub use super::decimal::{NoDecimal, decimal, shortest};
pub use super::real::{Ratio, Real};
use super::value::{Binary, EvalError, Type, Unary, Value};

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
        (Exact::Bool(a), Exact::Bool(b)) => Some(logical(op, *a, *b)),
        (Exact::Int(a), Exact::Int(b)) => whole(op, *a, *b)?,
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

/// Computes `a op b` on Booleans.
pub fn logical(op: Binary, a: bool, b: bool) -> Exact {
    Exact::Bool(match op {
        Binary::And => a && b,
        Binary::Or => a || b,
        Binary::Lt => !a & b,
        Binary::Le => !a | b,
        _ => a == b,
    })
}

/// Computes `a op b` on integers; `None` if the operation belongs to the reals.
///
/// # Errors
/// The operation has no value; see [`EvalError`].
pub fn whole(op: Binary, a: i64, b: i64) -> Result<Option<Exact>, EvalError> {
    let int = |r: Option<i64>| r.map(|i| Some(Exact::Int(i))).ok_or(EvalError::Overflow);
    let truth = |b: bool| Ok(Some(Exact::Bool(b)));
    match op {
        Binary::Add => int(a.checked_add(b)),
        Binary::Sub => int(a.checked_sub(b)),
        Binary::Mul => int(a.checked_mul(b)),
        Binary::Min => int(Some(a.min(b))),
        Binary::Max => int(Some(a.max(b))),
        Binary::Pow if b < 0 => Err(EvalError::NegativeExponent),
        Binary::Pow => int(int_pow(a, b)),
        Binary::Mod if b == 0 => Err(EvalError::ModByZero),
        Binary::Mod if b < 0 => Err(EvalError::ModByNegative),
        Binary::Mod => int(Some(a.rem_euclid(b))),
        // No element has an index in an array of length 0, which stands for such assignments.
        Binary::Index if b == 0 => Err(EvalError::SameElement),
        Binary::Index if a < 0 || a >= b => Err(EvalError::OutOfArray),
        Binary::Index => int(Some(a)),
        Binary::Eq => truth(a == b),
        Binary::Lt => truth(a < b),
        Binary::Le => truth(a <= b),
        Binary::And | Binary::Or | Binary::Div | Binary::Log => Ok(None),
    }
}

/// Computes `a^b` for b >= 0; `None` on overflow. Exponents beyond 32 bits matter for the bases -1,
/// 0 and 1 only.
fn int_pow(a: i64, b: i64) -> Option<i64> {
    match u32::try_from(b) {
        Ok(b) => a.checked_pow(b),
        Err(_) => match a {
            0 | 1 => Some(a),
            -1 => Some(if b % 2 == 0 { 1 } else { -1 }),
            _ => None,
        },
    }
}
