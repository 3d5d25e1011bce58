//! Questions about the paths of a model, as plain data: whether a probability is 0 or 1, and
//! probabilities and expected rewards.

use super::{Optimum, Program};
use meliora_base::exact::Ratio;

/// The comparison of a number with a bound.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Inequality {
    /// At least the bound.
    Ge,
    /// Greater than the bound.
    Gt,
    /// At most the bound.
    Le,
    /// Less than the bound.
    Lt,
}

impl Inequality {
    /// Returns the comparison of the sides in the other order.
    pub fn mirrored(self) -> Self {
        match self {
            Inequality::Ge => Inequality::Le,
            Inequality::Gt => Inequality::Lt,
            Inequality::Le => Inequality::Ge,
            Inequality::Lt => Inequality::Gt,
        }
    }
}

/// Quantifier over strategies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Strategies {
    /// Every strategy, as `P` means it for MDPs.
    All,
    /// Some strategy.
    Some,
}

/// Condition on the probability.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bound {
    /// 1
    One,
    /// More than 0
    Positive,
    /// Less than 1
    BelowOne,
    /// 0
    Zero,
}

/// The number that a property asks for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Measure {
    /// The probability of the formula.
    Probability,
    /// The expected reward until a target is reached.
    Reward(Rewards),
}

/// A reference to a reward structure.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Rewards {
    /// The first one of the model.
    First,
    /// The one with this name.
    Named(String),
    /// The one at this position, from 1.
    Numbered(usize),
}

/// A property whose answer is a number, or depends on one.
#[derive(Debug, Clone, PartialEq)]
pub struct Quantity {
    /// The number.
    pub measure: Measure,
    /// The strategies; for a `dtmc` all have the same value.
    pub optimum: Optimum,
    /// The comparison of the number, which has the number on its left side; `None` for `=?`.
    pub bound: Option<(Inequality, Ratio)>,
}

/// The question of a property.
#[derive(Debug, Clone, PartialEq)]
pub enum PropertyKind {
    /// A comparison with 0 or 1, which is decided without numbers: the strategies, and the bound on
    /// the probability of the formula under them.
    Qualitative(Strategies, Bound),
    /// Any other question.
    Quantity(Quantity),
}

/// The part of the initial states that a question is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Over {
    /// All of them: a verdict holds in each, a value is the range of their values.
    #[default]
    All,
    /// The state with the least value.
    Least,
    /// The state with the greatest value.
    Greatest,
}

impl Rewards {
    /// Returns the position of the structure among those of a program, if it is there.
    pub fn find(&self, program: &Program) -> Option<usize> {
        match self {
            Rewards::First => program.reward_structure(None),
            Rewards::Named(name) => program.reward_structure(Some(name)),
            Rewards::Numbered(number) => number.checked_sub(1).filter(|&at| at < program.rewards.len()),
        }
    }
}
