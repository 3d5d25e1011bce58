//! The methods that the engine tries for a fixpoint, in which order, and how much each may take.

use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;

use super::encoding::Encoding;
use super::fixpoints::attractor::Removed;
use super::fixpoints::parts::{self, Budget, Part};
use super::losing::Losing;
use super::relations::lists::{RelationList, stay_few};
use super::store::Store;
use super::store::diagram::Bdd;
use super::{ChoiceSet, StateSet, SymbolicEngine};
use crate::edge_labels::{EdgeLabels, remove_layer};
use crate::engine::{Algebra, Region};
use meliora_model::error::Result;

impl SymbolicEngine {
    /// Computes [`Engine::remove_attractor`]. With a set of states, the choices that may step into it
    /// have still to be removed from the result.
    ///
    /// The recursion over parts comes first, where it is expected to pay off; then layers of states, where
    /// they are. If these give up, the recursion over the lists of all groups and layers of states and
    /// choices take turns; each continues from its own states, the recursion also from the layers.
    pub(super) fn lose_states(
        &self,
        mut left: Region<StateSet, ChoiceSet>,
        within: &ChoiceSet,
        won: &StateSet,
        edge_labels: &[EdgeLabels<StateSet>],
        mut lost: StateSet,
    ) -> Result<(Region<StateSet, ChoiceSet>, Option<StateSet>)> {
        if self.store.is_zero(&lost.0) {
            return Ok((left, None));
        }
        let work = &self.store.work;
        if let Some((lost, choices)) = remove_attractor(self, &lost, won, &left.choices, edge_labels)? {
            work.lost[1].fetch_add(1, Relaxed);
            return Ok((Region { states: self.difference(&left.states, &lost)?, choices }, None));
        }
        let mut steps = self.store.thresholds().lose_steps.max(1);
        // Layers do not continue from what an unfinished recursion has found: it has parts of many layers,
        // which made each later layer several times slower.
        let mut found = lost.clone();
        let mut search = self.search(&left, won, &found, edge_labels)?;
        if let Some(search) = &search
            && edge_labels.is_empty()
            && let Some(steps) = search.steps_of_layers(&lost, steps)?
            && let Some(all) = search.by_layers(&lost, steps)?
        {
            left.states = self.difference(&left.states, &all)?;
            work.lost_by_state_layers.fetch_add(1, Relaxed);
            return Ok((left, Some(all)));
        }
        loop {
            if let Some(search) = &search {
                let (all, done) = search.by_lists(&found, steps)?;
                if done {
                    left.states = self.difference(&left.states, &all)?;
                    work.lost_by_lists.fetch_add(1, Relaxed);
                    return Ok((left, Some(all)));
                }
                found = all;
            }
            let until = work.steps.load(Relaxed).saturating_add(steps.saturating_mul(4));
            while !self.store.is_zero(&lost.0) && work.steps.load(Relaxed) < until {
                let is_simpler = |x: &StateSet, y: &StateSet| self.store.is_smaller(&x.0, &y.0);
                lost = remove_layer(self, &mut left, within, won, edge_labels, &lost, is_simpler)?;
            }
            if self.store.is_zero(&lost.0) {
                break;
            }
            found = self.union(&found, &lost)?;
            let rest =
                Region { states: self.difference(&left.states, &found)?, choices: left.choices.clone() };
            search = self.search(&rest, won, &found, edge_labels)?;
            steps = steps.saturating_mul(16);
        }
        work.lost[0].fetch_add(1, Relaxed);
        Ok((left, None))
    }

    /// Starts a search over sets of states alone. Returns `None` if the sets do not say which choices are left.
    /// With edge labels, it is not used where layers suit, nor in games.
    fn search(
        &self,
        left: &Region<StateSet, ChoiceSet>,
        won: &StateSet,
        lost: &StateSet,
        edge_labels: &[EdgeLabels<StateSet>],
    ) -> Result<Option<Losing<'_>>> {
        if !edge_labels.is_empty() && (self.opponent().is_some() || self.suits_layers()?) {
            return Ok(None);
        }
        Losing::new(self, left, won, lost, edge_labels)
    }

    /// Returns true if a recursion over parts is expected to pay off.
    ///
    /// It does not if the steps that keep the first bits leave many different relations behind, as
    /// in products of modules: there are too many cases to distinguish. The answer depends on the
    /// relations alone, so it is computed once.
    pub(super) fn has_few_parts(&self) -> Result<bool> {
        if let Some(&few) = self.few_parts.get() {
            return Ok(few);
        }
        let few = has_few_parts(&self.store, &self.encoding, &self.groups)?;
        Ok(*self.few_parts.get_or_init(|| few))
    }

    /// Returns the states X of which `choices` has all enabled choices, if it has no others.
    pub(super) fn states_of_all_choices(&self, choices: &[Bdd]) -> Result<Option<Bdd>> {
        let states = self.store.any(choices.iter().cloned())?;
        for (own, enabled) in choices.iter().zip(&*self.enabled) {
            if *own != self.store.and(enabled, &states)? {
                return Ok(None);
            }
        }
        Ok(Some(states))
    }
}

/// Computes [`SymbolicEngine::has_few_parts`] for the lists of all groups.
pub(super) fn has_few_parts(
    store: &Store,
    encoding: &Encoding,
    groups: &[Arc<RelationList>],
) -> Result<bool> {
    stay_few(store, groups, store.thresholds().relations_per_bit * encoding.width())
}

/// Returns the states that can reach a target by allowed choices and edges that are not dropped.
/// Returns `None` if the recursion is not expected to pay off or gives up.
///
/// `allowed` has a bound for each group.
pub(super) fn can_reach(
    engine: &SymbolicEngine,
    target: &Bdd,
    allowed: &[Bdd],
    dropped: &[(Bdd, Bdd)],
) -> Result<Option<Bdd>> {
    if !engine.has_few_parts()? {
        return Ok(None);
    }
    let mut parts = Vec::new();
    for (list, allowed) in engine.groups.iter().zip(allowed) {
        for (allowed, except) in parts::by_exception(&engine.store, allowed, dropped)? {
            parts.push(Part { allowed, except, list: list.clone() });
        }
    }
    let most = Budget::of(&engine.store, &parts)?;
    let found = engine.store.reach_by(target, &parts, most)?;
    engine.store.work.confined[usize::from(found.is_some())].fetch_add(1, Relaxed);
    Ok(found)
}

/// Computes [`Engine::remove_attractor`](crate::Engine::remove_attractor) with the choices
/// of each group split by edge labels. Returns `None` if the recursion is not expected to pay off
/// or gives up.
fn remove_attractor(
    engine: &SymbolicEngine,
    lost: &StateSet,
    won: &StateSet,
    within: &ChoiceSet,
    edge_labels: &[EdgeLabels<StateSet>],
) -> Result<Option<(StateSet, ChoiceSet)>> {
    let store = &engine.store;
    if !engine.has_few_parts()? {
        return Ok(None);
    }
    let game = Game::new(engine, lost, won, within, edge_labels)?;
    let most = Budget::of(store, &game.parts)?;
    let Some(loss) = store.remove_attractor(&lost.0, &game.parts, most)? else {
        store.work.given_up.fetch_add(1, Relaxed);
        return Ok(None);
    };
    let choices = game.left(engine, lost, within, &loss)?;
    Ok(Some((StateSet(loss.lost), choices)))
}

/// The choices that are left, split by edge labels.
struct Game {
    parts: Vec<Part>,
    /// The group of each part; one past the last group for the states that have won, and two past it
    /// for all choices of the opponent.
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
        let nothing = engine.lists.of(store, Vec::new())?;
        let safe = edge_labels
            .iter()
            .map(|labels| Ok((labels.from.0.clone(), store.or(&labels.goal.0, &labels.dropped.0)?)));
        let safe = safe.collect::<Result<Vec<_>>>()?;
        let mut game = Game { parts: Vec::new(), groups: Vec::new() };
        // The self-loops of deadlocks do not leave their state.
        let opponent = engine.opponent();
        let mut theirs = store.zero();
        for (group, list) in engine.groups.iter().chain([&nothing]).enumerate() {
            if opponent.is_some_and(|opponent| opponent.has(group)) {
                theirs = store.or(&theirs, &within.0[group])?;
                continue;
            }
            let left = store.minus(&within.0[group], &lost.0)?;
            game.add(group, parts::by_exception(store, &left, &safe)?, list);
        }
        // States that have won stay, as if they had a choice without successors.
        let won = store.minus(&won.0, &lost.0)?;
        game.add(within.0.len(), parts::by_exception(store, &won, &[])?, &nothing);
        if let Some(opponent) = opponent {
            let left = store.minus(&theirs, &lost.0)?;
            let list = engine.their_list(opponent)?;
            game.add(within.0.len() + 1, parts::by_exception(store, &left, &safe)?, &list);
        }
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
    ///
    /// The opponent's states lose all choices with the first one.
    fn left(
        &self,
        engine: &SymbolicEngine,
        lost: &StateSet,
        within: &ChoiceSet,
        loss: &Removed,
    ) -> Result<ChoiceSet> {
        let (store, all_theirs) = (&engine.store, within.0.len() + 1);
        let mut choices = Vec::with_capacity(within.0.len());
        for (group, before) in within.0.iter().enumerate() {
            let is_theirs = engine.opponent().is_some_and(|opponent| opponent.has(group));
            let own = |index: &usize| self.groups[*index] == if is_theirs { all_theirs } else { group };
            let parts = Vec::from_iter((0..self.parts.len()).filter(own));
            let same = parts.iter().all(|&p| self.parts[p].allowed == loss.allowed[p]);
            choices.push(if same {
                before.clone()
            } else {
                let left = store.any(parts.into_iter().map(|p| loss.allowed[p].clone()))?;
                let left = if is_theirs { store.and(before, &left)? } else { left };
                store.or(&left, &store.and(before, &lost.0)?)?
            });
        }
        Ok(ChoiceSet(Arc::new(choices)))
    }
}
