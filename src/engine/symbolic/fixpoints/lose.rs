//! Removal of the attractor of lost states where all edges are plain, in one recursion over two sets
//! and the lists of all groups.
//!
//! It needs no operand per group. At the first bit, a group none of whose steps changes the bit
//! goes down into the half with the other groups of its kind. The other groups stay at this bit: a
//! state in which one of them has a choice that cannot step into a lost state is protected, so it is
//! not a candidate when the half below is closed. When states are lost, such choices are withdrawn,
//! the states left without one are candidates again, and the halves are closed again. This finds
//! losses of many layers in products of modules, where the recursion over parts has too many cases.

use std::mem;

use crate::symbolic::relations::lists::RelationList;
use crate::symbolic::relations::tuples::{Crossing, Half, ListTuple};
use crate::symbolic::store::Store;
use crate::symbolic::store::diagram::{Bdd, Diagram, Edge, Held, Memo};
use crate::symbolic::store::walk::{Direction, Halt, Walk};
use meliora_model::error::Result;

impl Store {
    /// Computes [`Walk::lose`]; `None` if that takes more than `steps` steps.
    pub(in crate::symbolic) fn lose(
        &self,
        lost: &Bdd,
        candidates: &Bdd,
        groups: &ListTuple,
        steps: u64,
    ) -> Result<Option<Bdd>> {
        let how = (Direction::Backward, Some("attractor removal"));
        self.walk(how, steps, |walk| walk.own(|w| w.lose(w.edge(lost), w.edge(candidates), groups)))
    }
}

/// One value of a bit.
struct Side<'m, 'id: 'm> {
    lost: Held<'m, 'id>,
    /// The candidates that no crossing group protects.
    free: Held<'m, 'id>,
    /// For each crossing group the candidates that it protects.
    protected: Vec<Held<'m, 'id>>,
    /// True if `lost` or `free` has grown since they were closed.
    open: bool,
}

impl<'m, 'id: 'm> Walk<'m, 'id> {
    /// Computes the least X ⊇ L that contains each s ∈ Q of which every list with a step from s has
    /// a step from s into X. Q contains no state of L.
    fn lose(&self, l: Edge<'_, 'id>, q: Edge<'_, 'id>, groups: &ListTuple) -> Result<Held<'m, 'id>, Halt> {
        if groups.stays || self.m.is_zero(q) {
            return Ok(self.m.held(l));
        }
        if groups.lists.is_empty() {
            return self.or(l, q);
        }
        if self.m.is_zero(l) {
            let stuck = self.minus(q, self.edge(self.sources(groups)?))?;
            if self.m.is_zero(stuck.borrowed()) {
                return Ok(stuck);
            }
        }
        if let Some(found) = self.m.recall(Memo::Lose, &[l, q], groups.number) {
            return Ok(found);
        }
        self.tick()?;
        let bit = self.top(l).min(self.top(q)).min(groups.top);
        let result = if bit < groups.top {
            let ([l0, l1], [q0, q1]) = (self.split(l, bit), self.split(q, bit));
            let (set, clear) = (self.lose(l1, q1, groups)?, self.lose(l0, q0, groups)?);
            self.node_among(2 * bit, set, clear, [(l, (l1, l0))])?
        } else {
            self.lose_across(bit, l, q, groups)?
        };
        self.m.remember(Memo::Lose, &[l, q], groups.number, result.borrowed());
        Ok(result)
    }

    /// Computes [`Walk::lose`] by splitting on the first bit of the lists.
    fn lose_across(
        &self,
        bit: u32,
        l: Edge<'_, 'id>,
        q: Edge<'_, 'id>,
        groups: &ListTuple,
    ) -> Result<Held<'m, 'id>, Halt> {
        let halves = groups.halves(self.store)?;
        let (lost, candidates) = (self.split(l, bit), self.split(q, bit));
        let side = |at: usize| self.protect(&halves[at], lost[at], lost[1 - at], candidates[at]);
        let mut sides = [side(0)?, side(1)?];
        // The half to which the other one cannot add losses comes first.
        let mut at = usize::from(halves[1].crossing.is_empty());
        while sides.iter().any(|side| side.open) {
            if mem::take(&mut sides[at].open) {
                self.lose_in(&mut sides, at, halves)?;
            } else {
                at = 1 - at;
            }
        }
        let [clear, set] = sides;
        self.node_among(2 * bit, set.lost, clear.lost, [(l, (lost[1], lost[0]))])
    }

    /// Finds the candidates that a crossing group protects from the losses on both sides.
    fn protect(
        &self,
        half: &Half,
        lost: Edge<'_, 'id>,
        across: Edge<'_, 'id>,
        candidates: Edge<'_, 'id>,
    ) -> Result<Side<'m, 'id>, Halt> {
        let mut free = self.m.held(candidates);
        let mut protected = Vec::with_capacity(half.crossing.len());
        for group in &half.crossing {
            let mut own = self.and(candidates, self.edge(self.crossing_sources(group)?))?;
            for (lost, steps) in [(lost, &group.stays), (across, &group.crosses)] {
                let gone = self.step(lost, own.borrowed(), steps)?;
                own = self.minus(own.borrowed(), gone.borrowed())?;
            }
            free = self.minus(free.borrowed(), own.borrowed())?;
            protected.push(own);
        }
        Ok(Side { lost: self.m.held(lost), free, protected, open: true })
    }

    /// Adds the losses below to one side, and withdraws the choices that may step into them.
    fn lose_in(&self, sides: &mut [Side<'m, 'id>; 2], at: usize, halves: &[Half; 2]) -> Result<(), Halt> {
        let side = &mut sides[at];
        let now = self.lose(side.lost.borrowed(), side.free.borrowed(), &halves[at].below)?;
        if now.borrowed() == side.lost.borrowed() {
            return Ok(());
        }
        let new = self.minus(now.borrowed(), side.lost.borrowed())?;
        side.free = self.minus(side.free.borrowed(), new.borrowed())?;
        side.lost = now;
        self.withdraw_steps(&mut sides[at], new.borrowed(), &halves[at], |group| &group.stays)?;
        self.withdraw_steps(&mut sides[1 - at], new.borrowed(), &halves[1 - at], |group| &group.crosses)
    }

    /// Withdraws the choices of a side with a step into new losses. The states that no group protects
    /// any more become free.
    fn withdraw_steps(
        &self,
        side: &mut Side<'m, 'id>,
        new: Edge<'_, 'id>,
        half: &Half,
        steps: impl Fn(&Crossing) -> &RelationList,
    ) -> Result<(), Halt> {
        let mut hit = self.zero();
        for (own, group) in side.protected.iter_mut().zip(&half.crossing) {
            let gone = self.step(new, own.borrowed(), steps(group))?;
            if !self.m.is_zero(gone.borrowed()) {
                *own = self.minus(own.borrowed(), gone.borrowed())?;
                hit = self.or(hit.borrowed(), gone.borrowed())?;
            }
        }
        for own in &side.protected {
            hit = self.minus(hit.borrowed(), own.borrowed())?;
        }
        if !self.m.is_zero(hit.borrowed()) {
            side.free = self.or(side.free.borrowed(), hit.borrowed())?;
            side.open = true;
        }
        Ok(())
    }

    /// Returns the states in which some list of a tuple has a step.
    fn sources<'l>(&self, groups: &'l ListTuple) -> Result<&'l Bdd, Halt> {
        if let Some(found) = groups.sources.get() {
            return Ok(found);
        }
        let mut all = self.zero();
        for list in &groups.lists {
            all = self.or(all.borrowed(), self.list_sources(list)?.borrowed())?;
        }
        let all = self.m.handle(all.borrowed());
        Ok(groups.sources.get_or_init(|| all))
    }

    fn crossing_sources<'l>(&self, group: &'l Crossing) -> Result<&'l Bdd, Halt> {
        if let Some(found) = group.sources.get() {
            return Ok(found);
        }
        let (stays, crosses) = (self.list_sources(&group.stays)?, self.list_sources(&group.crosses)?);
        let both = self.or(stays.borrowed(), crosses.borrowed())?;
        let both = self.m.handle(both.borrowed());
        Ok(group.sources.get_or_init(|| both))
    }

    fn list_sources(&self, list: &RelationList) -> Result<Held<'m, 'id>, Halt> {
        let anywhere = self.m.constant(true);
        self.step(anywhere.borrowed(), anywhere.borrowed(), list)
    }
}
