//! The recursions over diagrams and relations, run on a store.

use std::sync::atomic::Ordering::Relaxed;

use oxidd::Function;

use super::attractor::Removed;
use super::diagram::{Bdd, Held};
use super::parts::{Budget, Known, Part};
use super::relation_lists::RelationList;
use super::store::Store;
use super::support::Support;
use super::walk::{Direction, Halt, Walk};
use meliora_model::error::Result;

impl Store {
    /// Computes { s ∈ B : one step of the list, in a direction, joins s and X }.
    pub(super) fn step(
        &self,
        direction: Direction,
        list: &RelationList,
        x: &Bdd,
        bound: &Bdd,
    ) -> Result<Bdd> {
        let how = (direction, None);
        self.walk_to_the_end(how, |walk| walk.own(|w| w.step(x.as_edge(w.m), bound.as_edge(w.m), list)))
    }

    /// Computes μY. X ∪ { s ∈ B : one step of the list, in a direction, joins s and Y } for X ⊆ B.
    ///
    /// There are two methods. The recursion over all relations is usually faster. Saturation is
    /// faster where components that read much of each other need many rounds. The method that
    /// succeeded last in this direction starts with a limited number of steps; then the other one
    /// may take four times as many. It may take more because saturation, where it is faster, is
    /// about ten times faster; the recursion two or three times. Both repeat with 16 times more
    /// steps until one finishes. Intermediate results are reused as long as the operation cache
    /// still has them.
    pub(super) fn reach(
        &self,
        (direction, phase): (Direction, &'static str),
        list: &RelationList,
        x: &Bdd,
        bound: &Bdd,
    ) -> Result<Bdd> {
        self.progress(phase);
        let saturates = &self.saturates[usize::from(direction == Direction::Backward)];
        let trial = match direction {
            Direction::Forward => self.thresholds().forward_trial_steps,
            Direction::Backward => self.thresholds().trial_steps,
        };
        let (first, mut trial) = (saturates.load(Relaxed), trial.max(1));
        loop {
            for (by_saturation, steps) in [(first, trial), (!first, trial.saturating_mul(4))] {
                let found =
                    self.fixpoint(by_saturation, (direction, Some(phase)), steps, list, (x, bound))?;
                if let Some(found) = found {
                    saturates.store(by_saturation, Relaxed);
                    return Ok(found);
                }
            }
            trial = trial.saturating_mul(16);
        }
    }

    /// Computes [`Store::reach`] by one method; `None` if it takes more than `steps` steps.
    pub(super) fn fixpoint(
        &self,
        by_saturation: bool,
        how: (Direction, Option<&'static str>),
        steps: u64,
        list: &RelationList,
        (x, bound): (&Bdd, &Bdd),
    ) -> Result<Option<Bdd>> {
        let found = self.walk(how, steps, |walk| {
            walk.own(|w| w.close(by_saturation, x.as_edge(w.m), bound.as_edge(w.m), list))
        })?;
        self.work.reached[usize::from(by_saturation)].fetch_add(u64::from(found.is_some()), Relaxed);
        Ok(found)
    }

    /// Computes [`Walk::remove_attractor`]; `None` if that exceeds the limits `most`.
    pub(super) fn remove_attractor(
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
    pub(super) fn reach_by(&self, x: &Bdd, parts: &[Part], most: Budget) -> Result<Option<Bdd>> {
        let how = (Direction::Backward, Some("backward reachability"));
        self.walk(how, most.steps, |walk| walk.reach_by(x, parts, &mut Known::new(self, most.cases)))
    }

    /// Returns X over the next state: the support bits are replaced by their next copies.
    pub(super) fn primed(&self, support: &Support, x: &Bdd) -> Result<Bdd> {
        let how = (Direction::Forward, None);
        self.walk_to_the_end(how, |walk| walk.own(|w| w.primed(x.as_edge(w.m), support)))
    }

    /// Runs one operation.
    pub(super) fn make(
        &self,
        operation: impl for<'m, 'id> FnOnce(&Walk<'m, 'id>) -> Result<Held<'m, 'id>, Halt>,
    ) -> Result<Bdd> {
        self.walk_to_the_end((Direction::Forward, None), |walk| walk.own(operation))
    }

    /// Runs a recursion over diagrams; `None` if it takes more than `steps` steps.
    fn walk<T>(
        &self,
        how: (Direction, Option<&'static str>),
        steps: u64,
        recursion: impl for<'m, 'id> FnOnce(&Walk<'m, 'id>) -> Result<T, Halt>,
    ) -> Result<Option<T>> {
        let (result, steps) = self.shared(|m| {
            let checked = |walk: &Walk<'_, '_>| {
                self.check_limits(m)?;
                recursion(walk)
            };
            self.deep(|| Walk::run((self, m), how, steps, checked))
        });
        self.work.steps.fetch_add(steps, Relaxed);
        match result {
            Ok(found) => Ok(Some(found)),
            Err(Halt::Failed(error)) => Err(*error),
            Err(Halt::Spent) => Ok(None),
        }
    }

    /// Runs a recursion over diagrams without a step limit.
    pub(super) fn walk_to_the_end<T>(
        &self,
        how: (Direction, Option<&'static str>),
        recursion: impl for<'m, 'id> FnOnce(&Walk<'m, 'id>) -> Result<T, Halt>,
    ) -> Result<T> {
        self.walk(how, u64::MAX, recursion)?.ok_or_else(|| self.full())
    }
}
