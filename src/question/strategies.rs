//! Strategies for a target: policies, and the states with a strong plan.

use crate::number::Number;
use meliora_base::error::Result;
use meliora_engine::{Engine, Guided};
use meliora_model::Program;
use meliora_model::predicate::Predicate;
use meliora_planning::policy::{Policy, strong_region};

/// Maximum number of states of a policy: each takes about as much memory as a line of its text.
pub const MOST_STATES: usize = 1_000_000;

/// Returns a policy that reaches a target almost surely from the initial states; `None` if there is none. The engine may
/// know states that are not reachable.
///
/// # Errors
/// A limit is reached.
pub(crate) fn policy<E: Engine>(engine: &E, program: &Program, target: &Predicate) -> Result<Option<Policy>> {
    Policy::find(engine, program, &engine.states_where(target)?, MOST_STATES)
}

/// Returns the policy of a guided search; `None` if it has found that there is none.
///
/// # Errors
/// A limit is reached.
pub(crate) fn of_search(search: &Guided, program: &Program) -> Result<Option<Policy>> {
    let found = (search.answer() == Some(true)).then(|| Policy::of_search(search, program, MOST_STATES));
    found.transpose()
}

/// Returns whether a strong plan for a target exists from all initial states, and the number of states with one.
///
/// # Errors
/// A limit is reached.
pub(crate) fn strong<E: Engine>(engine: &E, target: &Predicate) -> Result<(bool, Number)> {
    let region = strong_region(engine, &engine.states_where(target)?)?;
    let outside = engine.difference(&engine.initial_states(), &region)?;
    Ok((engine.is_empty(&outside)?, Number::from(engine.count(&region)?)))
}
