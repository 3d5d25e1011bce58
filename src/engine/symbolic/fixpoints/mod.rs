//! Fixpoints: recursions over the diagrams of sets and the lists of relations at once, run on a
//! store.
//!
//! `reach` and `saturation` compute the states that are reachable within a bound. `parts` are groups
//! of choices, each with a bound of its own; `confined` and `attractor` are recursions over them. `lose` removes
//! losing states without a bound per group.

pub(in crate::symbolic) mod attractor;
pub(in crate::symbolic) mod confined;
pub(in crate::symbolic) mod lose;
pub(in crate::symbolic) mod parts;
mod reach;
mod saturation;

use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

use crate::schedule::Schedule;
use crate::symbolic::relations::lists::RelationList;
use crate::symbolic::store::Store;
use crate::symbolic::store::diagram::Bdd;
use crate::symbolic::store::walk::{Direction, Walk};
use attractor::Removed;
use meliora_base::error::Result;
use parts::{Known, Part};

impl Store {
    /// Computes μY. X ∪ { s ∈ B : one step of the list, in a direction, joins s and Y } for X ⊆ B.
    ///
    /// Two methods take turns: the recursion over all relations, which is usually faster, and saturation, which is
    /// faster where components that read much of each other need many rounds. The one that ended last in this
    /// direction is the first. Intermediate results are reused as long as the operation cache still has them.
    pub(in crate::symbolic) fn reach(
        &self,
        (direction, phase): (Direction, &'static str),
        list: &RelationList,
        x: &Bdd,
        bound: &Bdd,
    ) -> Result<Bdd> {
        self.progress(phase);
        let usual = self.saturates(direction).load(Relaxed);
        let how = (direction, Some(phase));
        let found = Schedule::new(2, self.thresholds().first_turn)
            .first_to_end(|turn| self.fixpoint(usual ^ (turn.way == 1), how, turn.steps, list, (x, bound)));
        found?.ok_or_else(|| self.full())
    }

    /// Computes [`Store::reach`] by the method that ended last in this direction; `None` if it takes more than
    /// `steps` steps.
    pub(in crate::symbolic) fn reach_as_before(
        &self,
        how: (Direction, Option<&'static str>),
        steps: u64,
        list: &RelationList,
        of: (&Bdd, &Bdd),
    ) -> Result<Option<Bdd>> {
        self.fixpoint(self.saturates(how.0).load(Relaxed), how, steps, list, of)
    }

    /// Computes [`Store::reach`] by saturation or by the recursion; `None` if it takes more than `steps` steps.
    pub(in crate::symbolic) fn fixpoint(
        &self,
        by_saturation: bool,
        how: (Direction, Option<&'static str>),
        steps: u64,
        list: &RelationList,
        (x, bound): (&Bdd, &Bdd),
    ) -> Result<Option<Bdd>> {
        let close =
            |walk: &Walk<'_, '_>| walk.own(|w| w.close(by_saturation, w.edge(x), w.edge(bound), list));
        let found = self.walk(how, steps, close)?;
        if found.is_some() {
            self.work.reached[usize::from(by_saturation)].fetch_add(1, Relaxed);
            self.saturates(how.0).store(by_saturation, Relaxed);
        }
        Ok(found)
    }

    /// Returns whether saturation ended last in a direction.
    fn saturates(&self, direction: Direction) -> &AtomicBool {
        &self.saturates[usize::from(direction == Direction::Backward)]
    }

    /// Computes [`Walk::remove_attractor`]; `None` if that takes more than `steps` steps.
    pub(in crate::symbolic) fn remove_attractor(
        &self,
        new: &Bdd,
        parts: &[Part],
        steps: u64,
    ) -> Result<Option<Removed>> {
        let how = (Direction::Backward, Some("attractor removal"));
        self.walk(how, steps, |walk| walk.remove_attractor(new, parts, &mut Known::new(self)))
    }

    /// Computes [`Walk::reach_by`]; `None` if that takes more than `steps` steps.
    pub(in crate::symbolic) fn reach_by(&self, x: &Bdd, parts: &[Part], steps: u64) -> Result<Option<Bdd>> {
        let how = (Direction::Backward, Some("backward reachability"));
        self.walk(how, steps, |walk| walk.reach_by(x, parts, &mut Known::new(self)))
    }
}
