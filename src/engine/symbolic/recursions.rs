//! The recursions over diagrams and relations, run on a store.

use std::sync::atomic::Ordering::Relaxed;

use oxidd::Function;

use super::attractor::Removed;
use super::diagram::Bdd;
use super::parts::{Budget, Known, Part};
use super::relation_lists::RelationList;
use super::store::Store;
use super::support::Support;
use super::walk::{Direction, Halt, Walk};
use crate::error::Result;

impl Store {
    /// { s ∈ B : one step of the list, in a direction, joins s and X }
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

    /// μY. X ∪ { s ∈ B : one step of the list, in a direction, joins s and Y }, for X ⊆ B.
    ///
    /// By the recursion over all relations, mostly better by far, or by saturation, which is where parts
    /// that read much of each other go through many rounds. Where the way that was best last time takes
    /// long, the other one gets a chance, and more steps: where saturation is better it is so by ten times,
    /// where recursion is, by two or three. So it goes on, each time with more steps, until one is through;
    /// what was found on the way is still remembered, as far as the operation cache holds it.
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

    /// [`Store::reach`] by one way; none where it takes more than so many steps.
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

    /// What is lost with `new`; none where that takes more than `most`. See [`Walk::remove_attractor`].
    pub(super) fn remove_attractor(
        &self,
        new: &Bdd,
        parts: &[Part],
        most: Budget,
    ) -> Result<Option<Removed>> {
        let how = (Direction::Backward, Some("attractor removal"));
        self.walk(how, most.steps, |walk| walk.remove_attractor(new, parts, &mut Known::new(most.cases)))
    }

    /// What can reach X by some parts; none where that takes more than `most`. See
    /// [`Walk::reach_by`].
    pub(super) fn reach_by(&self, x: &Bdd, parts: &[Part], most: Budget) -> Result<Option<Bdd>> {
        let how = (Direction::Backward, Some("backward reachability"));
        self.walk(how, most.steps, |walk| walk.reach_by(x, parts, &mut Known::new(most.cases)))
    }

    /// X over the next state: the support variables primed.
    pub(super) fn primed(&self, support: &Support, x: &Bdd) -> Result<Bdd> {
        let how = (Direction::Forward, None);
        self.walk_to_the_end(how, |walk| walk.own(|w| w.primed(x.as_edge(w.m), support)))
    }

    /// Runs a recursion over diagrams; none where it takes more than so many steps.
    fn walk<T>(
        &self,
        (direction, phase): (Direction, Option<&'static str>),
        steps: u64,
        recursion: impl for<'m, 'id> FnOnce(&Walk<'m, 'id>) -> Result<T, Halt>,
    ) -> Result<Option<T>> {
        self.safe_point()?;
        let halted = self.shared(|m| self.deep(|| recursion(&Walk::new(self, m, direction, phase, steps))));
        match halted {
            Ok(found) => Ok(Some(found)),
            Err(Halt::Failed(error)) => Err(error),
            Err(Halt::Spent) => Ok(None),
        }
    }

    /// The same with more steps than any machine takes.
    pub(super) fn walk_to_the_end<T>(
        &self,
        how: (Direction, Option<&'static str>),
        recursion: impl for<'m, 'id> FnOnce(&Walk<'m, 'id>) -> Result<T, Halt>,
    ) -> Result<T> {
        self.walk(how, u64::MAX, recursion)?.ok_or_else(|| self.full())
    }
}
