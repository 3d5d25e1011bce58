//! The questions of operators: which strategies count, and whether numbers are needed.

use num_traits::{One, Zero};

use super::operators::Extreme;
use super::term::Measured;
use super::{Bound, Inequality, Measure, Optimum, Quantity, Question, Strategies};
use meliora_base::exact::Ratio;

/// Returns the question of a comparison of a probability with a number. Without a name, the bound
/// must hold for every strategy.
pub(crate) fn compared(extreme: Extreme, comparison: Inequality, value: Ratio) -> Question {
    let optimum = optimum(extreme, Some(comparison), false);
    question(Measure::Probability, optimum, Some((comparison, value)))
}

/// Returns a quantity. A bound without a name must hold for every strategy: a lower bound for the
/// minimum, an upper bound for the maximum.
pub(crate) fn quantity(measure: Measure, extreme: Extreme, bound: Option<(Inequality, Ratio)>) -> Quantity {
    let optimum = optimum(extreme, bound.as_ref().map(|(comparison, _)| *comparison), false);
    Quantity { measure, optimum, bound }
}

/// Returns the strategies of an operator; `None` if it does not say. A bound without a name must hold for
/// every strategy, or for some: a lower bound for the minimum, or the maximum.
pub(super) fn optimum(extreme: Extreme, bound: Option<Inequality>, some: bool) -> Option<Optimum> {
    match (extreme, bound) {
        (Extreme::Min, _) => Some(Optimum::Min),
        (Extreme::Max, _) => Some(Optimum::Max),
        (Extreme::Unnamed, None) => None,
        (Extreme::Unnamed, Some(Inequality::Ge | Inequality::Gt)) if some => Some(Optimum::Max),
        (Extreme::Unnamed, Some(Inequality::Ge | Inequality::Gt)) => Some(Optimum::Min),
        (Extreme::Unnamed, Some(_)) if some => Some(Optimum::Min),
        (Extreme::Unnamed, Some(_)) => Some(Optimum::Max),
    }
}

/// Returns the question of an operator: one without numbers if the bound is 0 or 1.
pub(super) fn question(
    measure: Measure,
    optimum: Option<Optimum>,
    bound: Option<(Inequality, Ratio)>,
) -> Question {
    let (Measure::Probability, Some(optimum), Some((comparison, value))) = (&measure, optimum, &bound) else {
        return Question::Quantity(Quantity { measure, optimum, bound });
    };
    let qualitative = match comparison {
        Inequality::Ge if value.is_one() => Bound::One,
        Inequality::Gt if value.is_zero() => Bound::Positive,
        Inequality::Lt if value.is_one() => Bound::BelowOne,
        Inequality::Le if value.is_zero() => Bound::Zero,
        _ => return Question::Quantity(Quantity { measure, optimum: Some(optimum), bound }),
    };
    // The minimum is at least b if the probability of every strategy is; the maximum, if that of
    // some strategy is.
    let from_below = matches!(qualitative, Bound::One | Bound::Positive);
    let strategies = match optimum {
        Optimum::Max if from_below => Strategies::Some,
        Optimum::Min if !from_below => Strategies::Some,
        _ => Strategies::All,
    };
    Question::Qualitative(strategies, qualitative)
}

/// Returns the optimum and the comparison of a question without numbers: what [`question`] is made of.
pub(super) fn bound_of(strategies: Strategies, likely: Bound) -> (Optimum, Option<(Inequality, Ratio)>) {
    let (comparison, value) = match likely {
        Bound::One => (Inequality::Ge, Ratio::one()),
        Bound::Positive => (Inequality::Gt, Ratio::zero()),
        Bound::BelowOne => (Inequality::Lt, Ratio::one()),
        Bound::Zero => (Inequality::Le, Ratio::zero()),
    };
    let from_below = matches!(likely, Bound::One | Bound::Positive);
    let is_max = (strategies == Strategies::Some) == from_below;
    (if is_max { Optimum::Max } else { Optimum::Min }, Some((comparison, value)))
}

impl Measured {
    /// Returns the truth of a bound that all probabilities satisfy, or none.
    pub fn trivial(&self) -> Option<bool> {
        let (comparison, bound) = self.bound.as_ref()?;
        match comparison {
            Inequality::Ge if bound.is_zero() => Some(true),
            Inequality::Le if bound.is_one() => Some(true),
            Inequality::Lt if bound.is_zero() => Some(false),
            Inequality::Gt if bound.is_one() => Some(false),
            _ => None,
        }
    }

    /// Returns the question of a bound on a probability that is decided without numbers.
    pub fn qualitative(&self) -> Option<(Strategies, Bound)> {
        match question(Measure::Probability, Some(self.optimum), self.bound.clone()) {
            Question::Qualitative(strategies, bound) => Some((strategies, bound)),
            Question::Quantity(_) => None,
        }
    }
}
