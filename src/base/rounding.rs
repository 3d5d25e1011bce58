//! Tolerance for rounded probabilities, such as three times 0.333333.

use std::cmp::Ordering;

use num_traits::{One, Signed};

use super::exact::{Ratio, Real};
use super::value::{Binary, EvalError};

/// Largest deviation from 1 that is accepted silently, in billionths: probabilities are written with
/// ten digits or more, or come from doubles.
const SILENT: i64 = 1;
/// Largest deviation from 1 that is accepted with a warning: 1e-5 as in PRISM, plus a margin for the
/// doubles nearest to three times 0.333333, in billionths.
const TOLERATED: i64 = 10_001;

/// The judgement on a sum of probabilities.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sum {
    /// The sum is 1, up to the rounding of probabilities to doubles.
    One,
    /// The sum is near 1 and is accepted with a warning.
    Rounded,
    /// The sum is too far from 1.
    Wrong,
}

impl Sum {
    /// Judges a sum of probabilities.
    pub fn judge(sum: &Real) -> Self {
        let Real::Finite(sum) = sum else { return Sum::Wrong };
        if sum.is_one() {
            return Sum::One;
        }
        let off = (sum - Ratio::one()).abs();
        let within = |billionths: i64| off <= Ratio::new(billionths.into(), 1_000_000_000.into());
        if within(SILENT) {
            Sum::One
        } else if within(TOLERATED) {
            Sum::Rounded
        } else {
            Sum::Wrong
        }
    }
}

/// Returns true for a number that may stand at a branch: at least 0, and at most 1 up to the deviation
/// that is tolerated for sums, as branches with the same target are written as one.
pub fn is_weight(p: &Real) -> bool {
    p.is_probability() || p.compare(&Real::from(1)) == Some(Ordering::Greater) && Sum::judge(p) != Sum::Wrong
}

/// Adds the probabilities of a distribution and judges their sum, which is the second result. If one
/// of them is not a probability, it is the second result.
///
/// # Errors
/// A probability or the sum has no value.
pub fn judged(
    probabilities: impl IntoIterator<Item = Result<Real, EvalError>>,
) -> Result<(Sum, Real), EvalError> {
    let mut sum = Real::from(0);
    for p in probabilities {
        let p = p?;
        if !is_weight(&p) {
            return Ok((Sum::Wrong, p));
        }
        sum = Real::combine(Binary::Add, &sum, &p)?;
    }
    Ok((Sum::judge(&sum), sum))
}

#[cfg(test)]
mod tests {
    use super::Sum;
    use crate::exact::{Real, decimal};

    #[test]
    fn a_sum_is_one_or_rounded_or_wrong() {
        for (sum, expected) in [
            ("1", Sum::One),
            ("0.9999999999", Sum::One),
            ("0.999999", Sum::Rounded),
            ("1.000001", Sum::Rounded),
            ("0.999", Sum::Wrong),
            ("0.99999", Sum::Rounded),
            ("0.9999", Sum::Wrong),
        ] {
            assert_eq!(Sum::judge(&Real::Finite(decimal(sum).unwrap())), expected, "{sum}");
        }
        for (sum, expected) in
            [(0.1 + 0.2 + 0.7, Sum::One), (3.0 * 0.333333, Sum::Rounded), (f64::NAN, Sum::Wrong)]
        {
            assert_eq!(Sum::judge(&Real::from(sum)), expected, "{sum}");
        }
    }
}
