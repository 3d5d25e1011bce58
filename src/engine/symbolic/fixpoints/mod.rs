//! Fixpoints: recursions over the diagrams of sets and the lists of relations at once, run on a
//! store.
//!
//! `reach` and `saturation` compute the states that are reachable within a bound. `parts` are groups
//! of choices, each with a bound of its own; `confined` and `attractor` are recursions over them. `lose` removes
//! losing states without a bound per group, and `layers` does so layer by layer.
//! `clusters` are the relations united for reachability.

pub(in crate::symbolic) mod attractor;
pub(in crate::symbolic) mod clusters;
pub(in crate::symbolic) mod confined;
pub(in crate::symbolic) mod layers;
mod lose;
pub(in crate::symbolic) mod parts;
mod reach;
mod saturation;

use std::sync::atomic::Ordering::Relaxed;

use crate::symbolic::relations::lists::RelationList;
use crate::symbolic::store::Store;
use crate::symbolic::store::diagram::Bdd;
use crate::symbolic::store::walk::Direction;
use attractor::Removed;
use meliora_model::error::Result;
use parts::{Budget, Known, Part};

impl Store {
    /// Computes μY. X ∪ { s ∈ B : one step of the list, in a direction, joins s and Y } for X ⊆ B.
    ///
    /// There are two methods. The recursion over all relations is usually faster. Saturation is
    /// faster where components that read much of each other need many rounds. The method that
    /// succeeded last in this direction starts with a limited number of steps, at least twice as many as
    /// any search took before; then the other one may take four times as many. It may take more because saturation,
    /// where it is faster, is about ten times faster; the recursion two or three times. Both repeat with 16
    /// times more steps until one finishes. Intermediate results are reused as long as the operation cache
    /// still has them.
    pub(in crate::symbolic) fn reach(
        &self,
        (direction, phase): (Direction, &'static str),
        list: &RelationList,
        x: &Bdd,
        bound: &Bdd,
    ) -> Result<Bdd> {
        self.progress(phase);
        let at = usize::from(direction == Direction::Backward);
        let (saturates, reach_steps) = (&self.saturates[at], &self.reach_steps[at]);
        let trial = match direction {
            Direction::Forward => self.thresholds().forward_trial_steps,
            Direction::Backward => {
                let of_bound = self.thresholds().trial_steps_per_node * self.size(bound)? as u64;
                self.thresholds().trial_steps.max(of_bound)
            }
        };
        let first = saturates.load(Relaxed);
        let mut trial = reach_steps.load(Relaxed).saturating_mul(2).max(trial).max(1);
        loop {
            for (by_saturation, steps) in [(first, trial), (!first, trial.saturating_mul(4))] {
                let before = self.work.steps.load(Relaxed);
                let found =
                    self.fixpoint(by_saturation, (direction, Some(phase)), steps, list, (x, bound))?;
                if let Some(found) = found {
                    saturates.store(by_saturation, Relaxed);
                    reach_steps.fetch_max(self.work.steps.load(Relaxed) - before, Relaxed);
                    return Ok(found);
                }
            }
            trial = trial.saturating_mul(16);
        }
    }

    /// Computes [`Store::reach`] by one method; `None` if it takes more than `steps` steps.
    pub(in crate::symbolic) fn fixpoint(
        &self,
        by_saturation: bool,
        how: (Direction, Option<&'static str>),
        steps: u64,
        list: &RelationList,
        (x, bound): (&Bdd, &Bdd),
    ) -> Result<Option<Bdd>> {
        let found = self
            .walk(how, steps, |walk| walk.own(|w| w.close(by_saturation, w.edge(x), w.edge(bound), list)))?;
        self.work.reached[usize::from(by_saturation)].fetch_add(u64::from(found.is_some()), Relaxed);
        Ok(found)
    }

    /// Computes [`Walk::remove_attractor`]; `None` if that exceeds the limits `most`.
    pub(in crate::symbolic) fn remove_attractor(
        &self,
        new: &Bdd,
        parts: &[Part],
        most: Budget,
    ) -> Result<Option<Removed>> {
        let how = (Direction::Backward, Some("attractor removal"));
        self.walk(how, most.steps, |walk| {
            walk.remove_attractor(new, parts, &mut Known::new(self, most.cases))
        })
    }

    /// Computes [`Walk::reach_by`]; `None` if that exceeds the limits `most`.
    pub(in crate::symbolic) fn reach_by(&self, x: &Bdd, parts: &[Part], most: Budget) -> Result<Option<Bdd>> {
        let how = (Direction::Backward, Some("backward reachability"));
        self.walk(how, most.steps, |walk| walk.reach_by(x, parts, &mut Known::new(self, most.cases)))
    }
}
