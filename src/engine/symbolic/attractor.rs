//! Removal of the attractor of losing states: states left without a choice once the choices that may step into a
//! lost state are withdrawn, and so on, in one recursion over all sets and relations.
//!
//! At the first bit the sets split into halves. Each half removes its own lost states. Then the choices of one half
//! that may step into lost states of the other half are withdrawn; states without a choice are lost in their half,
//! until nothing changes. This finds losses that take many layers, such as a battery that runs down, without a pass
//! over all sets for each layer.

use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;

use oxidd::Function;

use super::diagram::Bdd;
use super::parts::{self, Budget, Known, Part};
use super::relation_lists::RelationList;
use super::store::Store;
use super::walk::{Halt, Walk};
use super::{ChoiceSet, StateSet, SymbolicEngine};
use crate::engine::EdgeLabels;
use crate::error::Result;

/// What a recursion found.
#[derive(Clone)]
pub(super) struct Removed {
    /// All that is lost.
    pub(super) lost: Bdd,
    /// For each part where its choices are still allowed: none in what is lost.
    pub(super) allowed: Arc<[Bdd]>,
}

impl<'m, 'id: 'm> Walk<'m, 'id> {
    /// The least set L with `new` ⊆ L in which every state has no part that allows it and whose steps
    /// all avoid L or do not count.
    ///
    /// No part may allow a state of `new`; parts whose choices have no step into it change nothing.
    pub(super) fn remove_attractor(
        &self,
        new: &Bdd,
        parts: &[Part],
        known: &mut Known<Removed>,
    ) -> Result<Removed, Halt> {
        let same = || parts.iter().map(|p| p.allowed.clone()).collect();
        if self.store.is_zero(new) || !parts.iter().any(|p| p.edge_labels(self.store)) {
            return Ok(Removed { lost: new.clone(), allowed: same() });
        }
        let key = (new.clone(), parts::operands(parts));
        if let Some(found) = known.found.get(&key) {
            return Ok(found.clone());
        }
        self.tick()?;
        known.check()?;
        let found = self.remove_across(self.first_bit(new, parts), new, parts, known)?;
        known.found.insert(key, found.clone());
        Ok(found)
    }

    /// The same by halves of a bit.
    fn remove_across(
        &self,
        bit: u32,
        new: &Bdd,
        parts: &[Part],
        known: &mut Known<Removed>,
    ) -> Result<Removed, Halt> {
        let half =
            |value| Ok::<_, Halt>(Half { parts: self.half(bit, value, parts)?, lost: self.store.zero() });
        let mut halves = [half(false)?, half(true)?];
        for (half, value) in halves.iter_mut().zip([false, true]) {
            let new = self.side(new, bit, value);
            self.remove_in(half, &new, known)?;
        }
        let arcs = [self.arcs(bit, parts, true, false)?, self.arcs(bit, parts, false, true)?];
        let mut crossed = [self.store.zero(), self.store.zero()];
        // Which half was lost in last; ends when what is lost in neither has any effect on the other.
        let (mut at, mut quiet) = (0, 0);
        while quiet < 2 {
            quiet += 1;
            let new = self.own(|w| w.minus(halves[at].lost.as_edge(w.m), crossed[at].as_edge(w.m)))?;
            if !self.store.is_zero(&new) {
                crossed[at] = halves[at].lost.clone();
                let stuck = self.withdraw(&new, &arcs[at], &mut halves, at)?;
                if !self.store.is_zero(&stuck) {
                    self.remove_in(&mut halves[1 - at], &stuck, known)?;
                    quiet = 1;
                }
            }
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

    /// Adds to a half what is lost in it by `new`.
    fn remove_in(&self, half: &mut Half, new: &Bdd, known: &mut Known<Removed>) -> Result<(), Halt> {
        let Removed { lost, allowed } = self.remove_attractor(new, &half.parts, known)?;
        half.lost = self.own(|w| w.or(half.lost.as_edge(w.m), lost.as_edge(w.m)))?;
        half.parts.iter_mut().zip(allowed.iter()).for_each(|(part, left)| part.allowed = left.clone());
        Ok(())
    }

    /// Withdraws the choices that may step from the other half into what is new in the half `at`, and
    /// says which states have none left by that.
    fn withdraw(
        &self,
        new: &Bdd,
        arcs: &[Arc<RelationList>],
        halves: &mut [Half; 2],
        at: usize,
    ) -> Result<Bdd, Halt> {
        let mut hit = self.store.zero();
        for (index, cofactor) in arcs.iter().enumerate().filter(|(_, cofactor)| !cofactor.is_empty()) {
            let except = &halves[at].parts[index].except;
            let allowed = &halves[1 - at].parts[index].allowed;
            let gone = self.enter(new, except, allowed, cofactor)?;
            if !self.store.is_zero(&gone) {
                let left = self.own(|w| w.minus(allowed.as_edge(w.m), gone.as_edge(w.m)))?;
                halves[1 - at].parts[index].allowed = left;
                hit = self.own(|w| w.or(hit.as_edge(w.m), gone.as_edge(w.m)))?;
            }
        }
        for part in &halves[1 - at].parts {
            hit = self.own(|w| w.minus(hit.as_edge(w.m), part.allowed.as_edge(w.m)))?;
        }
        Ok(hit)
    }
}

/// One half of what is lost.
struct Half {
    parts: Vec<Part>,
    lost: Bdd,
}

/// [`Engine::remove_attractor`](crate::engine::Engine::remove_attractor): each group of choices by what its edges are worth.
pub(super) fn remove_attractor(
    engine: &SymbolicEngine,
    lost: &StateSet,
    won: &StateSet,
    within: &ChoiceSet,
    edge_labels: &[EdgeLabels<StateSet>],
) -> Result<Option<(StateSet, ChoiceSet)>> {
    let store = &engine.store;
    if !parts::are_few(engine)? {
        return Ok(None);
    }
    let game = Game::new(engine, lost, won, within, edge_labels)?;
    let most = Budget::of(store, &game.parts);
    let Some(loss) = store.remove_attractor(&lost.0, &game.parts, most)? else {
        store.work.given_up.fetch_add(1, Relaxed);
        return Ok(None);
    };
    let choices = game.left(store, lost, within, &loss)?;
    Ok(Some((StateSet(loss.lost), choices)))
}

/// The choices that are left, by what their edges are worth.
struct Game {
    parts: Vec<Part>,
    /// For each part its group; one past the last for the states that have won.
    groups: Vec<usize>,
}

impl Game {
    fn new(
        engine: &SymbolicEngine,
        lost: &StateSet,
        won: &StateSet,
        within: &ChoiceSet,
        edge_labels: &[EdgeLabels<StateSet>],
    ) -> Result<Self> {
        let store = &engine.store;
        let nothing = store.lists.of(store, Vec::new())?;
        let safe = edge_labels.iter().map(|m| Ok((m.from.0.clone(), store.or(&m.goal.0, &m.dropped.0)?)));
        let safe = safe.collect::<Result<Vec<_>>>()?;
        let mut game = Game { parts: Vec::new(), groups: Vec::new() };
        // The self-loops of deadlocks lead nowhere else.
        for (group, list) in engine.groups.iter().chain([&nothing]).enumerate() {
            let left = store.minus(&within.0[group], &lost.0)?;
            game.add(group, parts::by_exception(store, &left, &safe)?, list);
        }
        // What has won stays, as if it had a choice that leads nowhere.
        let won = store.minus(&won.0, &lost.0)?;
        game.add(within.0.len(), parts::by_exception(store, &won, &[])?, &nothing);
        Ok(game)
    }

    fn add(&mut self, group: usize, choices: Vec<(Bdd, Bdd)>, list: &Arc<RelationList>) {
        for (allowed, except) in choices {
            self.parts.push(Part { allowed, except, list: list.clone() });
            self.groups.push(group);
        }
    }

    /// The choices of `within` that a loss leaves. Those of what was lost before lead to nothing that
    /// can win: left alone, they keep what is remembered of their group.
    fn left(&self, store: &Store, lost: &StateSet, within: &ChoiceSet, loss: &Removed) -> Result<ChoiceSet> {
        let mut choices = Vec::with_capacity(within.0.len());
        for (group, before) in within.0.iter().enumerate() {
            let own = |index: &usize| self.groups[*index] == group;
            let parts = Vec::from_iter((0..self.parts.len()).filter(own));
            let same = parts.iter().all(|&p| self.parts[p].allowed == loss.allowed[p]);
            choices.push(if same {
                before.clone()
            } else {
                let left = store.any(parts.into_iter().map(|p| loss.allowed[p].clone()))?;
                store.or(&left, &store.and(before, &lost.0)?)?
            });
        }
        Ok(ChoiceSet(Arc::new(choices)))
    }
}
