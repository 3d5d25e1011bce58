//! Numbers that are not negative: intervals of doubles with outward rounding, and fractions.
//!
//! The solver only adds, multiplies and divides such numbers. Without subtraction there is no
//! cancellation, so intervals stay narrow however close to 1 a probability is.

use std::cmp::Ordering;

use num_rational::BigRational;
use num_traits::{FromPrimitive, One, ToPrimitive, Zero};

use meliora_base::exact::Ratio;

/// The width of a value that is usually enough, absolute for probabilities, relative above 1 for
/// rewards.
pub const PRECISION: f64 = 1e-6;

/// Lower and upper bound of a number that is not negative; the upper one may be infinite.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    /// The lower bound.
    pub lower: f64,
    /// The upper bound.
    pub upper: f64,
}

impl Interval {
    /// The number 0.
    pub const ZERO: Interval = Interval::point(0.0);
    /// The number 1.
    pub const ONE: Interval = Interval::point(1.0);

    /// Returns the interval of one double.
    pub const fn point(x: f64) -> Self {
        Interval { lower: x, upper: x }
    }

    /// Returns the smallest interval that contains a fraction.
    pub fn around(exact: &Ratio) -> Self {
        let near = exact.to_f64().unwrap_or(f64::MAX).min(f64::MAX);
        let compare = |x: f64| BigRational::from_f64(x).map(|x| x.cmp(exact));
        let (mut lower, mut upper) = (near, near);
        while lower > 0.0 && compare(lower).is_none_or(|order| order.is_gt()) {
            lower = lower.next_down();
        }
        while upper < f64::INFINITY && compare(upper).is_none_or(|order| order.is_lt()) {
            upper = upper.next_up();
        }
        Interval { lower: lower.max(0.0), upper }
    }

    /// Returns the distance of the bounds.
    pub fn width(self) -> f64 {
        if self.lower == self.upper { 0.0 } else { self.upper - self.lower }
    }
}

/// Bounds of a number, and the number itself if it is known exactly.
#[derive(Debug, Clone, PartialEq)]
pub struct Bounds {
    /// The bounds.
    pub interval: Interval,
    /// The exact value.
    pub exact: Option<Ratio>,
}

impl Bounds {
    /// Copies the bounds of a number.
    pub(crate) fn of<N: Number>(number: &N) -> Self {
        Bounds { interval: number.bounds(), exact: number.exact().cloned() }
    }

    /// Returns the bounds of a probability, which is at most 1.
    pub(crate) fn at_most_one(mut self) -> Self {
        self.interval.upper = self.interval.upper.min(1.0);
        self
    }

    /// Returns 1 minus a probability.
    #[must_use]
    pub fn complement(self) -> Self {
        Bounds { interval: self.interval.complement(), exact: self.exact.map(|exact| exact.complement()) }
    }

    /// Lowers the lower bound of a number of which a loss is possible.
    pub(crate) fn lose(&mut self, loss: f64) {
        if loss > 0.0 {
            self.interval.lower = (self.interval.lower - loss).next_down().max(0.0);
        }
    }

    /// Returns the number in the middle.
    pub fn middle(&self) -> f64 {
        f64::midpoint(self.interval.lower, self.interval.upper)
    }

    /// Returns the bounds 0 and `upper`.
    pub(crate) fn any(upper: f64) -> Self {
        Bounds { interval: Interval { lower: 0.0, upper }, exact: None }
    }

    /// Returns the bounds of a whole number.
    pub(crate) fn point(x: u8) -> Self {
        Bounds { interval: Interval::point(f64::from(x)), exact: Some(Ratio::from_integer(x.into())) }
    }
}

/// A number that elimination adds, multiplies and divides. All are at least 0.
pub(crate) trait Weight: Clone {
    fn zero() -> Self;
    fn plus(&self, other: &Self) -> Self;
    fn times(&self, other: &Self) -> Self;
    /// Returns the quotient; the divisor is positive.
    fn over(&self, divisor: &Self) -> Self;
    fn is_zero(&self) -> bool;
    /// Returns the time to eliminate an entry with this number, relative to that of reading one in a sweep.
    fn work(&self) -> usize;
    /// An estimate of the bytes of a number.
    const BYTES: usize = size_of::<Self>();
}

/// A number of the solver: exact, or between two bounds. All values are at least 0.
pub(crate) trait Number: Weight + PartialEq + Send + Sync {
    fn one() -> Self;
    fn of(exact: &Ratio) -> Self;
    /// Returns whether this number is certainly greater.
    fn exceeds(&self, other: &Self) -> bool;
    /// Returns the lower bound as a number.
    fn low(&self) -> Self;
    /// Returns the upper bound as a number.
    fn high(&self) -> Self;
    /// Returns the number between these two.
    fn between(low: &Self, high: &Self) -> Self;
    /// Returns the other number if that is certainly greater, else this one.
    fn or_greater(self, other: Self) -> Self {
        if other.exceeds(&self) { other } else { self }
    }
    /// Returns the other number if that is certainly smaller, else this one.
    fn or_smaller(self, other: Self) -> Self {
        if self.exceeds(&other) { other } else { self }
    }
    /// Returns an upper bound of `self` - `other`, at least 0: the largest possible excess.
    fn excess(&self, other: &Self) -> Self;
    /// Returns 1 minus a probability.
    fn complement(&self) -> Self;
    fn bounds(&self) -> Interval;
    /// Returns the bounds as fractions; 0 for an infinite one.
    fn fractions(&self) -> (Ratio, Ratio);
    fn exact(&self) -> Option<&Ratio>;
    /// Returns the number between two bounds; `None` if numbers of this kind are exact.
    fn rounded(bounds: Interval) -> Option<Self>;
    /// True if numbers of this kind are exact.
    const EXACT: bool;
}

/// Returns bounds of the sum of two numbers that are not negative. An exact sum keeps its value:
/// D. Knuth's TwoSum computes the rounding error exactly.
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
fn down(x: f64) -> f64 {
    x.next_down().max(0.0)
}

impl Weight for Interval {
    fn zero() -> Self {
        Interval::ZERO
    }

    fn plus(&self, other: &Self) -> Self {
        if Weight::is_zero(self) {
            return *other;
        }
        if Weight::is_zero(other) {
            return *self;
        }
        Interval { lower: sum(self.lower, other.lower).0, upper: sum(self.upper, other.upper).1 }
    }

    fn times(&self, other: &Self) -> Self {
        if Weight::is_zero(self) || Weight::is_zero(other) {
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

    fn over(&self, divisor: &Self) -> Self {
        if Weight::is_zero(self) || *divisor == Interval::ONE {
            return *self;
        }
        let upper = if divisor.lower == 0.0 { f64::INFINITY } else { (self.upper / divisor.lower).next_up() };
        Interval { lower: down(self.lower / divisor.upper), upper }
    }

    fn is_zero(&self) -> bool {
        self.upper == 0.0
    }

    fn work(&self) -> usize {
        1
    }
}

impl Number for Interval {
    const EXACT: bool = false;

    fn one() -> Self {
        Interval::ONE
    }

    fn of(exact: &Ratio) -> Self {
        Interval::around(exact)
    }

    fn exceeds(&self, other: &Self) -> bool {
        self.lower > other.upper
    }

    fn low(&self) -> Self {
        Interval::point(self.lower)
    }

    fn high(&self) -> Self {
        Interval::point(self.upper)
    }

    fn between(low: &Self, high: &Self) -> Self {
        Interval { lower: low.lower, upper: high.upper.max(low.lower) }
    }

    fn excess(&self, other: &Self) -> Self {
        if self.upper <= other.lower {
            Interval::ZERO
        } else {
            Interval::point((self.upper - other.lower).next_up())
        }
    }

    fn complement(&self) -> Self {
        let rest =
            |x: f64, round: fn(f64) -> f64| if x == 0.0 || x == 1.0 { 1.0 - x } else { round(1.0 - x) };
        let lower = rest(self.upper.min(1.0), f64::next_down).max(0.0);
        Interval { lower, upper: rest(self.lower.min(1.0), f64::next_up).min(1.0) }
    }

    fn fractions(&self) -> (Ratio, Ratio) {
        let exact = |x: f64| Ratio::from_f64(x).unwrap_or_default();
        (exact(self.lower), exact(self.upper))
    }

    fn bounds(&self) -> Interval {
        *self
    }

    fn exact(&self) -> Option<&Ratio> {
        None
    }

    fn rounded(bounds: Interval) -> Option<Self> {
        Some(bounds)
    }
}

impl Weight for Ratio {
    /// Two vectors of digits with their headers; long fractions take more.
    const BYTES: usize = 128;

    fn zero() -> Self {
        Zero::zero()
    }

    fn plus(&self, other: &Self) -> Self {
        self + other
    }

    fn times(&self, other: &Self) -> Self {
        self * other
    }

    fn over(&self, divisor: &Self) -> Self {
        self / divisor
    }

    fn is_zero(&self) -> bool {
        Zero::is_zero(self)
    }

    fn work(&self) -> usize {
        // A bit takes about a nanosecond, as an entry of doubles does.
        (self.numer().bits() + self.denom().bits()) as usize
    }
}

impl Number for Ratio {
    const EXACT: bool = true;

    fn one() -> Self {
        One::one()
    }

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

    fn between(low: &Self, _: &Self) -> Self {
        low.clone()
    }

    fn excess(&self, other: &Self) -> Self {
        if self > other { self - other } else { Zero::zero() }
    }

    fn complement(&self) -> Self {
        <Ratio as One>::one() - self
    }

    fn fractions(&self) -> (Ratio, Ratio) {
        (self.clone(), self.clone())
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

impl Weight for f64 {
    fn zero() -> Self {
        0.0
    }

    fn plus(&self, other: &Self) -> Self {
        self + other
    }

    fn times(&self, other: &Self) -> Self {
        self * other
    }

    fn over(&self, divisor: &Self) -> Self {
        self / divisor
    }

    fn is_zero(&self) -> bool {
        *self == 0.0
    }

    fn work(&self) -> usize {
        1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
