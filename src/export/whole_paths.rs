//! Regions of objectives over whole paths, with the layers and rounds that prove them.
//!
//! Each disjunct d of an objective has a region U_d with a strategy. The objective is achieved
//! almost surely from a state if the union of all U_d is reached almost surely.

use super::Named;
use super::layers::{Proof, Trends, layers, rounds};
use super::removal::Removal;
use meliora_base::error::Result;
use meliora_engine::symbolic::SymbolicEngine;
use meliora_engine::{Algebra, Engine};
use meliora_model::region::RegionName;
use meliora_model::temporal::Disjunct;
use meliora_planning::Analysis;
use meliora_planning::temporal::{self, AcceptingRegion};

type Sets = AcceptingRegion<SymbolicEngine>;

/// Returns the regions of an objective with their names: U_d for each disjunct d, from 1.
fn named(analysis: &Analysis<SymbolicEngine>, objective: usize) -> impl Iterator<Item = (RegionName, &Sets)> {
    let name = &analysis.preferences().objectives[objective].name;
    (1..)
        .zip(analysis.accepting_regions(objective))
        .map(|(case, region)| (RegionName::Secured(name.clone(), case), region))
}

/// Returns the regions of an objective, each with its strategy: the choices that stay in it.
pub(super) fn regions(analysis: &Analysis<SymbolicEngine>, objective: usize) -> Vec<Named> {
    let both = |(name, region): (RegionName, &Sets)| {
        [Named::states(name.clone(), &region.states), Named::choices(name.strategy(), &region.choices)]
    };
    named(analysis, objective).flat_map(both).collect()
}

/// Adds the layers of an objective's regions towards each mark that recurs, and the rounds that
/// remove all other states.
pub(super) fn witnesses(
    engine: &SymbolicEngine,
    trends: &Trends,
    analysis: &Analysis<SymbolicEngine>,
    objective: usize,
    all: &mut Vec<Named>,
) -> Result<()> {
    for (name, region) in named(analysis, objective) {
        for (index, here) in region.again.iter().enumerate() {
            let towards = trends.backward(engine, here, &region.choices)?;
            layers(all, &name.recurring(index + 1), towards);
        }
        rounds(all, &name, lost_rounds(engine, trends, &region.disjunct)?);
    }
    Ok(())
}

/// Computes the rounds that remove the states outside of U_d. The first round removes the states
/// outside of P_d. A later round removes the states that cannot reach some mark with choices that
/// avoid all removed states, or those that must risk to enter them. Without any recurring mark,
/// every state counts as marked.
fn lost_rounds(engine: &SymbolicEngine, trends: &Trends, disjunct: &Disjunct) -> Result<Proof> {
    let mut marks =
        disjunct.again.iter().map(|mark| engine.states_where(mark)).collect::<Result<Vec<_>>>()?;
    if marks.is_empty() {
        marks.push(engine.all_states());
    }
    let mut removal = Removal::new(engine, trends);
    removal.remove(engine.difference(&removal.left, &temporal::allowed(engine, disjunct)?)?)?;
    let mut unchanged = 0;
    for mark in marks.iter().cycle() {
        if unchanged == marks.len() {
            break;
        }
        let choices = engine.choices_in(&removal.choices, &removal.left)?;
        let moving = engine.intersection(mark, &engine.can_choose(&choices)?)?;
        let lost = engine.difference(&removal.left, &engine.can_reach(&moving, &choices, &[])?)?;
        unchanged = if removal.remove(lost)? { 0 } else { unchanged + 1 };
    }
    Ok(removal.rounds)
}
