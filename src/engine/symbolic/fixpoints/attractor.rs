//! Removal of the attractor of losing states, in one recursion over all sets and relations: choices
//! that may step into a lost state are withdrawn, states left without a choice are lost, and so on.
//!
//! At the first bit the sets split into halves. One half removes its own lost states. Then the
//! choices of the other half that may step into them are withdrawn, and states left without a choice
//! are lost there. The halves take turns until nothing changes. This finds losses of many layers,
//! such as a battery that runs down, without a pass over all sets for each layer.

use std::mem;
use std::sync::Arc;

use super::parts::{self, Known, Part};
use crate::symbolic::relations::lists::RelationList;
use crate::symbolic::store::Store;
use crate::symbolic::store::diagram::Bdd;
use crate::symbolic::store::walk::{Halt, Walk};

/// The result of a recursion.
#[derive(Clone)]
pub(in crate::symbolic) struct Removed {
    /// All lost states.
    pub(in crate::symbolic) lost: Bdd,
    /// For each part the states in which its choices are still allowed; no lost state is among
    /// them.
    pub(in crate::symbolic) allowed: Arc<[Bdd]>,
}

impl<'m, 'id: 'm> Walk<'m, 'id> {
    /// Computes the lost states and the choices that remain. The lost states are the least L ⊇
    /// `new` with this property: a state allowed by some part is in L if each part that allows it
    /// has a step into L that counts.
    ///
    /// The parts must not allow any state of `new`. Parts without such a step stay as they are.
    pub(in crate::symbolic) fn remove_attractor(
        &self,
        new: &Bdd,
        parts: &[Part],
        known: &mut Known<Removed>,
    ) -> Result<Removed, Halt> {
        let same = || parts.iter().map(|p| p.allowed.clone()).collect();
        if self.store.is_zero(new) || !parts.iter().any(|p| p.changes_state(self.store)) {
            return Ok(Removed { lost: new.clone(), allowed: same() });
        }
        let key = (new.clone(), parts::operands(parts));
        if let Some(found) = known.get(&key) {
            return Ok(found);
        }
        self.tick_for(parts)?;
        let found = self.remove_across(self.first_bit(new, parts), new, parts, known)?;
        known.insert(key, found.clone());
        Ok(found)
    }

    /// Computes [`Walk::remove_attractor`] by splitting on a bit.
    fn remove_across(
        &self,
        bit: u32,
        new: &Bdd,
        parts: &[Part],
        known: &mut Known<Removed>,
    ) -> Result<Removed, Halt> {
        let half = |value| {
            let (parts, new) = (self.half(bit, value, parts)?, self.side(new, bit, value));
            Ok::<_, Halt>(Half { parts, new, lost: self.store.zero(), crossed: self.store.zero() })
        };
        let mut halves = [half(false)?, half(true)?];
        let arcs = [self.arcs(bit, parts, true, false)?, self.arcs(bit, parts, false, true)?];
        // The half to which the other one cannot add losses comes first: each is then searched once.
        let mut at = usize::from(arcs[0].iter().all(|cofactor| cofactor.is_empty()));
        while halves.iter().any(|half| half.is_open(self.store)) {
            self.remove_in(&mut halves[at], known)?;
            self.withdraw(&arcs[at], &mut halves, at)?;
            at = 1 - at;
        }
        let [clear, set] = &halves;
        let both = set.parts.iter().zip(&clear.parts);
        let allowed = both.map(|(set, clear)| self.joined(bit, &set.allowed, &clear.allowed));
        Ok(Removed {
            allowed: allowed.collect::<Result<_, Halt>>()?,
            lost: self.joined(bit, &set.lost, &clear.lost)?,
        })
    }

    /// Adds to the lost states of a half those that are lost because of its new ones.
    fn remove_in(&self, half: &mut Half, known: &mut Known<Removed>) -> Result<(), Halt> {
        if self.store.is_zero(&half.new) {
            return Ok(());
        }
        let new = mem::replace(&mut half.new, self.store.zero());
        let Removed { lost, allowed } = self.remove_attractor(&new, &half.parts, known)?;
        half.lost = self.both(Walk::or, &half.lost, &lost)?;
        half.parts.iter_mut().zip(allowed.iter()).for_each(|(part, left)| part.allowed = left.clone());
        Ok(())
    }

    /// Withdraws the choices of the other half that may step into lost states of half `at`. The
    /// states of the other half that this leaves without a choice are new there.
    fn withdraw(&self, arcs: &[Arc<RelationList>], halves: &mut [Half; 2], at: usize) -> Result<(), Halt> {
        let to = 1 - at;
        let more = self.both(Walk::minus, &halves[at].lost, &halves[at].crossed)?;
        if self.store.is_zero(&more) {
            return Ok(());
        }
        halves[at].crossed = halves[at].lost.clone();
        let mut stuck = self.store.zero();
        for (index, cofactor) in arcs.iter().enumerate().filter(|(_, cofactor)| !cofactor.is_empty()) {
            let (except, allowed) = (&halves[at].parts[index].except, &halves[to].parts[index].allowed);
            let into = self.both(Walk::minus, &more, except)?;
            let left = self.own(|w| w.spare(w.edge(&into), w.edge(allowed), cofactor))?;
            if left != *allowed {
                let gone = self.both(Walk::minus, allowed, &left)?;
                halves[to].parts[index].allowed = left;
                stuck = self.both(Walk::or, &stuck, &gone)?;
            }
        }
        for part in &halves[to].parts {
            stuck = self.both(Walk::minus, &stuck, &part.allowed)?;
        }
        halves[to].new = self.both(Walk::or, &halves[to].new, &stuck)?;
        Ok(())
    }
}

/// One half of the sets.
struct Half {
    parts: Vec<Part>,
    /// The lost states whose attractor is not yet removed in this half.
    new: Bdd,
    /// The other lost states.
    lost: Bdd,
    /// The lost states from which the other half has already been entered.
    crossed: Bdd,
}

impl Half {
    fn is_open(&self, store: &Store) -> bool {
        !store.is_zero(&self.new) || self.lost != self.crossed
    }
}
