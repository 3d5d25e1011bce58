//! The search for lost states where all edges are plain, over sets of states alone.
//!
//! A choice is allowed as long as it has no step into a lost state, so the lost states say which choices
//! are left. The recursion over the lists of all groups and layers take turns on budgets. The recursion is
//! up to nine times faster than layers, or half as fast; the relations tell which of them comes first.

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
    pub(super) engine: &'e SymbolicEngine,
    /// The steps of each group; those of the opponent are one list.
    pub(super) lists: &'e ListTuple,
    /// The states that are lost or outside.
    pub(super) lost: Bdd,
    /// The other states that may be lost.
    pub(super) candidates: Bdd,
}

/// How a search ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum By {
    /// By the recursion over lists.
    Lists,
    /// By layers.
    Layers,
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
        if let (None, Some(reaching)) = (opponent, engine.recall(lost)) {
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

    /// Finds the lost states, from those lost first.
    ///
    /// Layers do not continue from what an unfinished recursion has found: it has parts of many layers,
    /// which made each later layer several times slower.
    pub(super) fn run(mut self, first: &StateSet) -> Result<(StateSet, By)> {
        let (store, work) = (&self.engine.store, &self.engine.store.work.steps);
        let mut layers = Layers::new(&first.0, &self.lost, &self.candidates, self.lists);
        let mut steps = store.thresholds().lose_steps.max(1);
        let mut for_layers = if self.engine.shares_few_bits() { steps.saturating_mul(4) } else { 0 };
        loop {
            let until = work.load(Relaxed).saturating_add(for_layers);
            while work.load(Relaxed) < until {
                if !layers.next(store, self.engine.clusters.list(), self.lists)? {
                    return Ok((StateSet(layers.lost), By::Layers));
                }
            }
            self.add(&layers.lost)?;
            if self.recurse(steps)? {
                return Ok((StateSet(self.lost), By::Lists));
            }
            for_layers = steps.saturating_mul(4);
            steps = steps.saturating_mul(16);
        }
    }

    fn add(&mut self, lost: &Bdd) -> Result<()> {
        let store = &self.engine.store;
        self.lost = store.or(&self.lost, lost)?;
        self.candidates = store.minus(&self.candidates, &self.lost)?;
        Ok(())
    }

    /// Continues with the recursion for a number of steps. Returns whether it is finished.
    ///
    /// It is given up earlier if the sets on the way are much larger than the candidates: then layers,
    /// which do not have them, are faster.
    fn recurse(&mut self, steps: u64) -> Result<bool> {
        let (store, thresholds) = (&self.engine.store, self.engine.store.thresholds());
        let trial = thresholds.lose_trial_steps.min(steps);
        let most = store.size(&self.candidates)?.saturating_mul(thresholds.lose_growth);
        for steps in [trial, steps - trial] {
            let (found, done) = store.lose(&self.lost, &self.candidates, self.lists, steps)?;
            if done {
                self.lost = found;
                return Ok(true);
            }
            self.add(&found)?;
            if store.has_nodes(&self.lost, most)? {
                break;
            }
        }
        Ok(false)
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

    /// Returns true if layers are expected to be faster than the recursion: if most groups write the same
    /// few bits. The recursion then exchanges losses between the values of these bits many times, and a
    /// layer of all values has few nodes.
    fn shares_few_bits(&self) -> bool {
        let mut writers = vec![0; self.encoding.width()];
        for list in &self.groups {
            let bits: BTreeSet<u32> = list.entries().iter().flat_map(|e| e.support.bits()).copied().collect();
            bits.into_iter().for_each(|bit| writers[bit as usize] += 1);
        }
        let thresholds = self.store.thresholds();
        let many = |writers: &&usize| **writers * 100 >= self.groups.len() * thresholds.shared_by_percent;
        let shared = writers.iter().filter(many).count();
        shared > 0 && shared * 100 <= writers.len() * thresholds.most_shared_percent
    }
}
