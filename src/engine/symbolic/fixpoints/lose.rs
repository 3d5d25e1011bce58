//! Removal of the attractor of lost states where all edges are plain, in one recursion over two sets
//! and the lists of all groups.
//!
//! It needs no operand per group. At the first bit, a group none of whose steps changes the bit
//! goes down into the half with the other groups of its kind. The other groups stay at this bit: a
//! state in which one of them has a choice that cannot step into a lost state is protected, so it is
//! not a candidate when the half below is closed. Only the first such group is noted. When states are
//! lost, such choices are withdrawn, and the next group that protects the state is noted. The states
//! left without one are candidates again, and the halves are closed again. This finds losses of many
//! layers in products of modules, where the recursion over parts has too many cases.

use std::{iter, mem};

use crate::symbolic::relations::lists::RelationList;
use crate::symbolic::relations::tuples::{Crossing, Half, ListTuple};
use crate::symbolic::store::Store;
use crate::symbolic::store::diagram::{Bdd, Diagram, Edge, Held, Memo};
use crate::symbolic::store::walk::{Direction, Halt, Pass, Walk};
use meliora_base::error::Result;

impl Store {
    /// Computes [`Walk::lose`]. Returns also whether it is finished; if it takes more than `steps`
    /// steps, the result has only some of the lost states.
    pub(in crate::symbolic) fn lose(
        &self,
        lost: &Bdd,
        candidates: &Bdd,
        groups: &ListTuple,
        steps: u64,
    ) -> Result<(Bdd, bool)> {
        let found = self.walk(Pass::backward("attractor removal"), steps, |walk| {
            let found = walk.own(|w| w.lose(w.edge(lost), w.edge(candidates), groups))?;
            Ok((found, !walk.is_spent()))
        });
        Ok(found?.unwrap_or_else(|| (lost.clone(), false)))
    }

    /// Returns the states of X of which every list with a step has one into L.
    ///
    /// Cost: one pre-image per group.
    pub(in crate::symbolic) fn stuck(&self, l: &Bdd, x: Bdd, groups: &ListTuple) -> Result<Bdd> {
        if groups.stays {
            return Ok(self.zero());
        }
        let mut open = x;
        for group in groups.groups() {
            let own = self.and(&open, &group.sources)?;
            let kept = self.spare(Direction::Backward, &group.list, l, &own)?;
            open = self.minus(&open, &kept)?;
        }
        Ok(open)
    }
}

/// One value of a bit.
struct Side<'m, 'id: 'm> {
    lost: Held<'m, 'id>,
    /// The candidates that no crossing group protects.
    free: Held<'m, 'id>,
    /// For each crossing group the candidates that it protects and no group before it does.
    protected: Vec<Held<'m, 'id>>,
    /// True if `lost` or `free` has grown since they were closed.
    open: bool,
}

impl<'m, 'id: 'm> Walk<'m, 'id> {
    /// Computes the least X ⊇ L that contains each s ∈ Q of which every list with a step from s has
    /// a step from s into X. Q contains no state of L. Returns a smaller set once no step is left.
    fn lose(&self, l: Edge<'_, 'id>, q: Edge<'_, 'id>, tuple: &ListTuple) -> Result<Held<'m, 'id>, Halt> {
        if tuple.stays || self.m.is_zero(q) || self.is_spent() {
            return Ok(self.m.held(l));
        }
        if tuple.here.is_empty() {
            return self.or(l, q);
        }
        if self.m.is_zero(l) {
            let stuck = self.minus(q, self.edge(self.sources(tuple)?))?;
            if self.m.is_zero(stuck.borrowed()) {
                return Ok(stuck);
            }
        }
        if let Some(found) = self.m.recall(Memo::Lose, &[l, q], tuple.number) {
            return Ok(found);
        }
        self.tick()?;
        let bit = self.top(l).min(self.top(q)).min(tuple.top);
        let result = if bit < tuple.top {
            let ([l0, l1], [q0, q1]) = (self.split(l, bit), self.split(q, bit));
            let (set, clear) = (self.lose(l1, q1, tuple)?, self.lose(l0, q0, tuple)?);
            self.node_among(2 * bit, set, clear, [(l, (l1, l0))])?
        } else {
            self.lose_across(bit, l, q, tuple)?
        };
        if !self.is_spent() {
            self.m.remember(Memo::Lose, &[l, q], tuple.number, result.borrowed());
        }
        Ok(result)
    }

    /// Computes [`Walk::lose`] by splitting on the first bit of the lists.
    fn lose_across(
        &self,
        bit: u32,
        l: Edge<'_, 'id>,
        q: Edge<'_, 'id>,
        tuple: &ListTuple,
    ) -> Result<Held<'m, 'id>, Halt> {
        let halves = tuple.halves(self.store)?;
        let (lost, candidates) = (self.split(l, bit), self.split(q, bit));
        let side = |at: usize| self.protect(&halves[at], lost[at], lost[1 - at], candidates[at]);
        let mut sides = [side(0)?, side(1)?];
        // The half to which the other one cannot add losses comes first.
        let mut at = usize::from(halves[1].crossing.is_empty());
        while sides.iter().any(|side| side.open) {
            if !mem::take(&mut sides[at].open) {
                at = 1 - at;
                continue;
            }
            match self.lose_in(&mut sides, at, halves) {
                // The states found so far are lost.
                Err(Halt::Spent) => break,
                done => done?,
            }
        }
        let [clear, set] = sides;
        self.node_among(2 * bit, set.lost, clear.lost, [(l, (lost[1], lost[0]))])
    }

    /// Finds for each candidate the first crossing group that protects it from the losses on both sides.
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
            let own = self.kept_by(group, free.borrowed(), [lost, across])?;
            free = self.minus(free.borrowed(), own.borrowed())?;
            protected.push(own);
        }
        Ok(Side { lost: self.m.held(lost), free, protected, open: true })
    }

    /// { s ∈ X : the group has a step from s, and none into the losses on this side or across }
    fn kept_by(
        &self,
        group: &Crossing,
        x: Edge<'_, 'id>,
        [lost, across]: [Edge<'_, 'id>; 2],
    ) -> Result<Held<'m, 'id>, Halt> {
        let own = self.and(x, self.edge(&group.sources))?;
        let own = self.spare(lost, own.borrowed(), &group.stays)?;
        self.spare(across, own.borrowed(), &group.crosses)
    }

    /// Adds the losses below to one side, and withdraws the choices that may step into them.
    fn lose_in(&self, sides: &mut [Side<'m, 'id>; 2], at: usize, halves: &[Half; 2]) -> Result<(), Halt> {
        let side = &mut sides[at];
        let now = self.lose(side.lost.borrowed(), side.free.borrowed(), &halves[at].below)?;
        if now.borrowed() == side.lost.borrowed() {
            return Ok(());
        }
        let before = mem::replace(&mut side.lost, now);
        let new = self.minus(side.lost.borrowed(), before.borrowed())?;
        side.free = self.minus(side.free.borrowed(), new.borrowed())?;
        let across = self.m.held(side.lost.borrowed());
        let [clear, set] = sides;
        let (side, other) = if at == 0 { (clear, set) } else { (set, clear) };
        self.withdraw_steps(side, new.borrowed(), other.lost.borrowed(), &halves[at], |group| &group.stays)?;
        self.withdraw_steps(other, new.borrowed(), across.borrowed(), &halves[1 - at], |group| &group.crosses)
    }

    /// Withdraws the choices of a side with a step into new losses. Each state that loses its protection
    /// gets it from the next group that still can; those before cannot any more. The states that no group
    /// protects become free.
    fn withdraw_steps(
        &self,
        side: &mut Side<'m, 'id>,
        new: Edge<'_, 'id>,
        across: Edge<'_, 'id>,
        half: &Half,
        steps: impl Fn(&Crossing) -> &RelationList,
    ) -> Result<(), Halt> {
        let mut hit = self.zero();
        for (own, group) in side.protected.iter_mut().zip(&half.crossing) {
            let left = self.spare(new, own.borrowed(), steps(group))?;
            let gone = self.minus(own.borrowed(), left.borrowed())?;
            let more = self.kept_by(group, hit.borrowed(), [side.lost.borrowed(), across])?;
            hit = self.minus(hit.borrowed(), more.borrowed())?;
            hit = self.or(hit.borrowed(), gone.borrowed())?;
            *own = self.or(left.borrowed(), more.borrowed())?;
        }
        if !self.m.is_zero(hit.borrowed()) {
            side.free = self.or(side.free.borrowed(), hit.borrowed())?;
            side.open = true;
        }
        Ok(())
    }

    /// Returns the states in which some group of a tuple has a step.
    fn sources<'l>(&self, tuple: &'l ListTuple) -> Result<&'l Bdd, Halt> {
        if let Some(found) = tuple.sources.get() {
            return Ok(found);
        }
        let links = iter::successors(Some(tuple), |tuple| tuple.below.as_deref());
        let unknown = Vec::from_iter(links.take_while(|tuple| tuple.sources.get().is_none()));
        let mut all = self.zero();
        for link in unknown.into_iter().rev() {
            if let Some(below) = link.below.as_ref().and_then(|below| below.sources.get()) {
                all = self.m.held(self.edge(below));
            }
            for group in &*link.here {
                all = self.or(all.borrowed(), self.edge(&group.sources))?;
            }
            link.sources.get_or_init(|| self.m.handle(all.borrowed()));
        }
        Ok(tuple.sources.get_or_init(|| self.m.handle(all.borrowed())))
    }
}
