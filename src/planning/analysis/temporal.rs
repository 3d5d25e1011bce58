//! Winning regions of temporal formulas: conditions on the marks of monitors, on the product.
//!
//! In disjunctive normal form, a condition is an Emerson-Lei condition. U_d is the set of states
//! from which the disjunct d can be kept forever. A path that satisfies the condition almost surely
//! reaches one of these sets (L. de Alfaro, *Formal verification of probabilistic systems*, 1997).

use meliora_base::error::Result;
use meliora_engine::regions::Regions;
use meliora_engine::{Engine, Region};
use meliora_model::predicate::Predicate;
use meliora_model::temporal::{Condition, Disjunct};

/// The states from which a disjunct can be kept, with the choices and marks that prove it.
pub struct AcceptingRegion<E: Engine> {
    /// The disjunct d.
    pub disjunct: Disjunct,
    /// U_d, the states.
    pub states: E::States,
    /// The pairs of these states that stay in U_d.
    pub choices: E::Choices,
    /// For each mark that must occur infinitely often, the states of U_d whose steps are marked.
    pub again: Vec<E::States>,
}

/// Computes P_d: the states that satisfy the marks a disjunct requires from now on always. Cost: no
/// image.
///
/// # Errors
/// A limit of the engine is reached, or a state formula has no value.
pub fn allowed<E: Engine>(engine: &E, disjunct: &Disjunct) -> Result<E::States> {
    let mut allowed = engine.all_states();
    for (mark, sign) in &disjunct.always {
        let marked = engine.states_where(mark)?;
        allowed = if *sign {
            engine.intersection(&allowed, &marked)?
        } else {
            engine.difference(&allowed, &marked)?
        };
    }
    Ok(allowed)
}

/// Computes U_d, the greatest Z ⊆ P_d such that from every state of Z some choices of `within` stay
/// in Z surely and, while staying, almost surely reach each R_di.
///
/// If R_di can be reached inside Z with pairs that stay in Z, then random selection of these pairs
/// reaches it almost surely. The algorithm therefore removes states that cannot reach some R_di,
/// then states without a remaining pair, until nothing changes. In a game, [`Engine::stay_within`] and
/// [`Engine::can_reach`] are those against the opponent, so this is the generalised Büchi game within
/// P_d: from a state that is left, the strategy approaches one R_di after the other. Cost: one `can_reach` per R_di and
/// round, and one pre-image of the removed states.
///
/// # Errors
/// A limit of the engine is reached, or a state formula has no value.
pub(crate) fn accepting_region<E: Engine>(
    engine: &E,
    disjunct: Disjunct,
    within: &E::Choices,
) -> Result<AcceptingRegion<E>> {
    let allowed = allowed(engine, &disjunct)?;
    let recurring =
        disjunct.again.iter().map(|mark| engine.states_where(mark)).collect::<Result<Vec<_>>>()?;
    let Region { mut states, mut choices } = engine.stay_within(&allowed, within)?;
    let mut unchanged = 0;
    for mark in recurring.iter().cycle() {
        if unchanged == recurring.len() || engine.is_empty(&states)? {
            break;
        }
        let here = engine.intersection(mark, &states)?;
        let reaching = engine.can_reach(&here, &choices, &[])?;
        let left = engine.intersection(&states, &reaching)?;
        if engine.same(&left, &states)? {
            unchanged += 1;
            continue;
        }
        unchanged = 0;
        Region { states, choices } = engine.stay_within(&left, &choices)?;
    }
    let again = recurring.iter().map(|mark| engine.intersection(mark, &states)).collect::<Result<_>>()?;
    Ok(AcceptingRegion { disjunct, states, choices, again })
}

/// Computes U_d for each disjunct of a condition, with choices of `within`. Cost: that of `accepting_region` per disjunct.
///
/// # Errors
/// The errors of `accepting_region`.
pub fn accepting_regions<E: Engine>(
    engine: &E,
    condition: &Condition,
    within: &E::Choices,
) -> Result<Vec<AcceptingRegion<E>>> {
    let region = |disjunct| accepting_region(engine, disjunct, within);
    condition.disjuncts()?.into_iter().map(region).collect()
}

/// Computes ⋃_d U_d, the states from which some disjunct can be kept. Reaching this set almost
/// surely (or with positive probability) is equivalent to satisfying the condition almost surely
/// (or with positive probability), except in a game, where the opponent may choose between disjuncts
/// without end; see `temporal_game`. Cost: no image.
pub fn secured<E: Engine>(engine: &E, all: &[AcceptingRegion<E>]) -> Result<E::States> {
    all.iter().try_fold(engine.no_states(), |union, region| engine.union(&union, &region.states))
}

/// Restricts regions to the states with fresh monitors: formulas are judged from these states on.
/// Cost: no image.
pub fn judged<E: Engine>(
    engine: &E,
    fresh: &Predicate,
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
