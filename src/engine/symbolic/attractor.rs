//! Removal of the attractor of losing states, in one recursion over all sets and relations: choices
//! that may step into a lost state are withdrawn, states left without a choice are lost, and so on.
//!
//! At the first bit the sets split into halves. One half removes its own lost states. Then the
//! choices of the other half that may step into them are withdrawn, and states left without a choice
//! are lost there. The halves take turns until nothing changes. This finds losses of many layers,
//! such as a battery that runs down, without a pass over all sets for each layer.

use std::mem;
use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;

use oxidd::Function;

use super::diagram::Bdd;
use super::parts::{self, Budget, Known, Part};
use super::relation_lists::RelationList;
use super::store::Store;
use super::walk::{Halt, Walk};
use super::{ChoiceSet, StateSet, SymbolicEngine};
use crate::EdgeLabels;
use meliora_model::error::Result;

/// The result of a recursion.
#[derive(Clone)]
pub(super) struct Removed {
    /// All lost states.
    pub(super) lost: Bdd,
    /// For each part the states in which its choices are still allowed; no lost state is among
    /// them.
    pub(super) allowed: Arc<[Bdd]>,
}

impl<'m, 'id: 'm> Walk<'m, 'id> {
    /// Computes the lost states and the choices that remain. The lost states are the least L ⊇
    /// `new` with this property: a state allowed by some part is in L if each part that allows it
    /// has a step into L that counts.
    ///
    /// The parts must not allow any state of `new`. Parts without such a step stay as they are.
    pub(super) fn remove_attractor(
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
        self.tick()?;
        known.check()?;
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
        half.lost = self.own(|w| w.or(half.lost.as_edge(w.m), lost.as_edge(w.m)))?;
        half.parts.iter_mut().zip(allowed.iter()).for_each(|(part, left)| part.allowed = left.clone());
        Ok(())
    }

    /// Withdraws the choices of the other half that may step into lost states of half `at`. The
    /// states of the other half that this leaves without a choice are new there.
    fn withdraw(&self, arcs: &[Arc<RelationList>], halves: &mut [Half; 2], at: usize) -> Result<(), Halt> {
        let to = 1 - at;
        let more = self.own(|w| w.minus(halves[at].lost.as_edge(w.m), halves[at].crossed.as_edge(w.m)))?;
        if self.store.is_zero(&more) {
            return Ok(());
        }
        halves[at].crossed = halves[at].lost.clone();
        let mut stuck = self.store.zero();
        for (index, cofactor) in arcs.iter().enumerate().filter(|(_, cofactor)| !cofactor.is_empty()) {
            let (except, allowed) = (&halves[at].parts[index].except, &halves[to].parts[index].allowed);
            let gone = self.enter(&more, except, allowed, cofactor)?;
            if !self.store.is_zero(&gone) {
                let left = self.own(|w| w.minus(allowed.as_edge(w.m), gone.as_edge(w.m)))?;
                halves[to].parts[index].allowed = left;
                stuck = self.own(|w| w.or(stuck.as_edge(w.m), gone.as_edge(w.m)))?;
            }
        }
        for part in &halves[to].parts {
            stuck = self.own(|w| w.minus(stuck.as_edge(w.m), part.allowed.as_edge(w.m)))?;
        }
        halves[to].new = self.own(|w| w.or(halves[to].new.as_edge(w.m), stuck.as_edge(w.m)))?;
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

/// Computes [`Engine::remove_attractor`](crate::Engine::remove_attractor) with the choices
/// of each group split by edge labels. Returns `None` if the recursion is not expected to pay off
/// or gives up.
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
    let most = Budget::of(store, &game.parts)?;
    let Some(loss) = store.remove_attractor(&lost.0, &game.parts, most)? else {
        store.work.given_up.fetch_add(1, Relaxed);
        return Ok(None);
    };
    let choices = game.left(store, lost, within, &loss)?;
    Ok(Some((StateSet(loss.lost), choices)))
}

/// The choices that are left, split by edge labels.
struct Game {
    parts: Vec<Part>,
    /// The group of each part; one past the last group for the states that have won.
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
        // The self-loops of deadlocks do not leave their state.
        for (group, list) in engine.groups.iter().chain([&nothing]).enumerate() {
            let left = store.minus(&within.0[group], &lost.0)?;
            game.add(group, parts::by_exception(store, &left, &safe)?, list);
        }
        // States that have won stay, as if they had a choice without successors.
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

    /// Returns the choices of `within` that remain after a loss.
    ///
    /// The choices of states that were lost before are kept, since they cannot lead to a win. A
    /// group without losses then keeps its diagram, and cached results of it stay usable.
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
