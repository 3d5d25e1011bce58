//! Where what objectives over whole plays ask can be kept to, with the layers and rounds that show it.
//!
//! Of each disjunct d of an objective, U_d is a region with a strategy; the objective is almost surely achieved
//! from where one of them is almost surely reached.

use super::Named;
use super::layers::{backward, layers, rounds};
use crate::engine::symbolic::{StateSet, SymbolicEngine};
use crate::engine::{Algebra, Engine};
use crate::error::Result;
use crate::model::preference::{Goal, Preferences};
use crate::model::temporal::Disjunct;
use crate::names;
use crate::planning::temporal::{self, Kept};

/// A disjunct of an objective with its region.
pub(super) struct Secured {
    /// The position of the objective.
    pub(super) objective: usize,
    name: String,
    disjunct: Disjunct,
    kept: Kept<SymbolicEngine>,
}

/// All disjuncts of all objectives over whole plays.
pub(super) fn secured(engine: &SymbolicEngine, preferences: &Preferences) -> Result<Vec<Secured>> {
    let mut all = Vec::new();
    for (objective, asked) in preferences.objectives.iter().enumerate() {
        let Goal::Satisfy { condition, .. } = &asked.goal else { continue };
        // Conditions that are too large were refused when they were read.
        for (case, disjunct) in condition.disjuncts().unwrap_or_default().into_iter().enumerate() {
            let kept = temporal::kept(engine, &disjunct)?;
            all.push(Secured { objective, name: names::secured(&asked.name, case + 1), disjunct, kept });
        }
    }
    Ok(all)
}

impl Secured {
    /// The region and its strategy: what stays in it.
    pub(super) fn regions(&self, named: &mut Vec<Named>) {
        named.push(Named::states(&self.name, &self.kept.states));
        named.push(Named::choices(names::strategy(&self.name), &self.kept.choices));
    }

    /// Layers towards each mark that comes again and again, and rounds in which all other states are lost.
    pub(super) fn witnesses(&self, engine: &SymbolicEngine, named: &mut Vec<Named>) -> Result<()> {
        for (index, here) in self.kept.again.iter().enumerate() {
            let towards = backward(engine, here, &self.kept.choices)?;
            layers(named, &names::recurring(&self.name, index + 1), &towards);
        }
        rounds(named, &self.name, &lost_rounds(engine, &self.disjunct)?);
        Ok(())
    }
}

/// The states outside of U_d in the rounds in which they are lost: first those that do not satisfy what is always
/// asked, then those from where some mark can be reached no more with choices that cannot step into states lost
/// before. Where no mark is to come again and again, every state counts as one.
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
        if !engine.is_empty(&lost) {
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
