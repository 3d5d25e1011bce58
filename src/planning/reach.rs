//! The four qualitative regions of one target.

use crate::engine::Engine;
use crate::error::Result;

/// Where a target is reached, by some or by every strategy, surely enough or at all.
pub struct Reach<E: Engine> {
    /// The target F itself.
    pub target: E::States,
    /// Pmax > 0
    pub pmax_positive: E::States,
    /// Pmax = 1
    pub pmax_one: E::States,
    /// Pmin > 0
    pub pmin_positive: E::States,
    /// Pmin = 1
    pub pmin_one: E::States,
}

impl<E: Engine> Reach<E> {
    /// All four regions of `target`.
    ///
    /// # Errors
    /// A limit of the engine. Cost: those of the four functions of this module, nothing twice.
    pub fn new(engine: &E, target: &E::States) -> Result<Self> {
        let pmax_positive = positive(engine, target)?;
        let pmax_one = almost_sure(engine, target, &pmax_positive)?;
        let avoiding = can_avoid(engine, target)?;
        let all = engine.all_states();
        Ok(Reach {
            target: target.clone(),
            pmax_positive,
            pmax_one,
            pmin_positive: engine.difference(&all, &avoiding)?,
            pmin_one: engine.difference(&all, &may_avoid(engine, target, &avoiding)?)?,
        })
    }
}

/// PWin(F) = μX. F ∪ { s : some a has succ(s,a) ∩ X ≠ ∅ } (Pmax > 0).
///
/// # Errors
/// A limit of the engine. Cost: one `can_reach`.
pub fn positive<E: Engine>(engine: &E, target: &E::States) -> Result<E::States> {
    engine.can_reach(target, &engine.all_choices(), &Vec::new())
}

/// ASWin(F) = νY. μX. F ∪ { s : some a has succ(s,a) ⊆ Y and ∩ X ≠ ∅ } (Pmax = 1), given any
/// `bound` ⊇ ASWin(F), such as PWin(F).
///
/// Starts with the choices that stay inside the bound: a choice that may leave a superset of the
/// result is in no almost-sure strategy, so the result is the same and the first round of losing
/// states is spared.
///
/// # Errors
/// A limit of the engine. Cost: one pre-image and an `almost_surely_reach`.
pub fn almost_sure<E: Engine>(engine: &E, target: &E::States, bound: &E::States) -> Result<E::States> {
    let staying = if engine.same_states(bound, &engine.all_states()) {
        engine.all_choices()
    } else {
        engine.choices_in(&engine.every_successor_in(bound)?, bound)?
    };
    Ok(engine.almost_surely_reach(target, &staying)?.states)
}

/// νZ. S \ F ∩ { s : some a has succ(s,a) ⊆ Z }: where some strategy never reaches F (Pmin = 0).
///
/// # Errors
/// A limit of the engine. Cost: one `stay_within`.
pub fn can_avoid<E: Engine>(engine: &E, target: &E::States) -> Result<E::States> {
    let outside = engine.difference(&engine.all_states(), target)?;
    Ok(engine.stay_within(&outside, &engine.all_choices())?.states)
}

/// μX. A ∪ { s ∉ F : some a has succ(s,a) ∩ X ≠ ∅ } for A = [`can_avoid`]`(F)`: where some strategy
/// may miss F (Pmin < 1).
///
/// Sound since a strategy that misses F with positive probability ends, with positive probability,
/// in a set of states that it never leaves and that lies outside F, hence in A.
///
/// # Errors
/// A limit of the engine. Cost: one `can_reach`.
pub fn may_avoid<E: Engine>(engine: &E, target: &E::States, avoiding: &E::States) -> Result<E::States> {
    let outside = engine.difference(&engine.all_states(), target)?;
    let before = engine.choices_in(&engine.all_choices(), &outside)?;
    engine.can_reach(avoiding, &before, &Vec::new())
}
