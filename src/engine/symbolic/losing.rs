//! The search for lost states where all edges are plain, over sets of states alone.
//!
//! A choice is allowed as long as it has no step into a lost state, so the lost states say which choices
//! are left.

use std::collections::BTreeSet;
use std::sync::atomic::Ordering::Relaxed;

use super::fixpoints::layers::Layers;
use super::relations::tuples::{ListTuple, ListTuples};
use super::store::diagram::Bdd;
use super::store::walk::Direction;
use super::{ChoiceSet, StateSet, SymbolicEngine};
use crate::engine::Region;
use meliora_model::error::Result;

/// A search for lost states.
pub(super) struct Losing<'e> {
    engine: &'e SymbolicEngine,
    /// The steps of each group; those of the opponent are one list.
    lists: &'e ListTuple,
    /// The states that are lost or outside.
    lost: Bdd,
    /// The other states that may be lost.
    candidates: Bdd,
}

impl<'e> Losing<'e> {
    /// Starts a search. Returns `None` if choices are missing for another reason than a step into a lost
    /// state.
    pub(super) fn new(
        engine: &'e SymbolicEngine,
        left: &Region<StateSet, ChoiceSet>,
        won: &StateSet,
        lost: &StateSet,
    ) -> Result<Option<Self>> {
        let (store, loops) = (&engine.store, &left.choices.0[engine.groups.len()]);
        let outside = store.minus(&store.any(engine.enabled.iter().cloned())?, &left.states.0)?;
        let staying = store.or(loops, &engine.without_edges(&left.choices)?)?;
        let mut candidates = store.minus(&store.minus(&left.states.0, &won.0)?, &staying)?;
        let opponent = engine.opponent();
        // In a game, more states may lose than these.
        if let (None, Some(reaching)) = (opponent, engine.reaching.recall(&lost.0)) {
            candidates = store.and(&candidates, &reaching.0)?;
        }
        for (group, (list, own)) in engine.groups.iter().zip(&*left.choices.0).enumerate() {
            let is_theirs = opponent.is_some_and(|opponent| opponent.has(group));
            // The list of the opponent has no choices that are ruled out.
            let all = if is_theirs { &engine.choices.0[group] } else { &engine.enabled[group] };
            if own != all {
                let missing = store.minus(&store.and(&candidates, all)?, own)?;
                if store.step(Direction::Backward, list, &outside, &missing)? != missing {
                    return Ok(None);
                }
            }
        }
        let lists = opponent.map_or_else(|| engine.tuple(), |opponent| engine.removal_lists(opponent))?;
        Ok(Some(Losing { engine, lists, lost: outside, candidates }))
    }

    /// Finds the lost states by layers, from those lost first. Returns `None` after `steps` steps.
    pub(super) fn by_layers(&self, first: &StateSet, steps: u64) -> Result<Option<StateSet>> {
        let store = &self.engine.store;
        let until = store.work.steps.load(Relaxed).saturating_add(steps);
        let mut layers = Layers::new(&first.0, &self.lost, &self.candidates, self.lists);
        while layers.next(store, self.engine.clusters.list(), self.lists)? {
            if store.work.steps.load(Relaxed) >= until {
                return Ok(None);
            }
        }
        self.since(first, &layers.lost).map(Some)
    }

    /// Finds the lost states by the recursion over the lists of all groups. Returns also whether these
    /// are all; after `steps` steps they are those found so far.
    ///
    /// It is given up earlier if the sets on the way are much larger than the candidates: then layers,
    /// which do not have them, are faster.
    pub(super) fn by_lists(&self, first: &StateSet, steps: u64) -> Result<(StateSet, bool)> {
        let (store, thresholds) = (&self.engine.store, self.engine.store.thresholds());
        let of_candidates =
            thresholds.lose_steps_per_node.saturating_mul(store.size(&self.candidates)? as u64);
        let steps = steps.max(of_candidates);
        let trial = thresholds.lose_trial_steps.min(steps);
        let (mut found, mut done) = store.lose(&self.lost, &self.candidates, self.lists, trial)?;
        if !done && trial < steps {
            let many = store.size(&self.candidates)?.saturating_mul(thresholds.lose_growth);
            if !store.has_nodes(&found, many)? {
                let open = store.minus(&self.candidates, &found)?;
                (found, done) = store.lose(&found, &open, self.lists, steps - trial)?;
            }
        }
        Ok((self.since(first, &found)?, done))
    }

    /// Returns the states that are lost since the start, those lost first among them.
    fn since(&self, first: &StateSet, found: &Bdd) -> Result<StateSet> {
        let store = &self.engine.store;
        Ok(StateSet(store.or(&first.0, &store.minus(found, &self.lost)?)?))
    }
}

impl SymbolicEngine {
    /// Returns the relations of all groups as one operand.
    fn tuple(&self) -> Result<&ListTuple> {
        if let Some(found) = self.tuple.get() {
            return Ok(found);
        }
        let made = ListTuples::new(&self.store).of_lists(&self.store, &self.groups)?;
        Ok(self.tuple.get_or_init(|| made))
    }

    /// Returns true if layers of states are expected to be faster than the recursion over lists: if most
    /// groups write the same few bits, and the states have few nodes. The recursion then exchanges losses
    /// between the values of these bits many times. The answer depends on the relations and the states alone, so
    /// it is computed once.
    pub(super) fn suits_layers(&self) -> Result<bool> {
        if let Some(&suits) = self.suits_layers.get() {
            return Ok(suits);
        }
        let suits = self.shares_few_bits()?;
        Ok(*self.suits_layers.get_or_init(|| suits))
    }

    /// Returns whether most groups write the same few bits, and the states have few nodes.
    fn shares_few_bits(&self) -> Result<bool> {
        let (thresholds, width) = (self.store.thresholds(), self.encoding.width());
        if self.store.has_nodes(&self.states.0, width.saturating_mul(thresholds.nodes_per_bit))? {
            return Ok(false);
        }
        let mut writers = vec![0; width];
        for list in &self.groups {
            let bits: BTreeSet<u32> = list.entries().iter().flat_map(|e| e.support.bits()).copied().collect();
            bits.into_iter().for_each(|bit| writers[bit as usize] += 1);
        }
        let many = |writers: &&usize| **writers * 100 >= self.groups.len() * thresholds.shared_by_percent;
        let shared = writers.iter().filter(many).count();
        Ok(shared > 0 && shared * 100 <= width * thresholds.most_shared_percent)
    }
}
