//! Fixpoints: recursions over the diagrams of sets and the lists of relations at once, run on a
//! store.
//!
//! `reach` and `saturation` compute the states that are reachable within a bound. `parts` are groups
//! of choices, each with a bound of its own; `confined` and `attractor` are recursions over them. `lose` removes
//! losing states without a bound per group. `layers` does both layer by layer.
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

/// A method for reachability within a bound.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::symbolic) enum Method {
    /// The recursion over all relations.
    Recursion,
    /// Saturation.
    Saturation,
    /// Layer by layer.
    Layers,
}

impl Method {
    /// All methods; the first one of the first search comes first.
    pub(in crate::symbolic) const ALL: [Method; 3] = [Method::Recursion, Method::Saturation, Method::Layers];
    /// The order of those after the first one: the recursion, if it has failed before, is the last.
    const THEN: [Method; 3] = [Method::Saturation, Method::Layers, Method::Recursion];
}

impl Store {
    /// Computes μY. X ∪ { s ∈ B : one step of the list, in a direction, joins s and Y } for X ⊆ B.
    ///
    /// There are three methods. The recursion over all relations is usually faster. Saturation is
    /// faster where components that read much of each other need many rounds. Layers are faster where a clock
    /// moves all components at once and the states are thousands of steps away: the other methods close most
    /// parts again after each tick. The method that succeeded last in this direction starts with a limited
    /// number of steps, at least twice as many as any search took before; then each of the others may take
    /// four times as many. They may take more because, where they are faster, they are about ten times faster;
    /// the recursion two or three times. All repeat with 16 times more steps until one finishes. Intermediate
    /// results are reused as long as the operation cache still has them.
    ///
    /// Measured: with the target `s1=12` of `wlan6`, layers take 3.6 million steps, and the others together
    /// more than 100 million. None of 57 other instances of the PRISM benchmark suite comes to layers.
    pub(in crate::symbolic) fn reach(
        &self,
        (direction, phase): (Direction, &'static str),
        list: &RelationList,
        x: &Bdd,
        bound: &Bdd,
    ) -> Result<Bdd> {
        self.progress(phase);
        let at = usize::from(direction == Direction::Backward);
        let (method, reach_steps) = (&self.reach_method[at], &self.reach_steps[at]);
        let trial = match direction {
            Direction::Forward => self.thresholds().forward_trial_steps,
            Direction::Backward => {
                let of_bound = self.thresholds().trial_steps_per_node * self.size(bound)? as u64;
                self.thresholds().trial_steps.max(of_bound)
            }
        };
        let first = Method::ALL[method.load(Relaxed)];
        let others = Method::THEN.into_iter().filter(|&method| method != first);
        let mut trial = reach_steps.load(Relaxed).saturating_mul(2).max(trial).max(1);
        loop {
            let more = trial.saturating_mul(4);
            for (now, steps) in [(first, trial)].into_iter().chain(others.clone().map(|m| (m, more))) {
                let before = self.work.steps.load(Relaxed);
                let found = self.fixpoint(now, (direction, Some(phase)), steps, list, (x, bound))?;
                if let Some(found) = found {
                    method.store(now as usize, Relaxed);
                    reach_steps.fetch_max(self.work.steps.load(Relaxed) - before, Relaxed);
                    return Ok(found);
                }
            }
            trial = trial.saturating_mul(16);
        }
    }

    /// Returns whether the last backward search that ended did so by layers.
    pub(in crate::symbolic) fn reached_by_layers(&self) -> bool {
        self.reach_method[usize::from(true)].load(Relaxed) == Method::Layers as usize
    }

    /// Computes [`Store::reach`] by one method; `None` if it takes more than `steps` steps.
    pub(in crate::symbolic) fn fixpoint(
        &self,
        method: Method,
        how: (Direction, Option<&'static str>),
        steps: u64,
        list: &RelationList,
        (x, bound): (&Bdd, &Bdd),
    ) -> Result<Option<Bdd>> {
        let close = |saturates: bool| {
            self.walk(how, steps, |walk| walk.own(|w| w.close(saturates, w.edge(x), w.edge(bound), list)))
        };
        let found = match method {
            Method::Recursion => close(false)?,
            Method::Saturation => close(true)?,
            Method::Layers => self.reach_by_layers(how, steps, list, (x, bound))?,
        };
        self.work.reached[method as usize].fetch_add(u64::from(found.is_some()), Relaxed);
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
