//! Fractions of 32-bit integers, which are computed by machine arithmetic: intermediate results
//! have at most 64 bits. Most probabilities and rewards of models are such fractions.

use std::cmp::Ordering;

use num_bigint::BigInt;
use num_integer::Integer;
use num_traits::ToPrimitive;

use super::ratio::Ratio;
use super::value::{Binary, Unary};

/// A fraction in lowest terms. Its denominator is positive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Short {
    numerator: i32,
    denominator: i32,
}

/// A numerator and a positive denominator, in lowest terms.
type Parts = (i64, i64);

impl Short {
    /// The number 0.
    pub const ZERO: Short = Short { numerator: 0, denominator: 1 };
    /// The number 1.
    pub const ONE: Short = Short { numerator: 1, denominator: 1 };

    /// Returns a fraction; `None` if it is too long.
    pub fn new(x: &Ratio) -> Option<Short> {
        Some(Short { numerator: x.numer().to_i32()?, denominator: x.denom().to_i32()? })
    }

    /// Returns an integer; `None` if it is too long.
    pub fn whole(i: i64) -> Option<Short> {
        Short::from_parts((i, 1))
    }

    /// Returns numerator and denominator.
    pub fn parts(self) -> (i32, i32) {
        (self.numerator, self.denominator)
    }

    /// Returns the fraction with these parts, which are in lowest terms; `None` if it is too long.
    pub fn from_parts((numerator, denominator): Parts) -> Option<Short> {
        Some(Short { numerator: numerator.try_into().ok()?, denominator: denominator.try_into().ok()? })
    }

    /// Returns whether the number is between 0 and 1.
    pub fn is_probability(self) -> bool {
        0 <= self.numerator && self.numerator <= self.denominator
    }

    /// Compares two numbers.
    pub fn compare(self, other: Short) -> Ordering {
        (self.wide().0 * other.wide().1).cmp(&(other.wide().0 * self.wide().1))
    }

    /// Computes `x op y`; `None` if `op` is not a basic operation, or for a division by 0.
    pub fn combine(op: Binary, x: Short, y: Short) -> Option<Parts> {
        let ((a, b), (c, d)) = (x.wide(), y.wide());
        match op {
            Binary::Add => Some(sum((a, b), (c, d))),
            Binary::Sub => Some(sum((a, b), (-c, d))),
            Binary::Mul => Some(reduced(a * c, b * d)),
            Binary::Div if c != 0 => Some(reduced(a * d * c.signum(), b * c.abs())),
            _ => None,
        }
    }

    /// Rounds to an integer; `None` if `op` does not round.
    pub fn rounded(self, op: Unary) -> Option<i64> {
        let (n, d) = self.wide();
        match op {
            Unary::Floor => Some(n.div_euclid(d)),
            Unary::Ceil => Some(-(-n).div_euclid(d)),
            Unary::Round => Some((2 * n + d).div_euclid(2 * d)),
            _ => None,
        }
    }

    fn wide(self) -> Parts {
        (self.numerator.into(), self.denominator.into())
    }
}

impl From<Short> for Ratio {
    fn from(x: Short) -> Self {
        ratio(x.wide())
    }
}

/// Returns a fraction in lowest terms.
pub(super) fn ratio((numerator, denominator): Parts) -> Ratio {
    Ratio::new_raw(BigInt::from(numerator), BigInt::from(denominator))
}

fn sum((a, b): Parts, (c, d): Parts) -> Parts {
    match (b, d) {
        _ if b == d => reduced(a + c, b),
        // A sum with an integer is in lowest terms.
        (1, _) | (_, 1) => (a * d + c * b, b * d),
        _ => reduced(a * d + c * b, b * d),
    }
}

fn reduced(numerator: i64, denominator: i64) -> Parts {
    let common = numerator.gcd(&denominator);
    (numerator / common, denominator / common)
}

#[cfg(test)]
mod tests {
    use super::*;
    use num_traits::{Signed, Zero};

    /// Fractions at the limits of 32 bits and in the middle, in lowest terms.
    fn all() -> Vec<Ratio> {
        let parts = [0, 1, -1, 2, -3, 6, i64::from(i32::MAX), i64::from(i32::MIN), 1 << 31, i64::MIN];
        let denominators = |n: i64| parts.into_iter().filter(|d| *d != 0).map(move |d| (n, d));
        parts.into_iter().flat_map(denominators).map(|(n, d)| Ratio::new(n.into(), d.into())).collect()
    }

    fn short() -> Vec<(Short, Ratio)> {
        all().into_iter().filter_map(|x| Some((Short::new(&x)?, x))).collect()
    }

    #[test]
    fn short_fractions_are_computed_as_all_others() {
        let short = short();
        assert!(short.len() > 40 && short.len() < all().len());
        for (a, x) in &short {
            assert_eq!(&Ratio::from(*a), x);
            assert_eq!(a.is_probability(), !x.is_negative() && *x <= Ratio::from(BigInt::from(1)));
            for (b, y) in &short {
                assert_eq!(a.compare(*b), x.cmp(y), "{x}, {y}");
                for op in [Binary::Add, Binary::Sub, Binary::Mul, Binary::Div] {
                    let expected = match op {
                        Binary::Add => x + y,
                        Binary::Sub => x - y,
                        Binary::Mul => x * y,
                        _ if y.is_zero() => continue,
                        _ => x / y,
                    };
                    let found = Short::combine(op, *a, *b).map(ratio).unwrap();
                    let parts = (found.numer(), found.denom());
                    assert_eq!(parts, (expected.numer(), expected.denom()), "{x} {op:?} {y}");
                }
            }
        }
        assert_eq!(Short::combine(Binary::Div, Short::ONE, Short::ZERO), None);
    }

    #[test]
    fn short_fractions_are_rounded_as_all_others() {
        let half = Ratio::new(1.into(), 2.into());
        for (a, x) in short() {
            let expected =
                [(Unary::Floor, x.floor()), (Unary::Ceil, x.ceil()), (Unary::Round, (&x + &half).floor())];
            for (op, expected) in expected {
                assert_eq!(a.rounded(op).map(BigInt::from), Some(expected.to_integer()), "{op:?} {x}");
            }
        }
    }
}
