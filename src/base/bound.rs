//! An exact bound that is short where it can be: of values, as a certificate lists them.

use num_bigint::BigInt;
use num_traits::{FromPrimitive, Signed, ToPrimitive, Zero};

use crate::exact::Ratio;
use crate::interval::Interval;

/// The largest number of bits of the numerator or denominator of a fraction.
pub const MOST_BITS: u64 = 1 << 18;
/// The largest number of digits of such a number.
const MOST_DIGITS: usize = 80_000;

/// A bound: not negative, exact.
#[derive(Debug, Clone, PartialEq)]
pub enum Bound {
    /// A double, which may be infinite.
    Double(f64),
    /// A fraction that is not a double.
    Fraction(Box<Ratio>),
}

impl Bound {
    /// Returns the number; `None` if it is infinite.
    pub fn exact(&self) -> Option<Ratio> {
        match self {
            Bound::Double(x) => Ratio::from_f64(*x),
            Bound::Fraction(x) => Some((**x).clone()),
        }
    }

    /// Returns the doubles nearest to the number.
    pub fn around(&self) -> Interval {
        match self {
            Bound::Double(x) => Interval::point(*x),
            Bound::Fraction(x) => Interval::around(x),
        }
    }

    /// Parses a number as [`Display`](std::fmt::Display) writes it; `None` if the text is not one, or negative.
    pub fn parse(text: &str) -> Option<Self> {
        let length = |part: &str| (1..=MOST_DIGITS).contains(&part.len());
        let digits = |part: &str| length(part) && part.bytes().all(|b| b.is_ascii_digit());
        if text == "inf" {
            return Some(Bound::Double(f64::INFINITY));
        }
        if let Some((n, d)) = text.split_once('/') {
            if !digits(n) || !digits(d) {
                return None;
            }
            let (n, d): (BigInt, BigInt) = (n.parse().ok()?, d.parse().ok()?);
            return (!d.is_zero()).then(|| Bound::Fraction(Box::new(Ratio::new(n, d))));
        }
        let plain = text.starts_with(|c: char| c.is_ascii_digit());
        let x: f64 = text.parse().ok().filter(|x: &f64| plain && x.is_finite())?;
        Some(Bound::Double(x))
    }
}

impl From<Ratio> for Bound {
    /// Keeps a fraction that is not negative; a double if it is one.
    fn from(exact: Ratio) -> Self {
        debug_assert!(!exact.is_negative(), "bounds are not negative");
        let near = exact.to_f64().unwrap_or(f64::INFINITY);
        match Ratio::from_f64(near) {
            Some(x) if x == exact => Bound::Double(near),
            _ => Bound::Fraction(Box::new(exact)),
        }
    }
}

impl std::fmt::Display for Bound {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Bound::Double(x) if x.is_infinite() => f.write_str("inf"),
            // The shortest decimal that is read as this double.
            Bound::Double(x) => write!(f, "{x:?}"),
            Bound::Fraction(x) => write!(f, "{}/{}", x.numer(), x.denom()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_exact_and_not_negative() {
        let tenth = Ratio::new(1.into(), 10.into());
        assert_ne!(Bound::parse("0.1").unwrap().exact(), Some(tenth.clone()));
        assert_eq!(Bound::parse("1/10").unwrap().exact(), Some(tenth.clone()));
        assert_eq!(Bound::from(tenth).to_string(), "1/10");
        assert_eq!(Bound::from(Ratio::new(1.into(), 4.into())), Bound::Double(0.25));
        let long = "1".repeat(100_000) + "/3";
        for text in [
            long.as_str(),
            "",
            "-1",
            "+1",
            "NaN",
            "1/0",
            "/2",
            "1/",
            "-1/2",
            "1/-2",
            "infinity",
            "1e999",
            " 1",
        ] {
            assert_eq!(Bound::parse(text), None, "{text:?}");
        }
    }
}
