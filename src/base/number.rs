//! Numbers that are not negative, for solvers: intervals with outward rounding, fractions, and doubles.
//!
//! Solvers only add, multiply and divide such numbers. Without subtraction, no digits are cancelled: intervals
//! stay narrow however close to 1 a probability is.

use std::cmp::Ordering;

use num_traits::{One, Zero};

use super::exact::Ratio;
use super::interval::Interval;

/// A number that elimination adds, multiplies and divides. All are at least 0.
pub trait Weight: Clone {
    /// Returns 0.
    fn zero() -> Self;
    /// Returns 1.
    fn one() -> Self;
    /// Returns the sum.
    fn plus(&self, other: &Self) -> Self;
    /// Returns the product.
    fn times(&self, other: &Self) -> Self;
    /// Returns the quotient; the divisor is positive.
    fn over(&self, divisor: &Self) -> Self;
    /// Returns whether the number is certainly 0.
    fn is_zero(&self) -> bool;
    /// Returns the time to eliminate an entry with this number, relative to that of reading one in a sweep.
    fn work(&self) -> usize;
    /// An estimate of the bytes of a number.
    const BYTES: usize = size_of::<Self>();
}

/// A number with a claim: exact, or between two bounds. All values are at least 0.
pub trait Number: Weight + PartialEq + Send + Sync {
    /// Returns the number of a fraction.
    fn of(exact: &Ratio) -> Self;
    /// Returns whether this number is certainly greater.
    fn exceeds(&self, other: &Self) -> bool;
    /// Returns the lower bound as a number.
    #[must_use]
    fn low(&self) -> Self;
    /// Returns the upper bound as a number.
    #[must_use]
    fn high(&self) -> Self;
    /// Returns the greater or the smaller one of two numbers.
    #[must_use]
    fn extreme(self, other: Self, greatest: bool) -> Self;
    /// Returns the bounds.
    fn bounds(&self) -> Interval;
    /// Returns the fraction, if numbers of this kind are exact.
    fn exact(&self) -> Option<&Ratio>;
    /// Returns the number between two bounds; `None` if numbers of this kind are exact.
    fn rounded(bounds: Interval) -> Option<Self>;
    /// True if numbers of this kind are exact.
    const EXACT: bool;

    /// Returns whether this number is certainly greater, or certainly smaller.
    fn beats(&self, other: &Self, greatest: bool) -> bool {
        if greatest { self.exceeds(other) } else { other.exceeds(self) }
    }
}

/// Returns bounds of the sum of two numbers that are not negative. An exact sum keeps its value:
/// D. Knuth's TwoSum computes the rounding error exactly.
#[inline]
fn sum(a: f64, b: f64) -> (f64, f64) {
    let near = a + b;
    if !near.is_finite() {
        return (f64::MAX, f64::INFINITY);
    }
    let part = near - a;
    let error = (a - (near - part)) + (b - part);
    match error.total_cmp(&0.0) {
        _ if error == 0.0 => (near, near),
        Ordering::Less => (near.next_down(), near),
        _ => (near, near.next_up()),
    }
}

/// Returns a lower bound of a number that was rounded to the nearest double.
#[inline]
fn down(x: f64) -> f64 {
    x.next_down().max(0.0)
}

impl Weight for Interval {
    #[inline]
    fn zero() -> Self {
        Interval::ZERO
    }

    #[inline]
    fn one() -> Self {
        Interval::ONE
    }

    #[inline]
    fn plus(&self, other: &Self) -> Self {
        if self.is_zero() {
            return *other;
        }
        if other.is_zero() {
            return *self;
        }
        Interval { lower: sum(self.lower, other.lower).0, upper: sum(self.upper, other.upper).1 }
    }

    #[inline]
    fn times(&self, other: &Self) -> Self {
        if self.is_zero() || other.is_zero() {
            return Interval::ZERO;
        }
        if *self == Interval::ONE {
            return *other;
        }
        if *other == Interval::ONE {
            return *self;
        }
        // A bound of 0 times an infinite one is 0, not NaN.
        let lower = if self.lower == 0.0 || other.lower == 0.0 { 0.0 } else { self.lower * other.lower };
        Interval { lower: down(lower), upper: (self.upper * other.upper).next_up() }
    }

    #[inline]
    fn over(&self, divisor: &Self) -> Self {
        if self.is_zero() || *divisor == Interval::ONE {
            return *self;
        }
        let upper = if divisor.lower == 0.0 { f64::INFINITY } else { (self.upper / divisor.lower).next_up() };
        Interval { lower: down(self.lower / divisor.upper), upper }
    }

    #[inline]
    fn is_zero(&self) -> bool {
        self.upper == 0.0
    }

    #[inline]
    fn work(&self) -> usize {
        1
    }
}

impl Number for Interval {
    const EXACT: bool = false;

    #[inline]
    fn of(exact: &Ratio) -> Self {
        Interval::around(exact)
    }

    #[inline]
    fn exceeds(&self, other: &Self) -> bool {
        self.lower > other.upper
    }

    #[inline]
    fn low(&self) -> Self {
        Interval::point(self.lower)
    }

    #[inline]
    fn high(&self) -> Self {
        Interval::point(self.upper)
    }

    #[inline]
    fn extreme(self, other: Self, greatest: bool) -> Self {
        Interval::extreme(self, other, greatest)
    }

    #[inline]
    fn bounds(&self) -> Interval {
        *self
    }

    #[inline]
    fn exact(&self) -> Option<&Ratio> {
        None
    }

    #[inline]
    fn rounded(bounds: Interval) -> Option<Self> {
        Some(bounds)
    }
}

/// Implements [`Weight`] by the operators of a type, with the bytes and the work of a number.
macro_rules! by_operators {
    ($number:ty, $bytes:expr, $work:expr) => {
        impl Weight for $number {
            const BYTES: usize = $bytes;

            #[inline]
            fn zero() -> Self {
                Zero::zero()
            }

            #[inline]
            fn one() -> Self {
                One::one()
            }

            #[inline]
            fn plus(&self, other: &Self) -> Self {
                self + other
            }

            #[inline]
            fn times(&self, other: &Self) -> Self {
                self * other
            }

            #[inline]
            fn over(&self, divisor: &Self) -> Self {
                self / divisor
            }

            #[inline]
            fn is_zero(&self) -> bool {
                Zero::is_zero(self)
            }

            #[inline]
            fn work(&self) -> usize {
                $work(self)
            }
        }
    };
}

by_operators!(f64, size_of::<f64>(), |_| 1);
// Two vectors of digits with their headers; long fractions take more. A bit takes about a nanosecond, as an entry of
// doubles does.
by_operators!(Ratio, 128, |x: &Ratio| (x.numer().bits() + x.denom().bits()) as usize);

impl Number for Ratio {
    const EXACT: bool = true;

    fn of(exact: &Ratio) -> Self {
        exact.clone()
    }

    fn exceeds(&self, other: &Self) -> bool {
        self > other
    }

    fn low(&self) -> Self {
        self.clone()
    }

    fn high(&self) -> Self {
        self.clone()
    }

    fn extreme(self, other: Self, greatest: bool) -> Self {
        if greatest { self.max(other) } else { self.min(other) }
    }

    fn bounds(&self) -> Interval {
        Interval::around(self)
    }

    fn exact(&self) -> Option<&Ratio> {
        Some(self)
    }

    fn rounded(_: Interval) -> Option<Self> {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use num_traits::FromPrimitive;

    #[test]
    fn intervals_contain_the_exact_results() {
        let numbers: Vec<Ratio> = [(1, 3), (2, 7), (1, 1_000_000_007), (999_999, 1_000_000)]
            .map(|(n, d): (i64, i64)| Ratio::new(n.into(), d.into()))
            .into();
        let holds = |x: Interval, exact: &Ratio| {
            let [lower, upper] = [x.lower, x.upper].map(|x| Ratio::from_f64(x).unwrap());
            lower <= *exact && *exact <= upper && x.width() <= 1e-14 * x.upper
        };
        for a in &numbers {
            for b in &numbers {
                let (x, y) = (Interval::of(a), Interval::of(b));
                assert!(holds(x, a));
                assert!(holds(x.plus(&y), &(a + b)));
                assert!(holds(x.times(&y), &(a * b)));
                assert!(holds(x.over(&y), &(a / b)));
            }
        }
    }

    #[test]
    fn fractions_beyond_doubles_have_bounds() {
        let tiny = Ratio::new(1.into(), num_bigint::BigInt::from(10).pow(400));
        let huge = tiny.recip();
        assert_eq!(Interval::around(&tiny), Interval { lower: 0.0, upper: f64::from_bits(1) });
        assert_eq!(Interval::around(&huge), Interval { lower: f64::MAX, upper: f64::INFINITY });
    }
}
