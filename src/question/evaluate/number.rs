//! Numbers of properties: intervals with outward rounding, and exact numbers where they are known.

use std::cmp::Ordering;

use meliora_base::exact::{self, Exact, Ratio, Real};
use meliora_base::value::{Binary, EvalError, Unary};
use meliora_lang::ast::{BinaryOp, Function};
use meliora_quantities::path_values::Value;
use meliora_quantities::{Bounds, Interval};

/// A number between two bounds, and the number itself if it is known exactly.
#[derive(Debug, Clone, PartialEq)]
pub struct Number {
    /// The lower bound.
    pub lower: f64,
    /// The upper bound.
    pub upper: f64,
    /// The exact number.
    pub exact: Option<Exact>,
}

impl Number {
    /// Returns an exact number.
    pub fn of(exact: Exact) -> Self {
        let (lower, upper) = around(&exact.clone().into_real());
        Number { lower, upper, exact: Some(exact) }
    }

    /// Returns the exact number of a fraction.
    pub fn fraction(exact: &Ratio) -> Self {
        Number::of(Exact::Real(Real::Finite(exact.clone())))
    }

    pub(super) fn between(lower: f64, upper: f64) -> Self {
        // An undefined bound says nothing.
        let lower = if lower.is_nan() { f64::NEG_INFINITY } else { lower };
        let upper = if upper.is_nan() { f64::INFINITY } else { upper };
        // Equal bounds leave one number.
        let exact = (lower == upper && lower.is_finite()).then(|| Exact::Real(Real::from(lower)));
        Number { lower, upper, exact }
    }

    /// Returns whether the number is known to be undefined.
    pub fn is_undefined(&self) -> bool {
        matches!(self.exact, Some(Exact::Real(Real::Undefined)))
    }

    /// Returns the width, divided by the size of the number where that is above 1.
    pub fn width(&self) -> f64 {
        let width = if self.lower == self.upper { 0.0 } else { self.upper - self.lower };
        width / self.lower.abs().max(1.0)
    }

    /// Returns how the number compares with another one; `None` if the bounds do not decide it.
    pub fn compare(&self, other: &Number) -> Option<Ordering> {
        if let (Some(x), Some(y)) = (&self.exact, &other.exact) {
            return x.clone().into_real().compare(&y.clone().into_real());
        }
        if self.lower > other.upper {
            return Some(Ordering::Greater);
        }
        (self.upper < other.lower).then_some(Ordering::Less)
    }

    /// Returns whether a comparison is true; `None` if the bounds do not decide it.
    pub fn satisfies(&self, op: BinaryOp, other: &Number) -> Option<bool> {
        if let Some(order) = self.compare(other) {
            return Some(match op {
                BinaryOp::Eq => order.is_eq(),
                BinaryOp::Ne => order.is_ne(),
                BinaryOp::Lt => order.is_lt(),
                BinaryOp::Le => order.is_le(),
                BinaryOp::Gt => order.is_gt(),
                _ => order.is_ge(),
            });
        }
        match op {
            BinaryOp::Le if self.upper <= other.lower => Some(true),
            BinaryOp::Ge if self.lower >= other.upper => Some(true),
            BinaryOp::Lt if self.lower >= other.upper => Some(false),
            BinaryOp::Gt if self.upper <= other.lower => Some(false),
            _ => None,
        }
    }

    /// Returns `-x`.
    pub fn negated(&self) -> Self {
        let exact = self.exact.clone().and_then(|x| exact::unary(Unary::Neg, x).ok());
        Number { lower: -self.upper, upper: -self.lower, exact }
    }

    /// Returns the smaller or the greater number.
    pub fn extreme(&self, other: &Number, greatest: bool) -> Self {
        match self.compare(other) {
            Some(order) if order.is_lt() == greatest && order.is_ne() => other.clone(),
            Some(_) => self.clone(),
            None if greatest => Number::between(self.lower.max(other.lower), self.upper.max(other.upper)),
            None => Number::between(self.lower.min(other.lower), self.upper.min(other.upper)),
        }
    }

    /// Returns the range of both numbers.
    pub fn range(&self, other: &Number) -> Self {
        let exact = if self.exact == other.exact { self.exact.clone() } else { None };
        Number { lower: self.lower.min(other.lower), upper: self.upper.max(other.upper), exact }
    }

    /// Returns the result of arithmetic.
    ///
    /// # Errors
    /// The operation has no value.
    pub fn arithmetic(&self, op: BinaryOp, other: &Number) -> Result<Self, EvalError> {
        let binary = match op {
            BinaryOp::Add => Binary::Add,
            BinaryOp::Sub => Binary::Sub,
            BinaryOp::Mul => Binary::Mul,
            BinaryOp::Div => Binary::Div,
            _ => Binary::Pow,
        };
        self.binary(binary, other)
    }

    fn binary(&self, op: Binary, other: &Number) -> Result<Self, EvalError> {
        if let (Some(x), Some(y)) = (&self.exact, &other.exact) {
            return exact::binary(op, x, y).map(Number::of);
        }
        let corners = |f: fn(f64, f64) -> f64| {
            let all = [
                (self.lower, other.lower),
                (self.lower, other.upper),
                (self.upper, other.lower),
                (self.upper, other.upper),
            ];
            let all = all.map(|(x, y)| f(x, y));
            if all.iter().any(|x| x.is_nan()) {
                return Number::between(f64::NAN, f64::NAN);
            }
            let least = all.iter().copied().fold(f64::INFINITY, f64::min);
            let greatest = all.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            Number::between(least.next_down(), greatest.next_up())
        };
        Ok(match op {
            Binary::Add => corners(|x, y| x + y),
            Binary::Sub => corners(|x, y| x - y),
            Binary::Mul => corners(|x, y| x * y),
            Binary::Div if other.lower > 0.0 || other.upper < 0.0 => corners(|x, y| x / y),
            // Powers and logarithms of doubles are near the true ones.
            Binary::Pow if self.lower >= 0.0 => corners(f64::powf).widened(),
            Binary::Log if self.lower > 0.0 && other.lower > 1.0 => corners(|x, b| x.ln() / b.ln()).widened(),
            _ => Number::between(f64::NAN, f64::NAN),
        })
    }

    /// Widens the bounds by the error of an elementary function.
    fn widened(self) -> Self {
        let slack = |x: f64| x.abs() * 4.0 * f64::EPSILON + f64::MIN_POSITIVE;
        Number::between(self.lower - slack(self.lower), self.upper + slack(self.upper))
    }

    /// Returns the value of a function.
    ///
    /// # Errors
    /// The operation has no value.
    pub fn apply(function: Function, arguments: &[Number]) -> Result<Self, EvalError> {
        let Some((first, rest)) = arguments.split_first() else { return Err(EvalError::NotFinite) };
        let second = rest.first().unwrap_or(first);
        match function {
            Function::Min => Ok(rest.iter().fold(first.clone(), |all, x| all.extreme(x, false))),
            Function::Max => Ok(rest.iter().fold(first.clone(), |all, x| all.extreme(x, true))),
            Function::Pow => first.binary(Binary::Pow, second),
            Function::Mod => first.binary(Binary::Mod, second),
            Function::Log => first.binary(Binary::Log, second),
            Function::Floor => first.whole(Unary::Floor, f64::floor),
            Function::Ceil => first.whole(Unary::Ceil, f64::ceil),
            Function::Round => first.whole(Unary::Round, |x| (x + 0.5).floor()),
            _ => Err(EvalError::NotFinite),
        }
    }

    fn whole(&self, op: Unary, round: fn(f64) -> f64) -> Result<Self, EvalError> {
        if let Some(exact) = &self.exact {
            return exact::unary(op, exact.clone()).map(Number::of);
        }
        Ok(Number::between(round(self.lower), round(self.upper)))
    }

    /// Returns 1 minus a probability.
    pub fn complemented(&self) -> Self {
        let one = Number::of(Exact::Int(1));
        match one.binary(Binary::Sub, self) {
            Ok(rest) => Number { lower: rest.lower.max(0.0), upper: rest.upper.min(1.0), ..rest },
            Err(_) => Number::between(0.0, 1.0),
        }
    }
}

impl From<Value> for Number {
    fn from(value: Value) -> Self {
        match value {
            Value::Infinite => Number::of(Exact::Real(Real::Infinite(false))),
            Value::Finite(Bounds { exact: Some(exact), .. }) => Number::fraction(&exact),
            Value::Finite(Bounds { interval: Interval { lower, upper }, .. }) => {
                Number::between(lower, upper)
            }
        }
    }
}

/// Returns doubles around a number.
fn around(exact: &Real) -> (f64, f64) {
    let near = exact.to_f64();
    match Real::from(near).compare(exact) {
        Some(Ordering::Equal) => (near, near),
        Some(Ordering::Less) => (near, near.next_up()),
        Some(Ordering::Greater) => (near.next_down(), near),
        None => (f64::NEG_INFINITY, f64::INFINITY),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    type Comparison = fn(f64, f64) -> bool;

    const OPERATIONS: [fn(f64, f64) -> f64; 4] = [|x, y| x + y, |x, y| x - y, |x, y| x * y, |x, y| x / y];

    /// All intervals with ends among a few numbers, and unbounded ones.
    fn intervals() -> Vec<Number> {
        let ends = [f64::NEG_INFINITY, -2.0, -1.0, 0.0, 0.5, 1.0, 3.0, f64::INFINITY];
        let from = |&lower: &f64| {
            ends.into_iter()
                .filter(move |&upper| lower < upper)
                .map(move |upper| Number::between(lower, upper))
        };
        ends.iter().flat_map(from).collect()
    }

    /// The finite ends and the middle of an interval.
    fn members(of: &Number) -> Vec<f64> {
        let middle = f64::midpoint(of.lower.max(-8.0), of.upper.min(8.0));
        [of.lower, middle, of.upper].into_iter().filter(|x| x.is_finite()).collect()
    }

    fn pairs(x: &Number, y: &Number) -> Vec<(f64, f64)> {
        members(x).into_iter().flat_map(|x| members(y).into_iter().map(move |y| (x, y))).collect()
    }

    #[test]
    fn arithmetic_contains_what_its_members_give_and_little_else() {
        let ops = [BinaryOp::Add, BinaryOp::Sub, BinaryOp::Mul, BinaryOp::Div];
        for (op, by_members) in ops.into_iter().zip(OPERATIONS) {
            for (x, y) in
                intervals().iter().flat_map(|x| intervals().into_iter().map(move |y| (x.clone(), y)))
            {
                let found = x.arithmetic(op, &y).unwrap();
                let all = pairs(&x, &y).into_iter().map(|(x, y)| by_members(x, y)).filter(|z| !z.is_nan());
                let (least, most) =
                    all.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), z| (low.min(z), high.max(z)));
                assert!(found.lower <= least && most <= found.upper, "{x:?} {op:?} {y:?}: {found:?}");
                let is_finite = [x.lower, x.upper, y.lower, y.upper].iter().all(|end| end.is_finite());
                if is_finite && (op != BinaryOp::Div || y.lower > 0.0 || y.upper < 0.0) {
                    assert_eq!(
                        (found.lower, found.upper),
                        (least.next_down(), most.next_up()),
                        "{x:?} {op:?} {y:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn a_divisor_that_may_be_zero_leaves_no_bound() {
        for (lower, upper) in [(0.0, 1.0), (-1.0, 0.0), (-1.0, 1.0)] {
            let found =
                Number::between(1.0, 2.0).arithmetic(BinaryOp::Div, &Number::between(lower, upper)).unwrap();
            assert_eq!((found.lower, found.upper), (f64::NEG_INFINITY, f64::INFINITY), "{lower} {upper}");
        }
    }

    #[test]
    fn a_comparison_is_decided_if_all_members_agree() {
        let ops: [(BinaryOp, Comparison); 4] = [
            (BinaryOp::Lt, |x, y| x < y),
            (BinaryOp::Le, |x, y| x <= y),
            (BinaryOp::Gt, |x, y| x > y),
            (BinaryOp::Ge, |x, y| x >= y),
        ];
        let finite = || intervals().into_iter().filter(|x| x.lower.is_finite() && x.upper.is_finite());
        for (x, y) in finite().flat_map(|x| finite().map(move |y| (x.clone(), y))) {
            for (op, holds) in ops {
                let all: Vec<bool> = pairs(&x, &y).into_iter().map(|(x, y)| holds(x, y)).collect();
                let agreed = all.iter().all(|&held| held == all[0]).then(|| all[0]);
                assert_eq!(x.satisfies(op, &y), agreed, "{x:?} {op:?} {y:?}");
            }
        }
    }
}
