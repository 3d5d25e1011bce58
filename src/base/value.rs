//! Values, types and operators, and the errors of operations. [`super::exact`] has their meaning.

use std::fmt;
use std::hash::{Hash, Hasher};

use super::ratio::MOST_BITS;

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
    /// The double nearest to a real.
    Real(f64),
}

impl Value {
    /// Returns the type of the value.
    pub fn ty(self) -> Type {
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
    /// An index i of an array of length n: i, which has no value outside of 0 to n-1.
    Index,
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
    /// The index of an array is negative, or not less than its length.
    #[error("the index is outside of the array")]
    OutOfArray,
    /// Two assignments that happen at the same time have the same element of an array.
    #[error("two assignments change the same element of an array at the same time")]
    SameElement,
    /// The exponent of a `pow` of integers is negative.
    #[error("`pow` of integers needs an exponent that is not negative")]
    NegativeExponent,
    /// The operand of `floor`, `ceil` or `round` is not finite or too large for an integer.
    #[error("the value is not a finite number, or too large for an integer")]
    NotAnInteger,
    /// A number is needed, and the value is infinite or undefined.
    #[error("the value is not a finite number")]
    NotFinite,
    /// The exact value of a real has too many bits.
    #[error("the numerator or the denominator of the exact value has more than {} bits", MOST_BITS)]
    TooLong,
}

/// Returns the type of `op(a)` for an operand of type `ty`.
pub fn unary_type(op: Unary, ty: Type) -> Type {
    match op {
        Unary::Not => Type::Bool,
        Unary::Neg => ty,
        Unary::Floor | Unary::Ceil | Unary::Round => Type::Int,
        Unary::ToReal => Type::Real,
    }
}

/// Returns the type of `a op b` for operands of type `ty`.
pub fn binary_type(op: Binary, ty: Type) -> Type {
    match op {
        Binary::And | Binary::Or | Binary::Eq | Binary::Lt | Binary::Le => Type::Bool,
        Binary::Add | Binary::Sub | Binary::Mul | Binary::Min | Binary::Max | Binary::Pow => ty,
        Binary::Div | Binary::Log => Type::Real,
        Binary::Mod | Binary::Index => Type::Int,
    }
}
