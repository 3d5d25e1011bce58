//! Regions of objectives over whole paths, with the layers and rounds that prove them.
//!
//! Each disjunct d of an objective has a region U_d with a strategy. The objective is achieved
//! almost surely from a state if the union of all U_d is reached almost surely.

use super::Named;
use super::layers::{backward, layers, rounds};
use crate::engine::symbolic::{StateSet, SymbolicEngine};
use crate::engine::{Algebra, Engine};
use crate::error::Result;
use crate::model::preference::{Goal, Preferences};
use crate::model::temporal::Disjunct;
use crate::names;
use crate::planning::temporal::{self, AcceptingRegion};

/// A disjunct of an objective, with its region.
pub(super) struct Secured {
    /// The index of the objective.
    pub(super) objective: usize,
    name: String,
    disjunct: Disjunct,
    accepting: AcceptingRegion<SymbolicEngine>,
}

/// Computes the regions of all disjuncts of all objectives over whole paths.
pub(super) fn secured(engine: &SymbolicEngine, preferences: &Preferences) -> Result<Vec<Secured>> {
    let mut all = Vec::new();
    for (objective, asked) in preferences.objectives.iter().enumerate() {
        let Goal::Satisfy { condition, .. } = &asked.goal else { continue };
        // The parser refuses conditions that are too large.
        for (case, disjunct) in condition.disjuncts().unwrap_or_default().into_iter().enumerate() {
            let accepting = temporal::accepting_region(engine, &disjunct)?;
            all.push(Secured { objective, name: names::secured(&asked.name, case + 1), disjunct, accepting });
        }
    }
    Ok(all)
}

impl Secured {
    /// Adds the region, and its strategy: the choices that stay in the region.
    pub(super) fn regions(&self, named: &mut Vec<Named>) {
        named.push(Named::states(&self.name, &self.accepting.states));
        named.push(Named::choices(names::strategy(&self.name), &self.accepting.choices));
    }

    /// Adds layers towards each mark that recurs, and the rounds that remove all other states.
    pub(super) fn witnesses(&self, engine: &SymbolicEngine, named: &mut Vec<Named>) -> Result<()> {
        for (index, here) in self.accepting.again.iter().enumerate() {
            let towards = backward(engine, here, &self.accepting.choices)?;
            layers(named, &names::recurring(&self.name, index + 1), &towards);
        }
        rounds(named, &self.name, &lost_rounds(engine, &self.disjunct)?);
        Ok(())
    }
}

/// Computes the rounds that remove the states outside of U_d. The first round removes the states
/// outside of P_d. A later round removes the states that cannot reach some mark with choices that
/// avoid all removed states. Without any recurring mark, every state counts as marked.
fn lost_rounds(engine: &SymbolicEngine, disjunct: &Disjunct) -> Result<Vec<StateSet>> {
    let mut marks =
        disjunct.again.iter().map(|&mark| engine.states_where(mark)).collect::<Result<Vec<_>>>()?;
    if marks.is_empty() {
        marks.push(engine.all_states());
    }
    let (mut left, mut choices, mut rounds) = (engine.all_states(), engine.all_choices(), Vec::new());
    let mut lost = engine.difference(&left, &temporal::allowed(engine, disjunct)?)?;
    let mut unchanged = 0;
    for mark in marks.iter().cycle() {
        if !engine.is_empty(&lost)? {
            unchanged = 0;
            choices = engine.difference(&choices, &engine.entering(&choices, &lost)?)?;
            left = engine.difference(&left, &lost)?;
            choices = engine.choices_in(&choices, &left)?;
            rounds.push(lost);
        } else if unchanged == marks.len() {
            break;
        }
        unchanged += 1;
        let moving = engine.intersection(mark, &engine.sources(&choices)?)?;
        lost = engine.difference(&left, &engine.can_reach(&moving, &choices, &[])?)?;
    }
    Ok(rounds)
}
