//! The values that an expression may have in the states of a box, as bounds.

use meliora_base::exact::{self, Exact, Real};
use meliora_base::value::{EvalError, Type};
use meliora_model::expr::{Binary, Unary};

/// A set of values that contains all that an expression has in the states of a box.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Values {
    pub(crate) bounds: Bounds,
    /// True if the expression may have no value in some of the states.
    pub(crate) fails: bool,
}

/// The bounds of values.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Bounds {
    /// The integers from the first to the second; 0 and 1 stand for Booleans. None if the first is larger.
    Whole(i64, i64),
    /// The reals from the first to the second, which are finite or equal.
    Reals(Box<(Real, Real)>),
    /// All reals, also infinite and undefined ones.
    Any,
}

/// The bounds of nothing.
const NONE: Bounds = Bounds::Whole(1, 0);
/// All integers.
const ALL: Bounds = Bounds::Whole(i64::MIN, i64::MAX);
/// Both truth values.
const EITHER: Bounds = Bounds::Whole(0, 1);

impl Values {
    /// Returns the integers of a range.
    pub(crate) fn whole(low: i64, high: i64) -> Self {
        Values { bounds: Bounds::Whole(low, high), fails: false }
    }

    /// Returns the integers of a range, as far as they fit 64 bits: the others are no values.
    pub(crate) fn clipped(low: i128, high: i128) -> Self {
        let [least, most] = [i64::MIN, i64::MAX].map(i128::from);
        let clip = |x: i128| x.clamp(least, most) as i64;
        let fails = low < least || high > most;
        let bounds = if low > most || high < least { NONE } else { Bounds::Whole(clip(low), clip(high)) };
        Values { bounds, fails }
    }

    /// Returns the only value of an expression, if it has one.
    pub(crate) fn of(value: Result<Exact, EvalError>) -> Self {
        let bounds = match value {
            Ok(Exact::Bool(b)) => Bounds::Whole(b.into(), b.into()),
            Ok(Exact::Int(i)) => Bounds::Whole(i, i),
            Ok(Exact::Real(x)) => Bounds::Reals(Box::new((x.clone(), x))),
            Err(_) => return Values { bounds: NONE, fails: true },
        };
        Values { bounds, fails: false }
    }

    /// Returns the bounds of integers or Booleans.
    pub(crate) fn range(&self) -> (i64, i64) {
        match self.bounds {
            Bounds::Whole(low, high) => (low, high),
            Bounds::Reals(_) | Bounds::Any => (i64::MIN, i64::MAX),
        }
    }

    /// Returns whether a condition may be true, …
    pub(crate) fn may_hold(&self) -> bool {
        self.range().1 >= 1 && !self.is_none()
    }

    /// … and whether it may be false.
    pub(crate) fn may_not_hold(&self) -> bool {
        self.range().0 <= 0 && !self.is_none()
    }

    /// Returns whether the expression has no value in any of the states.
    fn is_none(&self) -> bool {
        matches!(self.bounds, Bounds::Whole(low, high) if low > high)
    }

    /// Returns the value, if it is the same in all of the states.
    pub(crate) fn known(&self, ty: Type) -> Option<Exact> {
        match &self.bounds {
            _ if !self.is_known() => None,
            Bounds::Whole(low, _) if ty == Type::Bool => Some(Exact::Bool(*low != 0)),
            Bounds::Whole(low, _) => Some(Exact::Int(*low)),
            Bounds::Reals(pair) => Some(Exact::Real(pair.0.clone())),
            Bounds::Any => None,
        }
    }

    /// Returns whether the value is the same in all of the states.
    pub(crate) fn is_known(&self) -> bool {
        !self.fails
            && match &self.bounds {
                Bounds::Whole(low, high) => low == high,
                Bounds::Reals(pair) => pair.0 == pair.1,
                Bounds::Any => false,
            }
    }

    /// Returns the finite bounds of reals.
    pub(crate) fn reals(&self) -> Option<(&Real, &Real)> {
        match &self.bounds {
            Bounds::Reals(pair) => pair.0.finite().and(pair.1.finite()).map(|_| (&pair.0, &pair.1)),
            Bounds::Whole(..) | Bounds::Any => None,
        }
    }

    fn failing(self, fails: bool) -> Self {
        Values { fails: self.fails || fails, ..self }
    }
}

impl From<Bounds> for Values {
    fn from(bounds: Bounds) -> Self {
        Values { bounds, fails: false }
    }
}

/// Returns the values of `op x`.
pub(crate) fn unary(op: Unary, ty: Type, x: &Values) -> Values {
    if let Some(value) = x.known(ty) {
        return Values::of(exact::unary(op, value));
    }
    let values = match (op, &x.bounds) {
        _ if x.is_none() => NONE.into(),
        (Unary::Not, &Bounds::Whole(low, high)) if ty == Type::Bool => Values::whole(1 - high, 1 - low),
        (Unary::Not, _) => EITHER.into(),
        (Unary::Neg, &Bounds::Whole(low, high)) => Values::clipped(-i128::from(high), -i128::from(low)),
        (Unary::ToReal, &Bounds::Whole(low, high)) => between(Real::from(low), Real::from(high)),
        (Unary::Floor | Unary::Ceil | Unary::Round, Bounds::Whole(..)) => x.clone(),
        (Unary::ToReal, _) => x.clone(),
        (Unary::Neg, _) => Bounds::Any.into(),
        (Unary::Floor | Unary::Ceil | Unary::Round, _) => rounded(op, x),
    };
    values.failing(x.fails)
}

/// Returns the values of `floor`, `ceil` or `round`, which do not fall as x rises.
fn rounded(op: Unary, x: &Values) -> Values {
    let round = |x: &Real| match exact::unary(op, Exact::Real(x.clone())) {
        Ok(Exact::Int(i)) => Some(i),
        _ => None,
    };
    let bounds = x.reals().and_then(|(low, high)| Some((round(low)?, round(high)?)));
    bounds.map_or(Values { bounds: ALL, fails: true }, |(low, high)| Values::whole(low, high))
}

/// Returns the values of `x op y`, whose operands are of type `ty`.
pub(crate) fn binary(op: Binary, ty: Type, x: &Values, y: &Values) -> Values {
    if let (Some(x), Some(y)) = (x.known(ty), y.known(ty)) {
        return Values::of(exact::binary(op, &x, &y));
    }
    let values = match (&x.bounds, &y.bounds) {
        _ if x.is_none() || y.is_none() => NONE.into(),
        (&Bounds::Whole(a, b), &Bounds::Whole(c, d)) => whole(op, (a, b), (c, d)),
        _ => reals(op, x, y),
    };
    values.failing(x.fails || y.fails)
}

/// Returns the values of an operation on integers or Booleans.
fn whole(op: Binary, x: (i64, i64), y: (i64, i64)) -> Values {
    let wide = |(low, high): (i64, i64)| (i128::from(low), i128::from(high));
    let (a, b) = (wide(x), wide(y));
    match op {
        Binary::Eq => truth(x == y && x.0 == x.1, x.1 < y.0 || y.1 < x.0),
        Binary::Lt => truth(x.1 < y.0, x.0 >= y.1),
        Binary::Le => truth(x.1 <= y.0, x.0 > y.1),
        Binary::Add => Values::clipped(a.0 + b.0, a.1 + b.1),
        Binary::Sub => Values::clipped(a.0 - b.1, a.1 - b.0),
        Binary::Mul => {
            let corners = [a.0 * b.0, a.0 * b.1, a.1 * b.0, a.1 * b.1];
            let fold = |pick: fn(i128, i128) -> i128| corners.into_iter().reduce(pick).unwrap_or(0);
            Values::clipped(fold(i128::min), fold(i128::max))
        }
        Binary::Min => Values::whole(x.0.min(y.0), x.1.min(y.1)),
        Binary::Max => Values::whole(x.0.max(y.0), x.1.max(y.1)),
        Binary::Mod if y.1 <= 0 => Values { bounds: NONE, fails: true },
        Binary::Mod => Values::whole(0, y.1 - 1).failing(y.0 <= 0),
        Binary::Index if x.1 < 0 || x.0 >= y.1 => Values { bounds: NONE, fails: true },
        Binary::Index => Values::whole(x.0.max(0), x.1.min(y.1 - 1)).failing(x.0 < 0 || x.1 >= y.0),
        Binary::Pow => Values { bounds: ALL, fails: true },
        Binary::And | Binary::Or => EITHER.into(),
        Binary::Div | Binary::Log => Values { bounds: Bounds::Any, fails: true },
    }
}

/// Returns the values of an operation on reals. The exact value of an arithmetic operation may have
/// too many bits in some of the states.
fn reals(op: Binary, x: &Values, y: &Values) -> Values {
    let bounds = x.reals().zip(y.reals());
    let on = |x: &Real, y: &Real| match exact::reals(op, x, y) {
        Ok(Exact::Real(value)) if value.finite().is_some() => Some(value),
        _ => None,
    };
    let found = match (op, bounds) {
        (Binary::Eq | Binary::Lt | Binary::Le, None) => return EITHER.into(),
        (Binary::Eq, Some((x, y))) => return truth(false, is_less(x.1, y.0) || is_less(y.1, x.0)),
        (Binary::Lt, Some((x, y))) => return truth(is_less(x.1, y.0), !is_less(x.0, y.1)),
        (Binary::Le, Some((x, y))) => return truth(!is_less(y.0, x.1), is_less(y.1, x.0)),
        (Binary::Add | Binary::Min | Binary::Max, Some((x, y))) => on(x.0, y.0).zip(on(x.1, y.1)),
        (Binary::Sub, Some((x, y))) => on(x.0, y.1).zip(on(x.1, y.0)),
        // A quotient by numbers of one sign rises or falls in each operand, as a product does.
        (Binary::Mul | Binary::Div, Some((x, y))) if op == Binary::Mul || has_sign(y) => {
            let corners = [(x.0, y.0), (x.0, y.1), (x.1, y.0), (x.1, y.1)].map(|(x, y)| on(x, y));
            let corners: Option<Vec<Real>> = corners.into_iter().collect();
            corners.and_then(extremes)
        }
        _ => None,
    };
    let bounds = found.map_or(Bounds::Any, |pair| Bounds::Reals(Box::new(pair)));
    Values { bounds, fails: !matches!(op, Binary::Min | Binary::Max) }
}

/// Returns whether all numbers between two are positive, or all are negative.
fn has_sign((low, high): (&Real, &Real)) -> bool {
    let zero = Real::from(0i64);
    is_less(&zero, low) || is_less(high, &zero)
}

fn extremes(values: Vec<Real>) -> Option<(Real, Real)> {
    let low = values.iter().reduce(|a, b| if is_less(b, a) { b } else { a })?.clone();
    let high = values.iter().reduce(|a, b| if is_less(a, b) { b } else { a })?.clone();
    Some((low, high))
}

fn is_less(x: &Real, y: &Real) -> bool {
    x.compare(y).is_some_and(|order| order.is_lt())
}

/// Returns the values of a condition that is known to be true, known to be false, or neither.
fn truth(holds: bool, fails: bool) -> Values {
    Values::whole(i64::from(holds), i64::from(!fails))
}

fn between(low: Real, high: Real) -> Values {
    Bounds::Reals(Box::new((low, high))).into()
}

/// Returns the values of `condition ? x : y`.
pub(crate) fn choice(condition: &Values, x: &Values, y: &Values) -> Values {
    let values = match (condition.may_hold(), condition.may_not_hold()) {
        (true, true) => joined(x, y),
        (true, false) => x.clone(),
        (false, true) => y.clone(),
        (false, false) => NONE.into(),
    };
    values.failing(condition.fails)
}

/// Returns the values of x and of y, and perhaps more.
fn joined(x: &Values, y: &Values) -> Values {
    let bounds = match (&x.bounds, &y.bounds) {
        _ if x.is_none() => y.bounds.clone(),
        _ if y.is_none() => x.bounds.clone(),
        (&Bounds::Whole(a, b), &Bounds::Whole(c, d)) => Bounds::Whole(a.min(c), b.max(d)),
        _ => match (x.reals(), y.reals()) {
            (Some((a, b)), Some((c, d))) => {
                let pair = extremes([a, b, c, d].map(Real::clone).to_vec());
                pair.map_or(Bounds::Any, |pair| Bounds::Reals(Box::new(pair)))
            }
            _ => Bounds::Any,
        },
    };
    Values { bounds, fails: x.fails || y.fails }
}

/// Returns the values of a list of conditions: `decisive` is the value of one at which evaluation
/// ends with this value, true for a disjunction and false for a conjunction.
pub(crate) fn list<'a>(decisive: bool, conditions: impl Iterator<Item = &'a Values>) -> Values {
    let (mut ends, mut fails) = (false, false);
    for x in conditions {
        fails |= x.fails;
        let (may_end, may_go_on) = match decisive {
            true => (x.may_hold(), x.may_not_hold()),
            false => (x.may_not_hold(), x.may_hold()),
        };
        ends |= may_end;
        if !may_go_on {
            let end = i64::from(decisive);
            return if ends { Values::whole(end, end) } else { NONE.into() }.failing(fails);
        }
    }
    let (decisive, other) = (i64::from(decisive), i64::from(!decisive));
    let end = if ends { decisive } else { other };
    Values::whole(end.min(other), end.max(other)).failing(fails)
}

/// Returns the values of Σ factor · x + constant, of which no part leaves 64 bits.
pub(crate) fn sum<'a>(terms: impl Iterator<Item = (i64, &'a Values)>, constant: i64) -> Values {
    let (mut low, mut high, mut fails) = (constant, constant, false);
    for (factor, x) in terms {
        if x.is_none() {
            return Values { bounds: NONE, fails: true };
        }
        let (least, most) = scaled(factor, x.range());
        (low, high, fails) = (low + least, high + most, fails || x.fails);
    }
    Values::whole(low, high).failing(fails)
}

/// Returns the least and the greatest product of a factor and a number of a range.
pub(crate) fn scaled(factor: i64, (low, high): (i64, i64)) -> (i64, i64) {
    if factor < 0 { (factor * high, factor * low) } else { (factor * low, factor * high) }
}
