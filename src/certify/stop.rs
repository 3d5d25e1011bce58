//! How a check ends.

use super::Violation;
use crate::error::Error;
use crate::model::State;

/// Why the check ended.
pub(super) enum Stop {
    /// It could not go on.
    Error(Error),
    /// A condition does not hold.
    Violation(Violation),
}

impl From<Error> for Stop {
    fn from(error: Error) -> Self {
        Stop::Error(error)
    }
}

impl Stop {
    /// A condition does not hold, in this state.
    pub(super) fn violated(condition: impl Into<String>, state: Option<State>) -> Self {
        Stop::Violation(Violation { condition: condition.into(), state })
    }
}

/// The result of a check.
pub(super) type Check<T = ()> = Result<T, Stop>;
