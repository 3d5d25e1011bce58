//! Values, types and operators; the only definition of the operators' meaning.
//!
//! Integers are 64 bits wide and never wrap: an overflow is an error. Reals are IEEE doubles.

use std::fmt;
use std::hash::{Hash, Hasher};

/// The types of expressions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, strum::Display)]
#[strum(serialize_all = "lowercase")]
pub enum Type {
    /// `bool`
    Bool,
    /// `int`
    Int,
    /// `double`
    #[strum(to_string = "double")]
    Real,
}

/// A value. Equality and hashing of reals are by bits, so that values can be keys.
#[derive(Debug, Clone, Copy)]
pub enum Value {
    /// A truth value.
    Bool(bool),
    /// An integer.
    Int(i64),
    /// A real.
    Real(f64),
}

impl Value {
    /// Returns the type of the value.
    pub(crate) fn ty(self) -> Type {
        match self {
            Value::Bool(_) => Type::Bool,
            Value::Int(_) => Type::Int,
            Value::Real(_) => Type::Real,
        }
    }

    /// Returns the value as a real; Booleans count as 0 and 1.
    pub fn to_f64(self) -> f64 {
        match self {
            Value::Bool(b) => f64::from(u8::from(b)),
            Value::Int(i) => i as f64,
            Value::Real(x) => x,
        }
    }

    fn key(self) -> (u8, u64) {
        match self {
            Value::Bool(b) => (0, u64::from(b)),
            Value::Int(i) => (1, i as u64),
            Value::Real(x) => (2, x.to_bits()),
        }
    }
}

impl PartialEq for Value {
    fn eq(&self, other: &Self) -> bool {
        self.key() == other.key()
    }
}

impl Eq for Value {}

impl Hash for Value {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.key().hash(state);
    }
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Value::Bool(b) => write!(f, "{b}"),
            Value::Int(i) => write!(f, "{i}"),
            Value::Real(x) => write!(f, "{x:?}"),
        }
    }
}

/// Operators with one operand.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Unary {
    /// Boolean negation.
    Not,
    /// Arithmetic negation.
    Neg,
    /// The largest integer that is not greater.
    Floor,
    /// The smallest integer that is not less.
    Ceil,
    /// The nearest integer, halves rounded up (Java's `Math.round`).
    Round,
    /// The conversion of an integer to a real.
    ToReal,
}

/// Operators with two operands. `>`, `>=`, `!=`, `=>` and `<=>` are expressed by these.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Binary {
    /// Conjunction; the right side is not evaluated if the left one is false.
    And,
    /// Disjunction; the right side is not evaluated if the left one is true.
    Or,
    /// Equality of two Booleans, two integers or two reals.
    Eq,
    /// `<` of two integers or two reals.
    Lt,
    /// `<=` of two integers or two reals.
    Le,
    /// Addition of two integers or two reals.
    Add,
    /// Subtraction of two integers or two reals.
    Sub,
    /// Multiplication of two integers or two reals.
    Mul,
    /// Division of two reals.
    Div,
    /// The smaller of two integers or two reals.
    Min,
    /// The larger of two integers or two reals.
    Max,
    /// Power of two integers (exponent not negative) or two reals.
    Pow,
    /// `mod(i, n)` of two integers, never negative.
    Mod,
    /// `log(x, b)` of two reals.
    Log,
}

/// The reasons why an expression has no value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, thiserror::Error)]
pub enum EvalError {
    /// The result does not fit 64 bits.
    #[error("the result does not fit a 64-bit integer")]
    Overflow,
    /// The second argument of `mod` is 0.
    #[error("division by zero in `mod`")]
    ModByZero,
    /// The second argument of `mod` is negative.
    #[error("`mod` needs a positive second argument")]
    ModByNegative,
    /// The exponent of a `pow` of integers is negative.
    #[error("`pow` of integers needs an exponent that is not negative")]
    NegativeExponent,
    /// The operand of `floor`, `ceil` or `round` is not finite or too large for an integer.
    #[error("the value is not a finite number, or too large for an integer")]
    NotAnInteger,
}

/// Returns the type of `op(a)` for an operand of type `ty`.
pub(crate) fn unary_type(op: Unary, ty: Type) -> Type {
    match op {
        Unary::Not => Type::Bool,
        Unary::Neg => ty,
        Unary::Floor | Unary::Ceil | Unary::Round => Type::Int,
        Unary::ToReal => Type::Real,
    }
}

/// Returns the type of `a op b` for operands of type `ty`.
pub(crate) fn binary_type(op: Binary, ty: Type) -> Type {
    match op {
        Binary::And | Binary::Or | Binary::Eq | Binary::Lt | Binary::Le => Type::Bool,
        Binary::Add | Binary::Sub | Binary::Mul | Binary::Min | Binary::Max | Binary::Pow => ty,
        Binary::Div | Binary::Log => Type::Real,
        Binary::Mod => Type::Int,
    }
}

/// Computes `op(x)`.
///
/// # Errors
/// The operation has no value; see [`EvalError`].
pub(crate) fn unary(op: Unary, x: Value) -> Result<Value, EvalError> {
    Ok(match (op, x) {
        (Unary::Not, x) => Value::Bool(x.to_f64() == 0.0),
        (Unary::Neg, Value::Int(i)) => Value::Int(i.checked_neg().ok_or(EvalError::Overflow)?),
        (Unary::Neg, x) => Value::Real(-x.to_f64()),
        (Unary::Floor, x) => Value::Int(to_int(x.to_f64().floor())?),
        (Unary::Ceil, x) => Value::Int(to_int(x.to_f64().ceil())?),
        (Unary::Round, x) => Value::Int(to_int(round(x.to_f64()))?),
        (Unary::ToReal, x) => Value::Real(x.to_f64()),
    })
}

/// Computes `x op y` for operands of the same type (`Eq` on reals compares numbers: NaN equals
/// nothing).
///
/// # Errors
/// The operation has no value; see [`EvalError`].
pub(crate) fn binary(op: Binary, x: Value, y: Value) -> Result<Value, EvalError> {
    match (x, y) {
        (Value::Bool(a), Value::Bool(b)) => Ok(Value::Bool(match op {
            Binary::And => a && b,
            Binary::Or => a || b,
            Binary::Lt => !a & b,
            Binary::Le => !a | b,
            _ => a == b,
        })),
        (Value::Int(a), Value::Int(b)) => int_binary(op, a, b),
        _ => Ok(real_binary(op, x.to_f64(), y.to_f64())),
    }
}

fn int_binary(op: Binary, a: i64, b: i64) -> Result<Value, EvalError> {
    let int = |r: Option<i64>| r.map(Value::Int).ok_or(EvalError::Overflow);
    match op {
        Binary::Add => int(a.checked_add(b)),
        Binary::Sub => int(a.checked_sub(b)),
        Binary::Mul => int(a.checked_mul(b)),
        Binary::Min => Ok(Value::Int(a.min(b))),
        Binary::Max => Ok(Value::Int(a.max(b))),
        Binary::Pow if b < 0 => Err(EvalError::NegativeExponent),
        Binary::Pow => int(int_pow(a, b)),
        Binary::Mod if b == 0 => Err(EvalError::ModByZero),
        Binary::Mod if b < 0 => Err(EvalError::ModByNegative),
        Binary::Mod => Ok(Value::Int(a.rem_euclid(b))),
        _ => Ok(match op {
            Binary::Eq => Value::Bool(a == b),
            Binary::Lt => Value::Bool(a < b),
            Binary::Le => Value::Bool(a <= b),
            _ => real_binary(op, a as f64, b as f64),
        }),
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

fn real_binary(op: Binary, a: f64, b: f64) -> Value {
    match op {
        Binary::Add => Value::Real(a + b),
        Binary::Sub => Value::Real(a - b),
        Binary::Mul => Value::Real(a * b),
        Binary::Div => Value::Real(a / b),
        Binary::Min | Binary::Max if a.is_nan() || b.is_nan() => Value::Real(f64::NAN),
        // The negative zero is the smaller of the two zeros, as in Java.
        Binary::Min => Value::Real(if a < b || (a == b && a.is_sign_negative()) { a } else { b }),
        Binary::Max => Value::Real(if a > b || (a == b && a.is_sign_positive()) { a } else { b }),
        Binary::Pow => Value::Real(real_pow(a, b)),
        Binary::Log => Value::Real(real_log(a, b)),
        Binary::Mod => Value::Real(a.rem_euclid(b)),
        Binary::Lt => Value::Bool(a < b),
        Binary::Le => Value::Bool(a <= b),
        Binary::Eq | Binary::And | Binary::Or => Value::Bool(a == b),
    }
}

/// Returns the nearest integer, halves rounded up. Not `floor(x + 0.5)`, because that sum is
/// rounded itself.
fn round(x: f64) -> f64 {
    let below = x.floor();
    if x - below < 0.5 { below } else { below + 1.0 }
}

/// Computes Java's `Math.pow`, as PRISM does. It returns NaN in some cases in which C and Rust
/// return 1.
fn real_pow(a: f64, b: f64) -> f64 {
    if b.is_nan() || (a.abs() == 1.0 && b.is_infinite()) { f64::NAN } else { a.powf(b) }
}

/// Computes PRISM's logarithm: NaN for an invalid base.
fn real_log(x: f64, base: f64) -> f64 {
    if base.is_nan() || base <= 0.0 || base == 1.0 || base.is_infinite() {
        f64::NAN
    } else {
        x.ln() / base.ln()
    }
}

/// Converts a whole number to an integer, if it fits 64 bits.
fn to_int(x: f64) -> Result<i64, EvalError> {
    const BOUND: f64 = 9_223_372_036_854_775_808.0;
    if (-BOUND..BOUND).contains(&x) { Ok(x as i64) } else { Err(EvalError::NotAnInteger) }
}
