//! Numbers of properties: intervals with outward rounding, and exact numbers where they are known.

use std::cmp::Ordering;

use meliora_base::exact::{self, Exact, Ratio, Real};
use meliora_base::interval::{Bounds, Interval};
use meliora_base::value::{Binary, EvalError, Unary};
use meliora_equations::Value;
use meliora_lang::ast::{BinaryOp, Function};

/// A number between two bounds, and the number itself if it is known exactly.
#[derive(Debug, Clone, PartialEq)]
pub struct Number {
    /// The bounds.
    pub interval: Interval,
    /// The exact number.
    pub exact: Option<Exact>,
}

impl Number {
    /// Returns an exact number.
    pub fn of(exact: Exact) -> Self {
        Number { interval: Interval::around_real(&exact.clone().into_real()), exact: Some(exact) }
    }

    /// Returns the exact number of a fraction.
    pub fn fraction(exact: &Ratio) -> Self {
        Number::of(Exact::Real(Real::Finite(exact.clone())))
    }

    /// Returns a number between bounds. Equal bounds leave one number.
    pub(super) fn between(interval: Interval) -> Self {
        let Interval { lower, upper } = interval;
        let exact = (lower == upper && lower.is_finite()).then(|| Exact::Real(Real::from(lower)));
        Number { interval, exact }
    }

    /// Returns whether the number is known to be undefined.
    pub fn is_undefined(&self) -> bool {
        matches!(self.exact, Some(Exact::Real(Real::Undefined)))
    }

    /// Returns how the number compares with another one; `None` if the bounds do not decide it.
    pub fn compare(&self, other: &Number) -> Option<Ordering> {
        if let (Some(x), Some(y)) = (&self.exact, &other.exact) {
            return x.clone().into_real().compare(&y.clone().into_real());
        }
        if self.interval.lower > other.interval.upper {
            return Some(Ordering::Greater);
        }
        (self.interval.upper < other.interval.lower).then_some(Ordering::Less)
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
        let (own, other) = (self.interval, other.interval);
        match op {
            BinaryOp::Le if own.upper <= other.lower => Some(true),
            BinaryOp::Ge if own.lower >= other.upper => Some(true),
            BinaryOp::Lt if own.lower >= other.upper => Some(false),
            BinaryOp::Gt if own.upper <= other.lower => Some(false),
            _ => None,
        }
    }

    /// Returns `-x`.
    pub fn negated(&self) -> Self {
        let exact = self.exact.clone().and_then(|x| exact::unary(Unary::Neg, x).ok());
        Number { interval: Interval { lower: -self.interval.upper, upper: -self.interval.lower }, exact }
    }

    /// Returns the smaller or the greater number.
    pub fn extreme(&self, other: &Number, greatest: bool) -> Self {
        match self.compare(other) {
            Some(order) if order.is_lt() == greatest && order.is_ne() => other.clone(),
            Some(_) => self.clone(),
            None => Number::between(self.interval.extreme(other.interval, greatest)),
        }
    }

    /// Returns the range of both numbers.
    pub fn range(&self, other: &Number) -> Self {
        let exact = if self.exact == other.exact { self.exact.clone() } else { None };
        Number { interval: self.interval.range(other.interval), exact }
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
        Ok(Number::between(self.interval.combine(op, other.interval)))
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
        let Interval { lower, upper } = self.interval;
        Ok(Number::between(Interval { lower: round(lower), upper: round(upper) }))
    }

    /// Returns 1 minus a probability.
    pub fn complemented(&self) -> Self {
        match &self.exact {
            Some(exact) => {
                let rest = exact::binary(Binary::Sub, &Exact::Int(1), exact);
                rest.map_or(Number::between(Interval { lower: 0.0, upper: 1.0 }), Number::of)
            }
            None => Number::between(self.interval.complement()),
        }
    }
}

impl From<Value> for Number {
    fn from(value: Value) -> Self {
        match value {
            Value::Infinite => Number::of(Exact::Real(Real::Infinite(false))),
            Value::Finite(Bounds { exact: Some(exact), .. }) => Number::fraction(&exact),
            Value::Finite(Bounds { interval, .. }) => Number::between(interval),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    type Comparison = fn(f64, f64) -> bool;

    const OPERATIONS: [fn(f64, f64) -> f64; 4] = [|x, y| x + y, |x, y| x - y, |x, y| x * y, |x, y| x / y];

    fn between(lower: f64, upper: f64) -> Number {
        Number::between(Interval { lower, upper })
    }

    /// All intervals with ends among a few numbers, and unbounded ones.
    fn intervals() -> Vec<Number> {
        let ends = [f64::NEG_INFINITY, -2.0, -1.0, 0.0, 0.5, 1.0, 3.0, f64::INFINITY];
        let from = |&lower: &f64| {
            ends.into_iter().filter(move |&upper| lower < upper).map(move |upper| between(lower, upper))
        };
        ends.iter().flat_map(from).collect()
    }

    /// The finite ends and the middle of an interval.
    fn members(of: &Number) -> Vec<f64> {
        let middle = f64::midpoint(of.interval.lower.max(-8.0), of.interval.upper.min(8.0));
        [of.interval.lower, middle, of.interval.upper].into_iter().filter(|x| x.is_finite()).collect()
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
                assert!(
                    found.interval.lower <= least && most <= found.interval.upper,
                    "{x:?} {op:?} {y:?}: {found:?}"
                );
                let is_finite = [x.interval.lower, x.interval.upper, y.interval.lower, y.interval.upper]
                    .iter()
                    .all(|end| end.is_finite());
                if is_finite && (op != BinaryOp::Div || y.interval.lower > 0.0 || y.interval.upper < 0.0) {
                    assert_eq!(
                        (found.interval.lower, found.interval.upper),
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
            let found = between(1.0, 2.0).arithmetic(BinaryOp::Div, &between(lower, upper)).unwrap();
            assert_eq!(
                (found.interval.lower, found.interval.upper),
                (f64::NEG_INFINITY, f64::INFINITY),
                "{lower} {upper}"
            );
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
        let finite = || {
            intervals().into_iter().filter(|x| x.interval.lower.is_finite() && x.interval.upper.is_finite())
        };
        for (x, y) in finite().flat_map(|x| finite().map(move |y| (x.clone(), y))) {
            for (op, holds) in ops {
                let all: Vec<bool> = pairs(&x, &y).into_iter().map(|(x, y)| holds(x, y)).collect();
                let agreed = all.iter().all(|&held| held == all[0]).then(|| all[0]);
                assert_eq!(x.satisfies(op, &y), agreed, "{x:?} {op:?} {y:?}");
            }
        }
    }
}
