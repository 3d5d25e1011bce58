//! Real numbers: fractions, and what divisions by zero and logarithms give besides them.
//!
//! `+`, `-`, `*`, `/`, `min`, `max`, comparisons and rounding are exact. So are powers with a whole
//! exponent, and roots and logarithms whose value is a fraction. All others are irrational: the
//! double that is computed for them counts as their value.
//!
//! A fraction has a numerator and a denominator of at most [`MOST_BITS`] bits, so that every
//! operation takes few milliseconds.

use std::cmp::Ordering;
use std::fmt;
use std::hash::{Hash, Hasher};

use num_bigint::BigInt;
use num_traits::{One, Pow, Signed, ToPrimitive, Zero};

use super::decimal::{readable, shortest};
use super::ratio::is_short;
pub use super::ratio::{MOST_BITS, Ratio};
use super::short::{self, Short};
use super::value::{Binary, EvalError, Unary};

/// A real number. Equality is that of representations, so that numbers can be keys: an undefined
/// number equals itself.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Real {
    /// A fraction.
    Finite(Ratio),
    /// Positive infinity, such as 1/0; negative infinity if true.
    Infinite(bool),
    /// Not a number, such as 0/0.
    Undefined,
}

impl Hash for Real {
    /// Hashes numerator and denominator: the hash of a fraction divides them again and again.
    fn hash<H: Hasher>(&self, state: &mut H) {
        match self {
            Real::Finite(x) => (x.numer(), x.denom()).hash(state),
            Real::Infinite(negative) => negative.hash(state),
            Real::Undefined => 2u8.hash(state),
        }
    }
}

impl fmt::Display for Real {
    /// Writes the nearest double.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&readable(self.to_f64()))
    }
}

impl From<i64> for Real {
    fn from(i: i64) -> Self {
        Real::Finite(Ratio::from(BigInt::from(i)))
    }
}

impl From<bool> for Real {
    fn from(b: bool) -> Self {
        Real::from(i64::from(b))
    }
}

impl From<f64> for Real {
    /// Returns the number that a double is.
    fn from(x: f64) -> Self {
        match Ratio::from_float(x) {
            Some(exact) => Real::Finite(exact),
            None if x.is_nan() => Real::Undefined,
            None => Real::Infinite(x < 0.0),
        }
    }
}

impl Real {
    /// Returns the shortest decimal number that rounds to a double.
    pub fn shortest(x: f64) -> Real {
        shortest(x).map_or_else(|| Real::from(x), Real::Finite)
    }

    /// Returns the fraction, unless the number is infinite or undefined.
    pub fn finite(&self) -> Option<&Ratio> {
        match self {
            Real::Finite(x) => Some(x),
            Real::Infinite(_) | Real::Undefined => None,
        }
    }

    /// Returns the nearest double.
    pub fn to_f64(&self) -> f64 {
        match self {
            Real::Finite(x) => x.to_f64().unwrap_or(f64::NAN),
            Real::Infinite(true) => f64::NEG_INFINITY,
            Real::Infinite(false) => f64::INFINITY,
            Real::Undefined => f64::NAN,
        }
    }

    /// Returns true for 0.
    pub fn is_zero(&self) -> bool {
        self.finite().is_some_and(Zero::is_zero)
    }

    /// Returns true if the number is between 0 and 1.
    pub fn is_probability(&self) -> bool {
        self.finite().is_some_and(|x| !x.is_negative() && x.numer() <= x.denom())
    }

    /// Compares two numbers; `None` if one is undefined.
    pub fn compare(&self, other: &Real) -> Option<Ordering> {
        let side = |infinite: bool| if infinite { Ordering::Less } else { Ordering::Greater };
        match (self, other) {
            (Real::Undefined, _) | (_, Real::Undefined) => None,
            (Real::Finite(x), Real::Finite(y)) => Some(x.cmp(y)),
            (Real::Infinite(x), Real::Infinite(y)) => Some(y.cmp(x)),
            (Real::Infinite(x), _) => Some(side(*x)),
            (_, Real::Infinite(y)) => Some(side(!*y)),
        }
    }

    /// Computes `-x`.
    pub(super) fn negated(&self) -> Real {
        match self {
            Real::Finite(x) => Real::Finite(-x),
            Real::Infinite(negative) => Real::Infinite(!negative),
            Real::Undefined => Real::Undefined,
        }
    }

    /// Rounds to an integer; `round` takes halves up.
    ///
    /// # Errors
    /// The number is not finite, or too large.
    pub(super) fn whole(&self, op: Unary) -> Result<i64, EvalError> {
        let x = self.finite().ok_or(EvalError::NotAnInteger)?;
        let whole = match op {
            Unary::Floor => x.floor(),
            Unary::Ceil => x.ceil(),
            _ => (x + Ratio::new(1.into(), 2.into())).floor(),
        };
        whole.to_integer().to_i64().ok_or(EvalError::NotAnInteger)
    }

    /// Returns the double that counts for a power or a logarithm of two numbers: its value is not a
    /// fraction, or one with too many bits. `None` if the value is exact, or if the double would be
    /// 0, 1 or infinite, which the value is not.
    pub fn near(op: Binary, x: &Real, y: &Real) -> Option<Real> {
        let (Real::Finite(x), Real::Finite(y)) = (x, y) else { return None };
        if op == Binary::Log {
            let is_exact = rational_logarithm(x, y, ln(x) / ln(y)).is_some();
            return Some(logarithm(x, y)).filter(|near| near.finite().is_some() && !is_exact);
        }
        if x.is_zero() || root(x, y.denom()).is_some_and(|root| whole_power(&root, y.numer()).is_some()) {
            return None;
        }
        let near = x.to_f64()?.abs().powf(y.to_f64()?);
        let odd = x.is_negative() && y.numer().bit(0);
        let fits = near.is_normal() && near != 1.0 && (y.is_integer() || !x.is_negative());
        fits.then(|| Real::from(if odd { -near } else { near }))
    }

    /// Computes `x op y` for an operation whose result is a real.
    ///
    /// # Errors
    /// The result has more than [`MOST_BITS`] bits.
    pub(super) fn combine(op: Binary, x: &Real, y: &Real) -> Result<Real, EvalError> {
        match (op, x, y) {
            (Binary::Min | Binary::Max, ..) => Ok(extreme(op, x, y)),
            (_, Real::Finite(x), Real::Finite(y)) => finite(op, x, y),
            _ => Ok(Real::from(not_finite(op, x.to_f64(), y.to_f64()))),
        }
    }
}

fn extreme(op: Binary, x: &Real, y: &Real) -> Real {
    let wanted = if op == Binary::Min { Ordering::Less } else { Ordering::Greater };
    match x.compare(y) {
        None => Real::Undefined,
        Some(order) => if order == wanted { x } else { y }.clone(),
    }
}

fn finite(op: Binary, x: &Ratio, y: &Ratio) -> Result<Real, EvalError> {
    if let Some(short) = short(op, x, y) {
        return Ok(Real::Finite(short));
    }
    match op {
        Binary::Add => bounded(x + y),
        Binary::Sub => bounded(x - y),
        Binary::Mul => bounded(x * y),
        Binary::Div => quotient(x, y),
        Binary::Pow => power(x, y),
        Binary::Mod | Binary::Index => quotient(x, y).map(|_| Real::Undefined),
        _ => Ok(logarithm(x, y)),
    }
}

/// Computes an operation on short fractions, which takes a fraction of the time. `None` for others.
fn short(op: Binary, x: &Ratio, y: &Ratio) -> Option<Ratio> {
    Short::combine(op, Short::new(x)?, Short::new(y)?).map(short::ratio)
}

/// Returns a fraction, unless it has too many bits.
fn bounded(x: Ratio) -> Result<Real, EvalError> {
    if is_short(&x) { Ok(Real::Finite(x)) } else { Err(EvalError::TooLong) }
}

fn quotient(x: &Ratio, y: &Ratio) -> Result<Real, EvalError> {
    match (y.is_zero(), x.is_zero()) {
        (false, _) => bounded(x / y),
        (true, true) => Ok(Real::Undefined),
        (true, false) => Ok(Real::Infinite(x.is_negative())),
    }
}

fn power(x: &Ratio, y: &Ratio) -> Result<Real, EvalError> {
    if x.is_zero() && !y.is_zero() {
        return Ok(if y.is_negative() { Real::Infinite(false) } else { Real::from(0) });
    }
    if let Some(root) = root(x, y.denom()) {
        return match whole_power(&root, y.numer()) {
            Some(power) => bounded(power),
            None => Err(EvalError::TooLong),
        };
    }
    if x.is_negative() {
        return Ok(Real::Undefined);
    }
    let near = x.to_f64().unwrap_or(0.0);
    let y = y.to_f64().unwrap_or(f64::NAN);
    Ok(Real::from(if near.is_normal() { near.powf(y) } else { (y * ln(x)).exp() }))
}

/// Computes `x^n`; `None` if it has too many bits.
fn whole_power(x: &Ratio, n: &BigInt) -> Option<Ratio> {
    if x.is_one() || n.is_zero() {
        return Some(Ratio::one());
    }
    if (-x).is_one() {
        return Some(if n.bit(0) { x.clone() } else { Ratio::one() });
    }
    // A number of b bits is at least 2^(b - 1).
    let least = x.numer().bits().max(x.denom().bits()).saturating_sub(1);
    let exponent = u32::try_from(n.magnitude()).ok()?;
    if least.saturating_mul(exponent.into()) > MOST_BITS {
        return None;
    }
    let power = Pow::pow(x, exponent);
    Some(if n.is_negative() { power.recip() } else { power })
}

/// Returns the n-th root, if it is a fraction.
fn root(x: &Ratio, n: &BigInt) -> Option<Ratio> {
    if n.is_one() {
        return Some(x.clone());
    }
    let n = n.to_u32().filter(|n| u64::from(*n) <= MOST_BITS && !x.is_negative())?;
    let root = Ratio::new_raw(x.numer().nth_root(n), x.denom().nth_root(n));
    (Pow::pow(&root, n) == *x).then_some(root)
}

/// Computes the logarithm of `x`. As in PRISM, it is undefined for an invalid base.
fn logarithm(x: &Ratio, base: &Ratio) -> Real {
    if !base.is_positive() || base.is_one() || x.is_negative() {
        return Real::Undefined;
    }
    if x.is_zero() {
        return Real::Infinite(*base > Ratio::one());
    }
    let near = ln(x) / ln(base);
    rational_logarithm(x, base, near).map_or_else(|| Real::from(near), Real::Finite)
}

/// Returns the logarithm if it is a fraction p/q, that is if `base^p = x^q`. If `base` is not a
/// power itself, then q is 1. A base of b bits is at most a b-th power.
fn rational_logarithm(x: &Ratio, base: &Ratio, near: f64) -> Option<Ratio> {
    let most = base.numer().bits().max(base.denom().bits()).min(64);
    (1..=most).find_map(|q| {
        let p = (near * q as f64).round();
        if (near * q as f64 - p).abs() > 1e-9 * p.abs().max(1.0) {
            return None;
        }
        let (p, q) = (BigInt::from(p as i64), BigInt::from(q));
        (whole_power(base, &p)? == whole_power(x, &q)?).then(|| Ratio::new(p, q))
    })
}

/// Computes the natural logarithm of a positive fraction, which may be far outside of the doubles,
/// or nearer to 1 than they are.
fn ln(x: &Ratio) -> f64 {
    let near = x.to_f64().unwrap_or(0.0);
    if (0.5..2.0).contains(&near) {
        return (x - Ratio::one()).to_f64().unwrap_or(0.0).ln_1p();
    }
    if near.is_normal() {
        return near.ln();
    }
    let of = |n: &BigInt| {
        let shift = n.bits().saturating_sub(64);
        (n >> shift).to_f64().unwrap_or(1.0).ln() + shift as f64 * std::f64::consts::LN_2
    };
    of(x.numer()) - of(x.denom())
}

/// Computes an operation of which an operand is not finite, as Java does.
fn not_finite(op: Binary, x: f64, y: f64) -> f64 {
    match op {
        Binary::Add => x + y,
        Binary::Sub => x - y,
        Binary::Mul => x * y,
        Binary::Div => x / y,
        // Java's power is undefined in some cases in which those of C and Rust are 1.
        Binary::Pow if y.is_nan() || (x.abs() == 1.0 && y.is_infinite()) => f64::NAN,
        Binary::Pow => x.powf(y),
        Binary::Log if y.is_finite() && y > 0.0 && y != 1.0 => x.ln() / y.ln(),
        _ => f64::NAN,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ratio(numerator: i64, denominator: i64) -> Ratio {
        Ratio::new(numerator.into(), denominator.into())
    }

    fn real(op: Binary, x: Ratio, y: Ratio) -> Result<Real, EvalError> {
        Real::combine(op, &Real::Finite(x), &Real::Finite(y))
    }

    #[test]
    fn powers_and_logarithms_that_are_fractions_are_exact() {
        let exact = |n, d| Ok(Real::Finite(ratio(n, d)));
        for (x, y, n, d) in [
            (ratio(1, 2), ratio(-3, 1), 8, 1),
            (ratio(4, 9), ratio(1, 2), 2, 3),
            (ratio(4, 9), ratio(-3, 2), 27, 8),
            (ratio(-2, 1), ratio(3, 1), -8, 1),
            (ratio(0, 1), ratio(0, 1), 1, 1),
            (ratio(-1, 1), ratio(i64::MAX, 1), -1, 1),
        ] {
            assert_eq!(real(Binary::Pow, x.clone(), y.clone()), exact(n, d), "{x}^{y}");
        }
        for (x, base, n, d) in [(1000, 10, 3, 1), (8, 4, 3, 2), (1, 7, 0, 1), (2, 1024, 1, 10)] {
            assert_eq!(real(Binary::Log, ratio(x, 1), ratio(base, 1)), exact(n, d), "log({x},{base})");
        }
        let root = real(Binary::Pow, ratio(1, 2), ratio(1, 2)).unwrap();
        assert_eq!(root, Real::from(0.5f64.sqrt()));
        assert_eq!(real(Binary::Pow, ratio(-8, 1), ratio(1, 2)), Ok(Real::Undefined));
        assert_eq!(real(Binary::Pow, ratio(0, 1), ratio(-1, 1)), Ok(Real::Infinite(false)));
    }

    #[test]
    fn numbers_far_from_the_doubles_have_logarithms() {
        let tiny = Ratio::new(1.into(), Pow::pow(BigInt::from(10), 1000u32));
        assert_eq!(real(Binary::Log, tiny.clone(), ratio(10, 1)), Ok(Real::from(-1000)));
        let Ok(Real::Finite(near)) = real(Binary::Log, tiny + ratio(1, 1), ratio(2, 1)) else { panic!() };
        assert_eq!(near, Ratio::zero());
    }

    #[test]
    fn long_numbers_are_refused_without_being_computed() {
        for (x, y) in [(ratio(9, 10), i64::MAX), (ratio(999, 1000), -100_000)] {
            assert_eq!(real(Binary::Pow, x, ratio(y, 1)), Err(EvalError::TooLong));
        }
        let long = |n: u32| Ratio::new(1.into(), Pow::pow(BigInt::from(n), 9000u32));
        assert_eq!(real(Binary::Add, long(2), long(3)), Err(EvalError::TooLong));
        assert_eq!(real(Binary::Mul, long(2), long(2)), Err(EvalError::TooLong));
    }
}
