//! Regions of temporal formulas: what is asked of the marks of monitors, on the product.
//!
//! With a condition in disjunctive normal form, an Emerson-Lei condition, U_d is where the disjunct d can be kept
//! to for ever; a play that satisfies the condition almost surely comes to one of them (L. de Alfaro, *Formal
//! verification of probabilistic systems*, 1997).

use super::winning_regions::almost_sure_within;
use crate::engine::regions::{Regions, Which, pmax_positive};
use crate::engine::{Engine, Region};
use crate::error::Result;
use crate::model::expr::ExprId;
use crate::model::temporal::{Condition, Disjunct};

/// Where a disjunct can be kept to, with what shows it.
pub struct Kept<E: Engine> {
    /// U_d
    pub states: E::States,
    /// The pairs of these states that stay in them.
    pub choices: E::Choices,
    /// For each mark that comes again and again, the states of U_d whose steps it is on.
    pub again: Vec<E::States>,
}

/// P_d: the states that satisfy what a disjunct asks from now on always.
///
/// # Errors
/// A limit of the engine, or a state formula without a value. Cost: no image.
pub fn allowed<E: Engine>(engine: &E, disjunct: &Disjunct) -> Result<E::States> {
    let mut allowed = engine.all_states();
    for &(mark, sign) in &disjunct.always {
        let marked = engine.states_where(mark)?;
        allowed = if sign {
            engine.intersection(&allowed, &marked)?
        } else {
            engine.difference(&allowed, &marked)?
        };
    }
    Ok(allowed)
}

/// U_d = the greatest Z ⊆ P_d such that from every state of Z some choices stay in Z surely and, staying,
/// almost surely reach each R_di.
///
/// From where R_di can be reached inside Z with pairs that stay in Z, it is reached almost surely when these are
/// taken at random: so what cannot reach some R_di is taken out, then what has no pair left, until nothing is.
///
/// # Errors
/// A limit of the engine, or a state formula without a value. Cost: one `can_reach` an R_di and round, and one
/// pre-image of the states removed.
pub fn kept<E: Engine>(engine: &E, disjunct: &Disjunct) -> Result<Kept<E>> {
    let allowed = allowed(engine, disjunct)?;
    let recurring =
        disjunct.again.iter().map(|&mark| engine.states_where(mark)).collect::<Result<Vec<_>>>()?;
    let Region { mut states, mut choices } = engine.stay_within(&allowed, &engine.all_choices())?;
    let mut unchanged = 0;
    for mark in recurring.iter().cycle() {
        if unchanged == recurring.len() || engine.is_empty(&states) {
            break;
        }
        let here = engine.intersection(mark, &states)?;
        let reaching = engine.can_reach(&here, &choices, &[])?;
        let left = engine.intersection(&states, &reaching)?;
        if engine.same(&left, &states) {
            unchanged += 1;
            continue;
        }
        unchanged = 0;
        Region { states, choices } = engine.stay_within(&left, &choices)?;
    }
    let again = recurring.iter().map(|mark| engine.intersection(mark, &states)).collect::<Result<_>>()?;
    Ok(Kept { states, choices, again })
}

/// ⋃_d U_d: where the condition can be kept to. Almost surely to reach it, or possibly, is almost surely, or
/// possibly, to satisfy the condition.
///
/// # Errors
/// As [`kept`]. Cost: that of it for each disjunct.
pub fn secured<E: Engine>(engine: &E, condition: &Condition) -> Result<E::States> {
    let mut all = engine.no_states();
    // Conditions that are too large were refused when they were read.
    for disjunct in condition.disjuncts().unwrap_or_default() {
        all = engine.union(&all, &kept(engine, &disjunct)?.states)?;
    }
    Ok(all)
}

/// The four regions of a condition on the product.
///
/// # Errors
/// As [`kept`]. Cost: for the condition and its negation each that of [`secured`], a backward fixpoint and an
/// almost sure one.
pub fn regions<E: Engine>(engine: &E, condition: &Condition) -> Result<Regions<E::States>> {
    regions_by(engine, condition, |_, find| find())
}

/// The four regions, each found when `by` asks for it; what no strategy against the condition wins is won by
/// every strategy.
///
/// # Errors
/// Those of [`regions`], and of `by`.
pub fn regions_by<E: Engine>(
    engine: &E,
    condition: &Condition,
    mut by: impl FnMut(Which, &mut dyn FnMut() -> Result<E::States>) -> Result<E::States>,
) -> Result<Regions<E::States>> {
    let all = engine.all_states();
    let mut own = engine.no_states();
    let positive = by(Which::PmaxPositive, &mut || {
        own = secured(engine, condition)?;
        pmax_positive(engine, &own)
    })?;
    let pmax_one = by(Which::PmaxOne, &mut || almost_sure_within(engine, &own, &positive))?;
    let (mut against, mut threatened) = (engine.no_states(), engine.no_states());
    let pmin_one = by(Which::PminOne, &mut || {
        against = secured(engine, &condition.negated())?;
        threatened = pmax_positive(engine, &against)?;
        engine.difference(&all, &threatened)
    })?;
    let pmin_positive = by(Which::PminPositive, &mut || {
        engine.difference(&all, &almost_sure_within(engine, &against, &threatened)?)
    })?;
    Ok(Regions { pmax_one, pmax_positive: positive, pmin_one, pmin_positive })
}

/// The states of a region in which monitors are fresh: formulas are judged from there on.
///
/// # Errors
/// A limit of the engine. Cost: no image.
pub fn judged<E: Engine>(
    engine: &E,
    fresh: ExprId,
    regions: Regions<E::States>,
) -> Result<Regions<E::States>> {
    let fresh = engine.states_where(fresh)?;
    let part = |x: &E::States| engine.intersection(x, &fresh);
    Ok(Regions {
        pmax_one: part(&regions.pmax_one)?,
        pmax_positive: part(&regions.pmax_positive)?,
        pmin_one: part(&regions.pmin_one)?,
        pmin_positive: part(&regions.pmin_positive)?,
    })
}
