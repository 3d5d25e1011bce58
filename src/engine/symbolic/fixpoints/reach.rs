//! Reachability in one recursion over a set and all relations.
//!
//! At the first bit the set, its bound and every relation split into halves. The steps that keep
//! the bit close each half by the same recursion. The steps that change it lead from the new states
//! of one half into the other, until there are no new states (REACH: Brand, Bäck and Laarman, A
//! decision diagram operation for reachability, FM 2023; here over lists of partial relations, in
//! either direction, and within a bound).

use crate::symbolic::relations::lists::RelationList;
use crate::symbolic::store::diagram::{Diagram, Edge, Held, Memo};
use crate::symbolic::store::walk::{Halt, Walk};

impl<'m, 'id: 'm> Walk<'m, 'id> {
    /// Computes μY. X ∪ { s ∈ B : one step of the list joins s and Y } for X ⊆ B, by saturation or
    /// by this recursion.
    pub(in crate::symbolic) fn close(
        &self,
        by_saturation: bool,
        x: Edge<'_, 'id>,
        b: Edge<'_, 'id>,
        list: &RelationList,
    ) -> Result<Held<'m, 'id>, Halt> {
        if !list.changes_state() || x == b || self.m.is_zero(x) {
            return Ok(self.m.held(x));
        }
        let number = self.number(list);
        if let Some(found) = self.m.recall(Memo::Close, &[x, b], number) {
            return Ok(found);
        }
        self.tick()?;
        let bit = self.top(x).min(self.top(b)).min(list.top);
        let closed = if bit < list.top {
            let ([x0, x1], [b0, b1]) = (self.split(x, bit), self.split(b, bit));
            let (set, clear) =
                (self.close(by_saturation, x1, b1, list)?, self.close(by_saturation, x0, b0, list)?);
            self.node_among(2 * bit, set, clear, [(x, (x1, x0)), (b, (b1, b0))])?
        } else if by_saturation {
            self.fire(x, b, list.layers(self.store)?)?
        } else {
            self.reach_across(bit, x, b, list)?
        };
        self.m.remember(Memo::Close, &[x, b], number, closed.borrowed());
        if !by_saturation && closed.borrowed() != x {
            self.m.remember(Memo::Close, &[closed.borrowed(), b], number, closed.borrowed());
        }
        Ok(closed)
    }

    /// Computes [`Walk::close`] by this recursion, for a list that depends on the first bit.
    fn reach_across(
        &self,
        bit: u32,
        x: Edge<'_, 'id>,
        b: Edge<'_, 'id>,
        list: &RelationList,
    ) -> Result<Held<'m, 'id>, Halt> {
        let cofactors = self.cofactors(list)?;
        let (whole, b) = (b, self.split(b, bit));
        let stays = [self.cofactor(cofactors, false, false), self.cofactor(cofactors, true, true)];
        let crosses = [self.cofactor(cofactors, false, true), self.cofactor(cofactors, true, false)];
        let mut closed = self.split(x, bit).map(|half| self.m.held(half));
        let mut crossed = [self.zero(), self.zero()];
        let mut open = [true, true];
        // A half that is entered before it is closed is closed once instead of twice.
        let mut at = usize::from(crosses[0].is_empty());
        while open[at] || closed[at].borrowed() != crossed[at].borrowed() {
            let to = 1 - at;
            if std::mem::take(&mut open[at]) {
                closed[at] = self.close(false, closed[at].borrowed(), b[at], stays[at])?;
            }
            if !crosses[at].is_empty() {
                let new = self.minus(closed[at].borrowed(), crossed[at].borrowed())?;
                let entered = self.step(new.borrowed(), b[to], crosses[at])?;
                let union = self.or(closed[to].borrowed(), entered.borrowed())?;
                open[to] |= union.borrowed() != closed[to].borrowed();
                closed[to] = union;
            }
            crossed[at] = self.m.held(closed[at].borrowed());
            at = to;
        }
        let [clear, set] = closed;
        self.node_among(2 * bit, set, clear, [(whole, (b[1], b[0]))])
    }
}
