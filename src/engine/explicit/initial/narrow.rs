//! The consequences of a condition for the variables in a box.

use super::net::{Net, Op, Place};
use super::values::{Bounds, Values, scaled};
use meliora_base::exact::{self, Exact, Real};
use meliora_base::value::Type;
use meliora_model::expr::{Binary, Unary};

/// The sign that a condition is true in no state of a box.
#[derive(Debug)]
pub(super) struct Contradiction;

type Result = std::result::Result<(), Contradiction>;

/// The values of all items in the states in which a condition is true.
struct Narrowing<'a> {
    net: &'a Net,
    values: &'a mut [Values],
    /// For each item whether it has a value in each of these states.
    needed: Vec<bool>,
}

/// Narrows the values of all items in a box to those in the states in which the condition is true, from
/// the condition down to the variables. Calls `found` with each variable that it reaches, and its bounds.
///
/// # Errors
/// The condition is true in none of them.
pub(super) fn narrow(net: &Net, values: &mut [Values], mut found: impl FnMut(usize, (i64, i64))) -> Result {
    let Some(last) = net.items.len().checked_sub(1) else { return Ok(()) };
    let mut narrowing = Narrowing { net, values, needed: vec![false; net.items.len()] };
    narrowing.require(last as Place, (1, 1))?;
    for place in (0..=last).rev() {
        if narrowing.needed[place] {
            let range = narrowing.range(place as Place);
            match net.items[place].op {
                Op::Var(v) => found(v, range),
                _ => narrowing.pass_on(place, range)?,
            }
        }
    }
    Ok(())
}

impl Narrowing<'_> {
    fn range(&self, place: Place) -> (i64, i64) {
        self.values[place as usize].range()
    }

    fn ty(&self, place: Place) -> Type {
        self.net.items[place as usize].ty
    }

    /// Narrows the values of an item to a range.
    fn require(&mut self, place: Place, (low, high): (i64, i64)) -> Result {
        self.needed[place as usize] = true;
        if let Bounds::Whole(least, most) = &mut self.values[place as usize].bounds {
            (*least, *most) = ((*least).max(low), (*most).min(high));
            if *least > *most {
                return Err(Contradiction);
            }
        }
        Ok(())
    }

    /// Narrows the values of an item to a range of wider numbers.
    fn require_wide(&mut self, place: Place, (low, high): (i128, i128)) -> Result {
        match Values::clipped(low, high).bounds {
            Bounds::Whole(low, high) if low <= high => self.require(place, (low, high)),
            _ => Err(Contradiction),
        }
    }

    /// Narrows the operands of an item with a value in a range.
    fn pass_on(&mut self, place: usize, (low, high): (i64, i64)) -> Result {
        let net = self.net;
        match &net.items[place].op {
            Op::Known(_) | Op::Var(_) => Ok(()),
            Op::List(decisive, operands) => self.list(*decisive, operands, (low, high)),
            Op::Sum(terms, constant) => self.sum(terms, *constant, (low, high)),
            &Op::Unary(Unary::Not, a) if self.ty(a) == Type::Bool => self.require(a, (1 - high, 1 - low)),
            &Op::Unary(Unary::Neg, a) if self.ty(a) == Type::Int => {
                self.require_wide(a, (-i128::from(high), -i128::from(low)))
            }
            &Op::Binary(op, a, b) => self.binary(op, (a, b), (low, high)),
            &Op::Ite(c, a, b) => self.choice(c, a, b, (low, high)),
            Op::Unary(..) => Ok(()),
        }
    }

    fn list(&mut self, decisive: bool, operands: &[Place], (low, high): (i64, i64)) -> Result {
        let (end, other) = (i64::from(decisive), i64::from(!decisive));
        if (low, high) == (other, other) {
            return operands.iter().try_for_each(|&a| self.require(a, (other, other)));
        }
        let may_end = |&place: &usize| {
            let (low, high) = self.range(operands[place]);
            (low..=high).contains(&end)
        };
        let mut candidates = (0..operands.len()).filter(may_end);
        let (first, second) = (candidates.next(), candidates.next());
        if (low, high) != (end, end) || second.is_some() {
            return Ok(());
        }
        // The only operand that may decide does so, and those before it do not.
        let only = first.ok_or(Contradiction)?;
        operands[..only].iter().try_for_each(|&a| self.require(a, (other, other)))?;
        self.require(operands[only], (end, end))
    }

    fn sum(&mut self, terms: &[(i64, Place)], constant: i64, (low, high): (i64, i64)) -> Result {
        let wide = |(low, high): (i64, i64)| (i128::from(low), i128::from(high));
        let (low, high) = wide((low, high));
        let (mut least, mut most) = wide((constant, constant));
        for &(factor, a) in terms {
            let own = wide(scaled(factor, self.range(a)));
            (least, most) = (least + own.0, most + own.1);
        }
        for &(factor, a) in terms.iter().filter(|(factor, _)| *factor != 0) {
            let own = wide(scaled(factor, self.range(a)));
            // The bounds of factor · operand, given those of all others.
            let (from, to) = (low - (most - own.1), high - (least - own.0));
            let by = i128::from(factor.unsigned_abs());
            let (from, to) = if factor < 0 { (-to, -from) } else { (from, to) };
            let up = |x: i128| -(-x).div_euclid(by);
            self.require_wide(a, (up(from), to.div_euclid(by)))?;
            // The narrower bounds count for the others at once.
            let new = wide(scaled(factor, self.range(a)));
            (least, most) = (least - own.0 + new.0, most - own.1 + new.1);
        }
        Ok(())
    }

    fn binary(&mut self, op: Binary, (a, b): (Place, Place), (low, high): (i64, i64)) -> Result {
        let holds = (low == high).then_some(low == 1);
        if self.ty(a) == Type::Real {
            return holds.map_or(Ok(()), |holds| self.compare_reals(op, (a, b), holds));
        }
        match (op, holds) {
            (Binary::Eq, Some(true)) => self.equal(a, b),
            (Binary::Eq, Some(false)) => self.differ(a, b).and_then(|()| self.differ(b, a)),
            (Binary::Le, Some(true)) => self.ordered(a, b, 0),
            (Binary::Lt, Some(true)) => self.ordered(a, b, 1),
            (Binary::Le, Some(false)) => self.ordered(b, a, 1),
            (Binary::Lt, Some(false)) => self.ordered(b, a, 0),
            (Binary::Max, _) => self.extreme((a, b), (i64::MIN, high), (low, i64::MAX)),
            (Binary::Min, _) => self.extreme((a, b), (low, i64::MAX), (i64::MIN, high)),
            (Binary::Mul, _) => {
                self.factor(a, b, (low, high))?;
                self.factor(b, a, (low, high))
            }
            _ => Ok(()),
        }
    }

    fn equal(&mut self, a: Place, b: Place) -> Result {
        self.require(a, self.range(b))?;
        self.require(b, self.range(a))
    }

    /// Takes the only value of `a`, if there is one, from the bounds of `b`.
    fn differ(&mut self, a: Place, b: Place) -> Result {
        let ((value, last), (low, high)) = (self.range(a), self.range(b));
        let low = if value == last && value == low { low.checked_add(1) } else { Some(low) };
        let high = if value == last && value == high { high.checked_sub(1) } else { Some(high) };
        self.require(b, low.zip(high).ok_or(Contradiction)?)
    }

    /// Requires `a + by <= b`.
    fn ordered(&mut self, a: Place, b: Place, by: i64) -> Result {
        let high = self.range(b).1.checked_sub(by).ok_or(Contradiction)?;
        self.require(a, (i64::MIN, high))?;
        let low = self.range(a).0.checked_add(by).ok_or(Contradiction)?;
        self.require(b, (low, i64::MAX))
    }

    /// Requires a range of both operands, and another one of one of them.
    fn extreme(&mut self, (a, b): (Place, Place), both: (i64, i64), one: (i64, i64)) -> Result {
        self.require(a, both)?;
        self.require(b, both)?;
        let may = |(low, high): (i64, i64)| low.max(one.0) <= high.min(one.1);
        match (may(self.range(a)), may(self.range(b))) {
            (true, true) => Ok(()),
            (true, false) => self.require(a, one),
            (_, _) => self.require(b, one),
        }
    }

    /// Narrows the factor `a` of a product `a · b` of numbers that are not negative.
    fn factor(&mut self, a: Place, b: Place, (low, high): (i64, i64)) -> Result {
        let (own, other) = (self.range(a), self.range(b));
        if own.0 < 0 || other.0 < 0 || high < 0 {
            return Ok(());
        }
        let most = high.checked_div(other.0).unwrap_or(i64::MAX);
        let least = match other.1 {
            0 => 0,
            by => low.max(0) / by + i64::from(low.max(0) % by != 0),
        };
        self.require(a, (least, most))
    }

    /// Narrows the operands of a comparison of reals, if they are integers.
    fn compare_reals(&mut self, op: Binary, (a, b): (Place, Place), holds: bool) -> Result {
        let bounds = |place: Place| self.values[place as usize].reals();
        let bounds_of = |place| bounds(place).map(|(low, high)| (low.clone(), high.clone()));
        let (first, second) = (bounds_of(a), bounds_of(b));
        let (less, more) = match (op, holds) {
            (Binary::Eq, true) => {
                for (place, other) in [(a, &second), (b, &first)] {
                    if let Some((low, high)) = other {
                        self.integer(place, (Some(low), Some(high)))?;
                    }
                }
                return Ok(());
            }
            (Binary::Lt | Binary::Le, true) => ((a, first), (b, second)),
            // Undefined numbers are not in order either.
            (Binary::Lt | Binary::Le, false) if first.is_some() && second.is_some() => {
                ((b, second), (a, first))
            }
            _ => return Ok(()),
        };
        if let Some((_, high)) = more.1 {
            self.integer(less.0, (None, Some(&high)))?;
        }
        if let Some((low, _)) = less.1 {
            self.integer(more.0, (Some(&low), None))?;
        }
        Ok(())
    }

    /// Narrows an integer that is compared as a real, to bounds.
    fn integer(&mut self, place: Place, (low, high): (Option<&Real>, Option<&Real>)) -> Result {
        let Op::Unary(Unary::ToReal, a) = self.net.items[place as usize].op else { return Ok(()) };
        let whole = |op, x: Option<&Real>| match exact::unary(op, Exact::Real(x?.clone())) {
            Ok(Exact::Int(i)) => Some(i),
            _ => None,
        };
        let low = whole(Unary::Ceil, low).unwrap_or(i64::MIN);
        self.require(a, (low, whole(Unary::Floor, high).unwrap_or(i64::MAX)))
    }

    fn choice(&mut self, c: Place, a: Place, b: Place, range: (i64, i64)) -> Result {
        let may = |place| {
            let (low, high) = self.range(place);
            low.max(range.0) <= high.min(range.1)
        };
        let condition = self.range(c);
        let (first, second) = (condition.1 == 1 && may(a), condition.0 == 0 && may(b));
        match (first, second) {
            (true, true) => self.require(c, condition),
            (true, false) => self.require(c, (1, 1)).and_then(|()| self.require(a, range)),
            (false, true) => self.require(c, (0, 0)).and_then(|()| self.require(b, range)),
            (false, false) => Err(Contradiction),
        }
    }
}
