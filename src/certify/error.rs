//! The result of a check.

use super::{Condition, Violation};
use meliora_base::error::Error;
use meliora_model::State;

/// The reason why a check ended early.
pub(super) enum CheckError {
    /// The check could not be completed.
    Error(Error),
    /// A condition is violated.
    Violation(Violation),
}

impl From<Error> for CheckError {
    fn from(error: Error) -> Self {
        CheckError::Error(error)
    }
}

impl CheckError {
    /// Reports a violated condition, with a state that violates it.
    pub(super) fn violated(condition: Condition, state: Option<State>) -> Self {
        CheckError::Violation(Violation { condition, state })
    }
}

/// The result of a check.
pub(super) type CheckResult<T = ()> = Result<T, CheckError>;
