//! Exact values of expressions: integers as in [`super::value`], reals as rational numbers.
//!
//! The pool stores real literals as doubles. [`rational`] recovers the number that was written:
//! 0.1 is 1/10, and 1/3 is 1/3.

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{One, Pow, Signed, ToPrimitive, Zero};

use super::expr::{ExprId, ExprPool, Node};
use super::value::{self, Binary, EvalError, Type, Unary, Value};

/// Decimals of at most this many digits are recovered from the nearest double.
const EXACT_DIGITS: usize = 15;
/// Maximum number of bits of a power; larger ones are rounded to doubles.
const MOST_BITS: u64 = 1 << 14;

/// An exact value.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Exact {
    /// A truth value or an integer.
    Discrete(Value),
    /// A real.
    Real(BigRational),
}

impl Exact {
    /// Returns the value as a number; Booleans count as 0 and 1.
    pub fn number(self) -> BigRational {
        match self {
            Exact::Discrete(Value::Int(i)) => BigRational::from_integer(i.into()),
            Exact::Discrete(v) => BigRational::from_integer(BigInt::from(u8::from(v.to_f64() != 0.0))),
            Exact::Real(x) => x,
        }
    }
}

impl ExprPool {
    /// Evaluates `id` in a state without rounding. Logarithms, and powers that are irrational or
    /// very large, are the doubles of [`ExprPool::eval`].
    ///
    /// # Errors
    /// The errors of [`ExprPool::eval`]; a division by zero, or a real that is not finite.
    pub fn eval_exact(&self, id: ExprId, state: &[i64]) -> Result<Exact, EvalError> {
        match self.node(id) {
            Node::Literal(Value::Real(x)) => rational(x).map(Exact::Real),
            Node::Literal(v) => Ok(Exact::Discrete(v)),
            Node::Var(v) => Ok(Exact::Discrete(match self.ty(id) {
                Type::Bool => Value::Bool(state[v.index()] != 0),
                _ => Value::Int(state[v.index()]),
            })),
            Node::Unary(op, a) => unary(op, self.eval_exact(a, state)?),
            Node::Binary(op, a, b) => {
                let x = self.eval_exact(a, state)?;
                match (op, &x) {
                    (Binary::And, Exact::Discrete(Value::Bool(false)))
                    | (Binary::Or, Exact::Discrete(Value::Bool(true))) => Ok(x),
                    _ => binary(op, x, self.eval_exact(b, state)?),
                }
            }
            Node::Ite(c, a, b) => match self.eval_exact(c, state)? {
                Exact::Discrete(Value::Bool(false)) => self.eval_exact(b, state),
                _ => self.eval_exact(a, state),
            },
        }
    }
}

fn unary(op: Unary, x: Exact) -> Result<Exact, EvalError> {
    match (op, x) {
        (Unary::ToReal, x) => Ok(Exact::Real(x.number())),
        (_, Exact::Discrete(v)) => value::unary(op, v).map(Exact::Discrete),
        (Unary::Neg, Exact::Real(x)) => Ok(Exact::Real(-x)),
        (Unary::Floor, Exact::Real(x)) => integer(&x.floor()),
        (Unary::Ceil, Exact::Real(x)) => integer(&x.ceil()),
        // Halves are rounded up.
        (_, Exact::Real(x)) => integer(&(x + BigRational::new(1.into(), 2.into())).floor()),
    }
}

fn integer(x: &BigRational) -> Result<Exact, EvalError> {
    let integer = x.to_integer().to_i64().ok_or(EvalError::NotAnInteger)?;
    Ok(Exact::Discrete(Value::Int(integer)))
}

fn binary(op: Binary, x: Exact, y: Exact) -> Result<Exact, EvalError> {
    if let (Exact::Discrete(a), Exact::Discrete(b)) = (&x, &y) {
        return value::binary(op, *a, *b).map(Exact::Discrete);
    }
    let (x, y) = (x.number(), y.number());
    let truth = |b| Ok(Exact::Discrete(Value::Bool(b)));
    Ok(Exact::Real(match op {
        Binary::Eq | Binary::And | Binary::Or => return truth(x == y),
        Binary::Lt => return truth(x < y),
        Binary::Le => return truth(x <= y),
        Binary::Add => x + y,
        Binary::Sub => x - y,
        Binary::Mul => x * y,
        Binary::Div | Binary::Mod if y.is_zero() => return Err(EvalError::DivisionByZero),
        Binary::Div => x / y,
        Binary::Mod => &x - &y * (&x / &y).floor(),
        Binary::Min => x.min(y),
        Binary::Max => x.max(y),
        Binary::Pow => power(x, y)?,
        Binary::Log => rounded(op, &x, &y)?,
    }))
}

/// Computes x^y, exactly if y is an integer and the result is not too large.
fn power(x: BigRational, y: BigRational) -> Result<BigRational, EvalError> {
    let bits = x.numer().bits().max(x.denom().bits());
    match y.to_integer().to_i32() {
        Some(n) if n < 0 && y.is_integer() && x.is_zero() => Err(EvalError::DivisionByZero),
        Some(n) if y.is_integer() && u64::from(n.unsigned_abs()).saturating_mul(bits) <= MOST_BITS => {
            Ok(Pow::pow(x, n))
        }
        _ => rounded(Binary::Pow, &x, &y),
    }
}

/// Computes an operation on doubles.
fn rounded(op: Binary, x: &BigRational, y: &BigRational) -> Result<BigRational, EvalError> {
    let double = |x: &BigRational| Value::Real(x.to_f64().unwrap_or(f64::NAN));
    rational(value::binary(op, double(x), double(y))?.to_f64())
}

/// Returns the rational number that a double stands for: the decimal of at most 15 digits that it
/// represents, if there is one, otherwise the simplest fraction that is rounded to it.
///
/// # Errors
/// The double is not finite.
pub fn rational(x: f64) -> Result<BigRational, EvalError> {
    if !x.is_finite() {
        return Err(EvalError::NotFinite);
    }
    let exact = |x: f64| BigRational::from_float(x).ok_or(EvalError::NotFinite);
    if x.fract() == 0.0 {
        return exact(x);
    }
    if let Some(decimal) = decimal(x) {
        return Ok(decimal);
    }
    let size = x.abs();
    let half = BigRational::new(1.into(), 2.into());
    let middle = |neighbour: f64| Ok((exact(size)? + exact(neighbour)?) * &half);
    let found = simplest(middle(size.next_down())?, &middle(size.next_up())?);
    Ok(if x < 0.0 { -found } else { found })
}

/// Returns the shortest decimal that is rounded to a double, if it has few digits.
fn decimal(x: f64) -> Option<BigRational> {
    let text = format!("{x:e}");
    let (digits, exponent) = text.split_once('e')?;
    let (whole, fraction) = digits.split_once('.').unwrap_or((digits, ""));
    if whole.trim_start_matches('-').len() + fraction.len() > EXACT_DIGITS {
        return None;
    }
    let number: BigInt = format!("{whole}{fraction}").parse().ok()?;
    let shift = exponent.parse::<i32>().ok()? - i32::try_from(fraction.len()).ok()?;
    Some(BigRational::from_integer(number) * Pow::pow(BigRational::from_integer(10.into()), shift))
}

/// Returns the fraction with the smallest denominator between two positive numbers, by their
/// continued fractions.
fn simplest(low: BigRational, high: &BigRational) -> BigRational {
    let (mut low, mut high) = (low, high.clone());
    let mut parts = Vec::new();
    loop {
        let whole = low.floor();
        if whole == low || &whole + BigRational::one() <= high {
            parts.push(low.ceil());
            break;
        }
        // Both numbers lie strictly between `whole` and `whole` + 1.
        (low, high) = ((&high - &whole).recip(), (&low - &whole).recip());
        parts.push(whole);
    }
    let mut parts = parts.into_iter().rev();
    let last = parts.next().unwrap_or_else(BigRational::zero);
    parts.fold(last, |inner, part| part + inner.abs().recip())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::VarId;

    fn of(numerator: i64, denominator: i64) -> BigRational {
        BigRational::new(numerator.into(), denominator.into())
    }

    #[test]
    fn doubles_stand_for_the_numbers_that_were_written() {
        for (x, expected) in [
            (0.1, of(1, 10)),
            (-0.25, of(-1, 4)),
            (1.0 / 3.0, of(1, 3)),
            (-2.0 / 7.0, of(-2, 7)),
            (0.333333, of(333_333, 1_000_000)),
            (1e-9, of(1, 1_000_000_000)),
            (0.123456789012345, of(123_456_789_012_345, 1_000_000_000_000_000)),
            (12.0, of(12, 1)),
            (0.0, of(0, 1)),
            (355.0 / 113.0, of(355, 113)),
        ] {
            assert_eq!(rational(x), Ok(expected), "{x}");
        }
        for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!(rational(x), Err(EvalError::NotFinite), "{x}");
        }
    }

    #[test]
    fn every_double_is_the_nearest_one_to_its_number() {
        let mut x = 1e-300_f64;
        while x < 1e300 {
            assert_eq!(rational(x).unwrap().to_f64(), Some(x), "{x:e}");
            x *= 1.234_567_890_123_456_7e3;
        }
    }

    #[test]
    fn operations_are_exact_where_doubles_are_not() {
        let mut pool = ExprPool::default();
        let x = pool.var(VarId(0), Type::Int);
        let x = pool.unary(Unary::ToReal, x);
        let tenth = pool.value(Value::Real(0.1));
        let product = pool.binary(Binary::Mul, x, tenth);
        let power = pool.binary(Binary::Pow, tenth, x);
        let quotient = pool.binary(Binary::Div, tenth, x);
        let value = |e, s: i64| pool.eval_exact(e, &[s]).map(Exact::number);
        assert_eq!(value(product, 3), Ok(of(3, 10)));
        assert_eq!(value(power, 3), Ok(of(1, 1000)));
        assert_eq!(value(power, -2), Ok(of(100, 1)));
        assert_eq!(value(quotient, 3), Ok(of(1, 30)));
        assert_eq!(value(quotient, 0), Err(EvalError::DivisionByZero));
    }

    #[test]
    fn roots_and_large_powers_are_doubles() {
        let root = power(of(2, 1), of(1, 2)).unwrap().to_f64().unwrap();
        assert_eq!(root, 2.0_f64.sqrt());
        assert_eq!(power(of(1, 2), of(1 << 20, 1)).unwrap(), of(0, 1));
        assert_eq!(power(of(2, 1), of(1 << 20, 1)), Err(EvalError::NotFinite));
        assert_eq!(power(of(0, 1), of(-1, 1)), Err(EvalError::DivisionByZero));
    }
}
