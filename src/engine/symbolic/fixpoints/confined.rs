//! Reachability by allowed choices, in one recursion over a set, bounds and relations.
//!
//! It is like [`Walk::close`], but each group of choices has its own bound, and steps into some
//! states may not count. Neither requires new relations.

use std::sync::Arc;

use super::parts::{self, Known, Part};
use crate::symbolic::relations::lists::RelationList;
use crate::symbolic::store::diagram::Bdd;
use crate::symbolic::store::walk::{Halt, Walk};

/// The states with one value of a bit: their choices, and the states reached among them.
struct Half {
    parts: Vec<Part>,
    reached: Bdd,
    /// True if states were reached to which the parts have not been applied.
    open: bool,
    /// The states from which the other half has already been entered.
    crossed: Bdd,
}

impl<'m, 'id: 'm> Walk<'m, 'id> {
    /// Computes μY. X ∪ { s : some part allows s and has a step from s into Y that counts }.
    pub(in crate::symbolic) fn reach_by(
        &self,
        x: &Bdd,
        parts: &[Part],
        known: &mut Known<Bdd>,
    ) -> Result<Bdd, Halt> {
        let parts = Vec::from_iter(parts.iter().filter(|p| p.changes_state(self.store)).cloned());
        if self.store.is_zero(x) || parts.is_empty() {
            return Ok(x.clone());
        }
        let operands = parts::operands(&parts);
        let key = (x.clone(), operands.clone());
        if let Some(found) = known.get(&key) {
            return Ok(found);
        }
        self.tick_for(&parts)?;
        let found = self.reach_by_across(self.first_bit(x, &parts), x, &parts, known)?;
        known.insert(key, found.clone());
        // The closure of a closed set is the set itself.
        known.insert((found.clone(), operands), found.clone());
        Ok(found)
    }

    /// Computes [`Walk::reach_by`] by splitting on a bit.
    fn reach_by_across(
        &self,
        bit: u32,
        x: &Bdd,
        parts: &[Part],
        known: &mut Known<Bdd>,
    ) -> Result<Bdd, Halt> {
        let half = |value| {
            let (parts, reached) = (self.half(bit, value, parts)?, self.side(x, bit, value));
            Ok::<_, Halt>(Half { parts, reached, open: true, crossed: self.store.zero() })
        };
        let mut halves = [half(false)?, half(true)?];
        let arcs = [self.arcs(bit, parts, true, false)?, self.arcs(bit, parts, false, true)?];
        // A half that is entered before it is closed is closed once instead of twice.
        let mut at = usize::from(arcs[0].iter().all(|cofactor| cofactor.is_empty()));
        while halves[at].open || halves[at].reached != halves[at].crossed {
            if std::mem::take(&mut halves[at].open) {
                halves[at].reached = self.reach_by(&halves[at].reached, &halves[at].parts, known)?;
            }
            self.cross(&mut halves, at, &arcs[at])?;
            at = 1 - at;
        }
        let [clear, set] = halves;
        self.joined(bit, &set.reached, &clear.reached)
    }

    /// Adds to the other half the states with a step into the new states of half `at`.
    fn cross(&self, halves: &mut [Half; 2], at: usize, arcs: &[Arc<RelationList>]) -> Result<(), Halt> {
        let to = 1 - at;
        let new = self.both(Walk::minus, &halves[at].reached, &halves[at].crossed)?;
        halves[at].crossed = halves[at].reached.clone();
        // The new sets are small, so they are united with each other first.
        let mut entered = self.store.zero();
        for (index, cofactor) in arcs.iter().enumerate().filter(|(_, cofactor)| !cofactor.is_empty()) {
            let (except, allowed) = (&halves[at].parts[index].except, &halves[to].parts[index].allowed);
            let own = self.enter(&new, except, allowed, cofactor)?;
            entered = self.both(Walk::or, &entered, &own)?;
        }
        let reached = self.both(Walk::or, &halves[to].reached, &entered)?;
        halves[to].open |= reached != halves[to].reached;
        halves[to].reached = reached;
        Ok(())
    }
}
