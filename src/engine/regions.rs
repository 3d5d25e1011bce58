//! The four qualitative regions of one target.

use super::Engine;
use crate::error::Result;

/// The regions of a target T, as sets of states.
#[derive(Debug, Clone)]
pub struct Regions<S> {
    /// Some strategy reaches T with probability one.
    pub pmax_one: S,
    /// Some strategy reaches T with positive probability.
    pub pmax_positive: S,
    /// Every strategy reaches T with probability one.
    pub pmin_one: S,
    /// Every strategy reaches T with positive probability.
    pub pmin_positive: S,
}

/// { s : Pmax(◇T) > 0 } = μX. T ∪ { s : some a has succ(s,a) ∩ X ≠ ∅ }
///
/// # Errors
/// A limit. Cost: one backward fixpoint.
pub fn pmax_positive<E: Engine>(engine: &E, target: &E::States) -> Result<E::States> {
    engine.can_reach(target, &engine.all_choices(), &[])
}

/// { s : Pmax(◇T) = 1 } = νY. μX. T ∪ { s : some a has succ(s,a) ⊆ Y and succ(s,a) ∩ X ≠ ∅ }
///
/// # Errors
/// A limit. Cost: one backward fixpoint a round, usually two rounds.
pub fn pmax_one<E: Engine>(engine: &E, target: &E::States) -> Result<E::States> {
    Ok(engine.almost_surely_reach(target, &engine.all_choices())?.states)
}

/// { s : Pmin(◇T) > 0 }: the states from which no strategy stays outside T for sure,
/// S \ νZ. { s ∉ T : some a has succ(s,a) ⊆ Z }.
///
/// # Errors
/// A limit. Cost: one fixpoint of pre-images.
pub fn pmin_positive<E: Engine>(engine: &E, target: &E::States) -> Result<E::States> {
    let outside = engine.difference(&engine.all_states(), target)?;
    let avoiding = engine.stay_within(&outside, &engine.all_choices())?;
    engine.difference(&engine.all_states(), &avoiding.states)
}

/// { s : Pmin(◇T) = 1 }: the states from which no strategy gets, past T, to where T can be avoided
/// for sure. Needs `positive`, the result of [`pmin_positive`] (Baier and Katoen, section 10.6.2).
///
/// # Errors
/// A limit. Cost: one backward fixpoint.
pub fn pmin_one<E: Engine>(engine: &E, target: &E::States, positive: &E::States) -> Result<E::States> {
    let avoiding = engine.difference(&engine.all_states(), positive)?;
    let outside = engine.difference(&engine.all_states(), target)?;
    let choices = engine.choices_in(&engine.all_choices(), &outside)?;
    let losing = engine.can_reach(&avoiding, &choices, &[])?;
    engine.difference(&engine.all_states(), &losing)
}

/// All four regions; Pmin > 0 is computed once for both of its uses.
///
/// # Errors
/// A limit. Cost: that of [`pmin_positive`], [`pmax_one`], [`pmax_positive`] and [`pmin_one`].
pub fn regions<E: Engine>(engine: &E, target: &E::States) -> Result<Regions<E::States>> {
    let pmin_positive = pmin_positive(engine, target)?;
    Ok(Regions {
        pmax_one: pmax_one(engine, target)?,
        pmax_positive: pmax_positive(engine, target)?,
        pmin_one: pmin_one(engine, target, &pmin_positive)?,
        pmin_positive,
    })
}
