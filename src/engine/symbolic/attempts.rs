//! The methods that the engine tries for a fixpoint, in which order, and how much each may take.

use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;

use super::encoding::transitions::Piece;
use super::fixpoints::attractor::Removed;
use super::fixpoints::parts::{self, Part};
use super::losing::Losing;
use super::relations::combinations::stay_few;
use super::relations::lists::RelationList;
use super::relations::partial_relation::PartialRelation;
use super::store::diagram::Bdd;
use super::store::walk::Pass;
use super::{ChoiceSet, StateSet, SymbolicEngine};
use crate::edge_labels::{EdgeLabels, remove_layer};
use crate::engine::{Algebra, Region};
use meliora_base::error::Result;

impl SymbolicEngine {
    /// Computes [`Engine::remove_attractor`]. With a set of states, the choices that may step into it
    /// have still to be removed from the result.
    ///
    /// Two methods take turns: the recursion over parts, where it is likely to pay off, and the recursion over the
    /// lists of all groups, which continues from the states that it has found. Where sets of states do not say which
    /// choices are left, layers of states and choices take the place of the latter.
    pub(super) fn lose_states(
        &self,
        left: Region<StateSet, ChoiceSet>,
        within: &ChoiceSet,
        won: &StateSet,
        edge_labels: &[EdgeLabels<StateSet>],
        lost: StateSet,
    ) -> Result<(Region<StateSet, ChoiceSet>, Option<StateSet>)> {
        if self.store.is_zero(&lost.0) {
            return Ok((left, None));
        }
        let parts = match self.has_few_parts()? {
            true => Some(Game::new(self, &lost, won, &left.choices, edge_labels)?),
            false => None,
        };
        let (mut search, mut found, mut layer) = (None, lost.clone(), lost.clone());
        let mut rest = left.clone();
        let ways = usize::from(parts.is_none())..2;
        let (mut left, lost) = self.store.in_turns(&self.store.leaders.lost, ways, |turn| {
            if let Some(parts) = parts.as_ref().filter(|_| turn.way == 0) {
                let left = parts.lose(self, &lost, &left, turn.steps)?;
                return Ok(left.map(|left| (left, None)));
            }
            if search.is_none() {
                search = Some(Losing::new(self, &left, won, edge_labels)?);
            }
            let Some(Some(search)) = &search else {
                let done = self.lose_layers(&mut rest, &mut layer, within, won, edge_labels, turn.steps)?;
                return Ok(done.then(|| (rest.clone(), None)));
            };
            let (all, done) = search.by_lists(&found, turn.steps)?;
            found = all;
            Ok(done.then(|| (left.clone(), Some(found.clone()))))
        })?;
        if let Some(lost) = &lost {
            left.states = self.difference(&left.states, lost)?;
        }
        Ok((left, lost))
    }

    /// Removes layers of lost states, from the last one on, until no state is lost or for some steps. Returns whether
    /// all are removed.
    fn lose_layers(
        &self,
        left: &mut Region<StateSet, ChoiceSet>,
        lost: &mut StateSet,
        within: &ChoiceSet,
        won: &StateSet,
        edge_labels: &[EdgeLabels<StateSet>],
        steps: u64,
    ) -> Result<bool> {
        let work = &self.store.work;
        let until = work.steps.load(Relaxed).saturating_add(steps);
        while !self.store.is_zero(&lost.0) {
            if work.steps.load(Relaxed) >= until {
                return Ok(false);
            }
            let is_simpler = |x: &StateSet, y: &StateSet| self.store.is_smaller(&x.0, &y.0);
            *lost = remove_layer(self, left, within, won, edge_labels, lost, is_simpler)?;
        }
        work.lost[0].fetch_add(1, Relaxed);
        Ok(true)
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
        let most = self.store.thresholds().relations_per_bit * self.encoding.width();
        let few = stay_few(&self.store, &self.groups, most)?;
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

/// Returns the states that can reach a target by allowed choices and edges that are not dropped. `allowed` has a bound
/// for each group.
///
/// A recursion over parts takes turns with a fixpoint of the restricted relations, where it is likely to pay off.
pub(super) fn can_reach(
    engine: &SymbolicEngine,
    target: &Bdd,
    allowed: &[Bdd],
    dropped: &[(Bdd, Bdd)],
) -> Result<Bdd> {
    let (store, pass) = (&engine.store, Pass::backward("backward reachability"));
    let confined = || confined(engine, &engine.confinement(allowed), dropped);
    if !engine.has_few_parts()? {
        return store.reach(pass, confined()?.as_ref(), target, &engine.states.0);
    }
    let mut parts = Vec::new();
    for (list, allowed) in engine.groups.iter().zip(allowed) {
        for (allowed, except) in parts::by_exception(store, allowed, dropped)? {
            parts.push(Part { allowed, except, list: list.clone() });
        }
    }
    let mut list = None;
    store.in_turns(&store.leaders.confined, 0..2, |turn| {
        if turn.way == 0 {
            let found = store.reach_by(target, &parts, turn.steps)?;
            store.work.confined.fetch_add(u64::from(found.is_some()), Relaxed);
            return Ok(found);
        }
        let list = match &list {
            Some(list) => list,
            None => list.insert(confined()?),
        };
        store.reach_as_before(pass, turn.steps, list, target, &engine.states.0)
    })
}

/// Returns the relations with the steps of each group restricted to its allowed states (`None` allows all) and without
/// the dropped edges.
fn confined(
    engine: &SymbolicEngine,
    allowed: &[Option<Bdd>],
    dropped: &[(Bdd, Bdd)],
) -> Result<Arc<RelationList>> {
    let store = &engine.store;
    let mut entries = Vec::with_capacity(engine.transitions.pieces.len());
    for Piece { group, steps } in &engine.transitions.pieces {
        let PartialRelation { support, relation } = steps;
        let mut left = match &allowed[*group] {
            None => relation.clone(),
            Some(states) => store.and(relation, states)?,
        };
        for (from, to) in dropped {
            let sources = store.and(&left, from)?;
            if !store.is_zero(&sources) {
                left = store.minus(&left, &store.and(&sources, &store.primed(support, to)?)?)?;
            }
        }
        entries.push(PartialRelation { relation: left, support: support.clone() });
    }
    engine.lists.of(store, entries)
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

    /// Returns the states and choices that remain after those of `lost` and all that are lost with them; `None` if that
    /// takes more than `steps` steps.
    fn lose(
        &self,
        engine: &SymbolicEngine,
        lost: &StateSet,
        left: &Region<StateSet, ChoiceSet>,
        steps: u64,
    ) -> Result<Option<Region<StateSet, ChoiceSet>>> {
        let Some(loss) = engine.store.remove_attractor(&lost.0, &self.parts, steps)? else { return Ok(None) };
        engine.store.work.lost[2].fetch_add(1, Relaxed);
        let choices = self.left(engine, lost, &left.choices, &loss)?;
        let states = engine.difference(&left.states, &StateSet(loss.lost))?;
        Ok(Some(Region { states, choices }))
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
