//! Intervals of doubles, whose arithmetic rounds outwards.

use std::cmp::Ordering;

use num_rational::BigRational;
use num_traits::{FromPrimitive, One, ToPrimitive};

use super::exact::{Ratio, Real};
use super::number::Number;
use super::value::Binary;

/// The width of a value that is usually enough, absolute for probabilities, relative above 1 for
/// rewards.
pub const PRECISION: f64 = 1e-6;

/// Lower and upper bound of a number; both may be infinite.
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
    /// All numbers.
    pub const ALL: Interval = Interval { lower: f64::NEG_INFINITY, upper: f64::INFINITY };

    /// Returns the interval of one double.
    #[inline]
    pub const fn point(x: f64) -> Self {
        Interval { lower: x, upper: x }
    }

    /// Returns the smallest interval that contains a fraction.
    pub fn around(exact: &Ratio) -> Self {
        let near = exact.to_f64().unwrap_or(f64::MAX).clamp(f64::MIN, f64::MAX);
        let compare = |x: f64| BigRational::from_f64(x).map(|x| x.cmp(exact));
        let (mut lower, mut upper) = (near, near);
        while lower > f64::NEG_INFINITY && compare(lower).is_none_or(Ordering::is_gt) {
            lower = lower.next_down();
        }
        while upper < f64::INFINITY && compare(upper).is_none_or(Ordering::is_lt) {
            upper = upper.next_up();
        }
        Interval { lower, upper }
    }

    /// Returns the smallest interval that contains a real; all numbers for an undefined one.
    pub fn around_real(exact: &Real) -> Self {
        match exact {
            Real::Finite(exact) => Interval::around(exact),
            Real::Infinite(_) => Interval::point(exact.to_f64()),
            Real::Undefined => Interval::ALL,
        }
    }

    /// Returns the distance of the bounds.
    pub fn width(self) -> f64 {
        if self.lower == self.upper { 0.0 } else { self.upper - self.lower }
    }

    /// Returns the width, divided by the size of the lower bound where that is above 1.
    pub fn relative_width(self) -> f64 {
        self.width() / self.lower.abs().max(1.0)
    }

    /// Returns the number in the middle.
    pub fn middle(self) -> f64 {
        f64::midpoint(self.lower, self.upper)
    }

    /// Returns 1 minus a probability.
    #[must_use]
    pub fn complement(self) -> Self {
        let rest =
            |x: f64, round: fn(f64) -> f64| if x == 0.0 || x == 1.0 { 1.0 - x } else { round(1.0 - x) };
        let lower = rest(self.upper.min(1.0), f64::next_down).max(0.0);
        Interval { lower, upper: rest(self.lower.min(1.0), f64::next_up).min(1.0) }
    }

    /// Returns the bounds of the greater or the smaller one of two numbers.
    #[must_use]
    #[inline]
    pub fn extreme(self, other: Self, greatest: bool) -> Self {
        let side = if greatest { f64::max } else { f64::min };
        Interval { lower: side(self.lower, other.lower), upper: side(self.upper, other.upper) }
    }

    /// Returns the smallest interval that contains two.
    #[must_use]
    pub fn range(self, other: Self) -> Self {
        Interval { lower: self.lower.min(other.lower), upper: self.upper.max(other.upper) }
    }

    /// Computes `self op other`, of numbers that may be negative; all numbers where nothing is known.
    #[must_use]
    pub fn combine(self, op: Binary, other: Self) -> Self {
        match op {
            Binary::Add => self.by_corners(other, |x, y| x + y),
            Binary::Sub => self.by_corners(other, |x, y| x - y),
            Binary::Mul => self.by_corners(other, |x, y| x * y),
            Binary::Div if other.lower > 0.0 || other.upper < 0.0 => self.by_corners(other, |x, y| x / y),
            // Powers and logarithms of doubles are near the true ones.
            Binary::Pow if self.lower >= 0.0 => self.by_corners(other, f64::powf).widened(),
            Binary::Log if self.lower > 0.0 && other.lower > 1.0 => {
                self.by_corners(other, |x, b| x.ln() / b.ln()).widened()
            }
            _ => Interval::ALL,
        }
    }

    /// Bounds an operation by its results for the ends of the intervals.
    fn by_corners(self, other: Self, f: fn(f64, f64) -> f64) -> Self {
        let all = [self.lower, self.upper].map(|x| [f(x, other.lower), f(x, other.upper)]);
        let all = all.as_flattened();
        if all.iter().any(|x| x.is_nan()) {
            return Interval::ALL;
        }
        let least = all.iter().copied().fold(f64::INFINITY, f64::min);
        let greatest = all.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        Interval { lower: least.next_down(), upper: greatest.next_up() }
    }

    /// Widens the bounds by the error of an elementary function.
    fn widened(self) -> Self {
        let slack = |x: f64| x.abs() * 4.0 * f64::EPSILON + f64::MIN_POSITIVE;
        Interval { lower: self.lower - slack(self.lower), upper: self.upper + slack(self.upper) }
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
    pub fn of<N: Number>(number: &N) -> Self {
        Bounds { interval: number.bounds(), exact: number.exact().cloned() }
    }

    /// Returns the bounds of a number that is at most `most`.
    #[must_use]
    pub fn at_most(mut self, most: f64) -> Self {
        self.interval.upper = self.interval.upper.min(most);
        self
    }

    /// Returns 1 minus a probability.
    #[must_use]
    pub fn complement(self) -> Self {
        Bounds { interval: self.interval.complement(), exact: self.exact.map(|exact| Ratio::one() - exact) }
    }

    /// Lowers the lower bound of a number of which a loss is possible.
    pub fn lose(&mut self, loss: f64) {
        if loss > 0.0 {
            self.interval.lower = (self.interval.lower - loss).next_down().max(0.0);
        }
    }

    /// Returns the number in the middle.
    pub fn middle(&self) -> f64 {
        self.interval.middle()
    }

    /// Returns the bounds 0 and `upper`.
    pub fn any(upper: f64) -> Self {
        Bounds { interval: Interval { lower: 0.0, upper }, exact: None }
    }

    /// Returns the bounds of a whole number.
    pub fn point(x: u8) -> Self {
        Bounds { interval: Interval::point(f64::from(x)), exact: Some(Ratio::from_integer(x.into())) }
    }
}
