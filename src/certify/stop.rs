//! The result of a check.

use super::Violation;
use crate::error::Error;
use crate::model::State;

/// The reason why a check ended early.
pub(super) enum Stop {
    /// The check could not be completed.
    Error(Error),
    /// A condition is violated.
    Violation(Violation),
}

impl From<Error> for Stop {
    fn from(error: Error) -> Self {
        Stop::Error(error)
    }
}

impl Stop {
    /// Reports a violated condition, with a state that violates it.
    pub(super) fn violated(condition: impl Into<String>, state: Option<State>) -> Self {
        Stop::Violation(Violation { condition: condition.into(), state })
    }
}

/// The result of a check.
pub(super) type Check<T = ()> = Result<T, Stop>;
