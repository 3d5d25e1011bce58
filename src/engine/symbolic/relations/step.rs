//! One step of a list of relations, as a recursion over a set, a bound and the list.

use super::lists::{Cofactors, RelationList};
use super::support::Support;
use crate::symbolic::store::Store;
use crate::symbolic::store::diagram::{Bdd, Diagram, Edge, Held, Memo};
use crate::symbolic::store::walk::{ByNode, Direction, Halt, Pass, Walk};
use meliora_base::error::Result;

impl Store {
    /// Computes { s ∈ B : one step of the list, in a direction, joins s and X }.
    pub(in crate::symbolic) fn step(
        &self,
        direction: Direction,
        list: &RelationList,
        x: &Bdd,
        bound: &Bdd,
    ) -> Result<Bdd> {
        self.walk_to_the_end(Pass { direction, phase: None }, |walk| {
            walk.own(|w| w.step(w.edge(x), w.edge(bound), list))
        })
    }

    /// Computes { s ∈ B : no step of the list, in a direction, joins s and X }.
    pub(in crate::symbolic) fn spare(
        &self,
        direction: Direction,
        list: &RelationList,
        x: &Bdd,
        bound: &Bdd,
    ) -> Result<Bdd> {
        self.walk_to_the_end(Pass { direction, phase: None }, |walk| {
            walk.own(|w| w.spare(w.edge(x), w.edge(bound), list))
        })
    }

    /// Returns X over the next state: the support bits are replaced by their next copies.
    pub(in crate::symbolic) fn primed(&self, support: &Support, x: &Bdd) -> Result<Bdd> {
        self.walk_to_the_end(Pass::forward(None), |walk| walk.own(|w| w.primed(w.edge(x), support)))
    }
}

impl<'m, 'id: 'm> Walk<'m, 'id> {
    /// Returns the cofactors of a list by its first bit. Counts a step for each relation that is made, since it takes
    /// about as long.
    pub(in crate::symbolic) fn cofactors<'l>(&self, list: &'l RelationList) -> Result<&'l Cofactors, Halt> {
        (0..list.missing()).try_for_each(|_| self.tick())?;
        Ok(list.cofactors(self.store)?)
    }

    /// Computes { s ∈ B : one step of the list joins s and X }.
    ///
    /// The recursion never leaves B. States outside it, which are often many and irregular, are not
    /// built.
    pub(in crate::symbolic) fn step(
        &self,
        x: Edge<'_, 'id>,
        b: Edge<'_, 'id>,
        list: &RelationList,
    ) -> Result<Held<'m, 'id>, Halt> {
        if list.is_empty() || self.m.is_zero(x) || self.m.is_zero(b) {
            return Ok(self.zero());
        }
        if let Some(kept) = list.kept() {
            let both = self.and(x, b)?;
            return self.and(self.edge(kept), both.borrowed());
        }
        if let Some(found) = self.m.recall(Memo::Step, &[x, b], self.number(list)) {
            return Ok(found);
        }
        self.tick()?;
        let bit = self.top(x).min(self.top(b)).min(list.top);
        let ([x0, x1], [b0, b1]) = (self.split(x, bit), self.split(b, bit));
        let (set, clear) = if bit < list.top {
            (self.step(x1, b1, list)?, self.step(x0, b0, list)?)
        } else {
            let cofactors = self.cofactors(list)?;
            let half = |to: bool, b: Edge<'_, 'id>| {
                let stays = self.step(if to { x1 } else { x0 }, b, self.cofactor(cofactors, to, to))?;
                if stays.borrowed() == b {
                    return Ok(stays);
                }
                let crosses = self.step(if to { x0 } else { x1 }, b, self.cofactor(cofactors, !to, to))?;
                self.or(stays.borrowed(), crosses.borrowed())
            };
            (half(true, b1)?, half(false, b0)?)
        };
        let result = self.node_among(2 * bit, set, clear, [(b, (b1, b0))])?;
        self.m.remember(Memo::Step, &[x, b], self.number(list), result.borrowed());
        Ok(result)
    }

    /// Computes { s ∈ B : no step of the list joins s and X }.
    ///
    /// Unlike the complement of [`Walk::step`], it unites no intermediate results: the states without
    /// a step into one half are the bound for the other half.
    pub(in crate::symbolic) fn spare(
        &self,
        x: Edge<'_, 'id>,
        b: Edge<'_, 'id>,
        list: &RelationList,
    ) -> Result<Held<'m, 'id>, Halt> {
        if list.is_empty() || self.m.is_zero(x) || self.m.is_zero(b) {
            return Ok(self.m.held(b));
        }
        if let Some(kept) = list.kept() {
            let gone = self.and(self.edge(kept), x)?;
            return self.minus(b, gone.borrowed());
        }
        if let Some(found) = self.m.recall(Memo::Spare, &[x, b], self.number(list)) {
            return Ok(found);
        }
        self.tick()?;
        let bit = self.top(x).min(self.top(b)).min(list.top);
        let ([x0, x1], [b0, b1]) = (self.split(x, bit), self.split(b, bit));
        let (set, clear) = if bit < list.top {
            (self.spare(x1, b1, list)?, self.spare(x0, b0, list)?)
        } else {
            let cofactors = self.cofactors(list)?;
            let half = |to: bool, b: Edge<'_, 'id>| {
                let (own, other) = if to { (x1, x0) } else { (x0, x1) };
                let left = self.spare(own, b, self.cofactor(cofactors, to, to))?;
                self.spare(other, left.borrowed(), self.cofactor(cofactors, !to, to))
            };
            (half(true, b1)?, half(false, b0)?)
        };
        let result = self.node_among(2 * bit, set, clear, [(b, (b1, b0))])?;
        self.m.remember(Memo::Spare, &[x, b], self.number(list), result.borrowed());
        Ok(result)
    }

    /// Returns the steps that lead, in the direction of this recursion, from one value of the bit
    /// to another.
    pub(in crate::symbolic) fn cofactor<'q>(
        &self,
        cofactors: &'q Cofactors,
        from: bool,
        to: bool,
    ) -> &'q RelationList {
        match self.direction {
            Direction::Forward => cofactors.step(from, to),
            Direction::Backward => cofactors.step(to, from),
        }
    }

    /// Returns the key of a list in the operation cache, for the direction of this recursion.
    pub(in crate::symbolic) fn number(&self, list: &RelationList) -> u32 {
        list.number + u32::from(self.direction == Direction::Backward)
    }

    /// Returns X with its support bits replaced by their next copies.
    pub(in crate::symbolic) fn primed(
        &self,
        x: Edge<'_, 'id>,
        support: &Support,
    ) -> Result<Held<'m, 'id>, Halt> {
        self.prime(x, support, &mut ByNode::new(self.store))
    }

    fn prime(
        &self,
        x: Edge<'_, 'id>,
        support: &Support,
        known: &mut ByNode<'m, 'id>,
    ) -> Result<Held<'m, 'id>, Halt> {
        let bit = self.top(x);
        let support = support.from(bit);
        if support.is_empty() {
            return Ok(self.m.held(x));
        }
        if let Some(found) = known.get(self.m, x.node_id()) {
            return Ok(found);
        }
        self.tick()?;
        let [clear, set] = self.split(x, bit);
        let (clear, set) = (self.prime(clear, &support, known)?, self.prime(set, &support, known)?);
        let result = self.node_on(2 * bit + u32::from(support.top() == bit), set, clear)?;
        known.insert(self.m, x.node_id(), &result);
        Ok(result)
    }
}
