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

use std::ops::Range;
use std::sync::atomic::Ordering::Relaxed;

use crate::schedule::{Leader, Schedule, Turn};
use crate::symbolic::relations::lists::RelationList;
use crate::symbolic::store::Store;
use crate::symbolic::store::diagram::Bdd;
use crate::symbolic::store::walk::{Direction, Pass, Walk};
use attractor::Removed;
use meliora_base::error::Result;
use parts::{Known, Part};

impl Store {
    /// Lets some ways to a fixpoint take turns until one of them ends. That one leads the next search of this kind, unless
    /// it was the only way: then nothing was compared.
    ///
    /// # Errors
    /// The first error of a turn.
    pub(in crate::symbolic) fn in_turns<T>(
        &self,
        leader: &Leader,
        ways: Range<usize>,
        mut take: impl FnMut(Turn) -> Result<Option<T>>,
    ) -> Result<T> {
        let (steps, is_choice) = (&self.work.steps, ways.len() > 1);
        for turn in Schedule::new(ways, self.thresholds().first_turn, leader) {
            let before = steps.load(Relaxed);
            if let Some(found) = take(turn)? {
                if is_choice {
                    leader.ended(turn.way, steps.load(Relaxed) - before);
                }
                return Ok(found);
            }
        }
        Err(self.full())
    }

    /// Computes μY. X ∪ { s ∈ B : one step of the list, in a direction, joins s and Y } for X ⊆ B.
    ///
    /// Two methods take turns: the recursion over all relations, which is usually faster, and saturation, which is
    /// faster where components that read much of each other need many rounds; it is way 1. Intermediate results are
    /// reused as long as the operation cache still has them.
    pub(in crate::symbolic) fn reach(
        &self,
        pass: Pass,
        list: &RelationList,
        x: &Bdd,
        bound: &Bdd,
    ) -> Result<Bdd> {
        self.progress(pass.phase.unwrap_or_default());
        self.in_turns(self.reach_leader(pass.direction), 0..2, |turn| {
            self.fixpoint(turn.way == 1, pass, turn.steps, list, x, bound)
        })
    }

    /// Computes [`Store::reach`] by the method that ended last in this direction; `None` if it takes more than
    /// `steps` steps.
    pub(in crate::symbolic) fn reach_as_before(
        &self,
        pass: Pass,
        steps: u64,
        list: &RelationList,
        x: &Bdd,
        bound: &Bdd,
    ) -> Result<Option<Bdd>> {
        let by_saturation = self.reach_leader(pass.direction).way() == 1;
        self.fixpoint(by_saturation, pass, steps, list, x, bound)
    }

    /// Computes [`Store::reach`] by saturation or by the recursion; `None` if it takes more than `steps` steps.
    pub(in crate::symbolic) fn fixpoint(
        &self,
        by_saturation: bool,
        pass: Pass,
        steps: u64,
        list: &RelationList,
        x: &Bdd,
        bound: &Bdd,
    ) -> Result<Option<Bdd>> {
        let close =
            |walk: &Walk<'_, '_>| walk.own(|w| w.close(by_saturation, w.edge(x), w.edge(bound), list));
        let found = self.walk(pass, steps, close)?;
        if found.is_some() {
            self.work.reached[usize::from(by_saturation)].fetch_add(1, Relaxed);
        }
        Ok(found)
    }

    /// Returns the method of [`Store::reach`] that leads in a direction.
    fn reach_leader(&self, direction: Direction) -> &Leader {
        &self.leaders.reach[usize::from(direction == Direction::Backward)]
    }

    /// Computes [`Walk::remove_attractor`]; `None` if that takes more than `steps` steps.
    pub(in crate::symbolic) fn remove_attractor(
        &self,
        new: &Bdd,
        parts: &[Part],
        steps: u64,
    ) -> Result<Option<Removed>> {
        self.walk(Pass::backward("attractor removal"), steps, |walk| {
            walk.remove_attractor(new, parts, &mut Known::new(self))
        })
    }

    /// Computes [`Walk::reach_by`]; `None` if that takes more than `steps` steps.
    pub(in crate::symbolic) fn reach_by(&self, x: &Bdd, parts: &[Part], steps: u64) -> Result<Option<Bdd>> {
        self.walk(Pass::backward("backward reachability"), steps, |walk| {
            walk.reach_by(x, parts, &mut Known::new(self))
        })
    }
}
