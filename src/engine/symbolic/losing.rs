//! The search for lost states over sets of states alone.
//!
//! A choice is allowed as long as it has no step into a lost state, so the lost states say which choices
//! are left. Edge labels say from which states a step into which lost states does not count, and which
//! choices are missing from the start. So each set of states with the same labels has a search of its own, and
//! the searches take turns.

use std::collections::BTreeSet;
use std::sync::atomic::Ordering::Relaxed;

use super::fixpoints::layers::{self, Layers};
use super::fixpoints::parts::by_exception;
use super::quiet::Quiet;
use super::relations::tuples::{ListTuple, ListTuples};
use super::store::Store;
use super::store::diagram::Bdd;
use super::store::walk::Direction;
use super::{ChoiceSet, StateSet, SymbolicEngine};
use crate::edge_labels::EdgeLabels;
use crate::engine::Region;
use meliora_model::error::Result;

/// A search for lost states.
pub(super) struct Losing<'e> {
    engine: &'e SymbolicEngine,
    /// The steps of each group; those of the opponent are one list.
    lists: &'e ListTuple,
    /// The states that are lost or outside.
    lost: Bdd,
    /// The other states that may be lost, by their edge labels and by their steps.
    candidates: Vec<Candidates<'e>>,
    /// All candidates if all edges are plain.
    plain: Option<Bdd>,
}

/// The states with the same edge labels that may be lost.
struct Candidates<'e> {
    /// The steps of each group from these states.
    lists: &'e ListTuple,
    /// The place in the order of the monitors' values: steps lead to candidates of this place or an earlier one.
    place: usize,
    states: Bdd,
    /// The states into which their steps do not count.
    safe: Bdd,
    /// True if these states are safe themselves, so that none is lost because of another one; else none is.
    are_safe: bool,
    /// The states into which none of their choices has a step.
    barred: Bdd,
}

impl<'e> Candidates<'e> {
    /// Splits states by their edge labels.
    fn by_labels(
        store: &Store,
        lists: &'e ListTuple,
        states: Bdd,
        edge_labels: &[EdgeLabels<StateSet>],
    ) -> Result<Vec<Self>> {
        let nothing = store.zero();
        if edge_labels.is_empty() {
            let (safe, barred) = (nothing.clone(), nothing);
            return Ok(vec![Candidates { lists, place: 0, states, safe, are_safe: false, barred }]);
        }
        let mut parts = Vec::new();
        for EdgeLabels { from, goal, dropped, barred } in edge_labels {
            let safe = store.or(&goal.0, &dropped.0)?;
            let barred = Vec::from_iter(barred.iter().map(|(from, into)| (from.0.clone(), into.0.clone())));
            for (states, barred) in by_exception(store, &store.and(&states, &from.0)?, &barred)? {
                for (states, are_safe) in
                    [(store.and(&states, &safe)?, true), (store.minus(&states, &safe)?, false)]
                {
                    let (safe, barred) = (safe.clone(), barred.clone());
                    parts.push(Candidates { lists, place: 0, states, safe, are_safe, barred });
                }
            }
        }
        parts.retain(|part| !store.is_zero(&part.states));
        Ok(parts)
    }

    /// Splits the states by the values of monitors and by whether some step changes one, each part with its own
    /// steps.
    fn by_monitors(self, store: &Store, quiet: &'e Quiet) -> Result<Vec<Self>> {
        let mut parts = Vec::with_capacity(2 * quiet.order.len());
        for (place, values) in quiet.order.iter().enumerate() {
            let states = store.and(&self.states, values)?;
            let waiting = store.and(&states, &quiet.states)?;
            let moving = store.minus(&states, &quiet.states)?;
            for (states, lists) in [(moving, self.lists), (waiting, &*quiet.lists)] {
                let (safe, barred) = (self.safe.clone(), self.barred.clone());
                parts.push(Candidates { lists, place, states, safe, barred, ..self });
            }
        }
        parts.retain(|part| !store.is_zero(&part.states));
        Ok(parts)
    }

    /// Returns the states into which a choice has no step as long as it is allowed.
    fn avoided(&self, store: &Store, lost: &Bdd) -> Result<Bdd> {
        store.or(&store.minus(lost, &self.safe)?, &self.barred)
    }
}

impl<'e> Losing<'e> {
    /// Starts a search. Returns `None` if choices are missing for another reason than a step into a lost or
    /// a barred state.
    pub(super) fn new(
        engine: &'e SymbolicEngine,
        left: &Region<StateSet, ChoiceSet>,
        won: &StateSet,
        lost: &StateSet,
        edge_labels: &[EdgeLabels<StateSet>],
    ) -> Result<Option<Self>> {
        let (store, loops) = (&engine.store, &left.choices.0[engine.groups.len()]);
        let outside = store.minus(&store.any(engine.enabled.iter().cloned())?, &left.states.0)?;
        let staying = store.or(loops, &engine.without_edges(&left.choices)?)?;
        let mut candidates = store.minus(&store.minus(&left.states.0, &won.0)?, &staying)?;
        let opponent = engine.opponent();
        // In a game, more states may lose than these.
        if let (None, Some(reaching)) = (opponent, engine.reaching.recall(&lost.0)) {
            candidates = store.and(&candidates, &reaching.states.0)?;
        }
        let lists = opponent.map_or_else(|| engine.tuple(), |opponent| engine.removal_lists(opponent))?;
        let plain = edge_labels.is_empty().then(|| candidates.clone());
        let candidates = Candidates::by_labels(store, lists, candidates, edge_labels)?;
        let search = Losing { engine, lists, lost: outside, candidates, plain };
        if !search.explains(&left.choices)? {
            return Ok(None);
        }
        search.by_monitors().map(Some)
    }

    /// Splits the candidates by the values of monitors, those that no step leaves first, and by whether some step
    /// changes a monitor. Else losses of the last values came late, and the sets found before would be those of a
    /// harder question: who reaches these values without a loss?
    fn by_monitors(self) -> Result<Self> {
        let Some(quiet) = self.engine.quiet()? else { return Ok(self) };
        let mut split = Vec::new();
        for part in self.candidates {
            split.extend(part.by_monitors(&self.engine.store, quiet)?);
        }
        split.sort_by_key(|part| part.place);
        Ok(Losing { candidates: split, ..self })
    }

    /// Returns whether all choices that C lacks in the candidates have a step into a lost or a barred state.
    fn explains(&self, c: &ChoiceSet) -> Result<bool> {
        let (engine, store, opponent) = (self.engine, &self.engine.store, self.engine.opponent());
        let avoided = self.candidates.iter().map(|part| part.avoided(store, &self.lost));
        let avoided = avoided.collect::<Result<Vec<_>>>()?;
        for (group, (list, own)) in engine.groups.iter().zip(&*c.0).enumerate() {
            let is_theirs = opponent.is_some_and(|opponent| opponent.has(group));
            // The list of the opponent has no choices that are ruled out.
            let all = if is_theirs { &engine.choices.0[group] } else { &engine.enabled[group] };
            for (part, avoided) in self.candidates.iter().zip(&avoided).filter(|_| own != all) {
                let missing = store.minus(&store.and(&part.states, all)?, own)?;
                if store.step(Direction::Backward, list, avoided, &missing)? != missing {
                    return Ok(false);
                }
            }
        }
        Ok(true)
    }

    /// Finds the lost states by layers, from those lost first, if all edges are plain. Returns `None` after
    /// `steps` steps.
    pub(super) fn by_layers(&self, first: &StateSet, steps: u64) -> Result<Option<StateSet>> {
        let store = &self.engine.store;
        let Some(states) = &self.plain else { return Ok(None) };
        let until = store.work.steps.load(Relaxed).saturating_add(steps);
        let mut layers = Layers::new(&first.0, &self.lost, states, self.lists);
        while layers.next(store, self.engine.clusters.list(), self.lists)? {
            if store.work.steps.load(Relaxed) >= until {
                return Ok(None);
            }
        }
        self.since(first, &layers.lost).map(Some)
    }

    /// Returns the steps that layers may take before the recursion over lists, which may take `steps`; `None` if
    /// that comes first. Layers come first where they are expected to be faster: where they suit the relations,
    /// or where backward reachability of the same states was found by layers.
    pub(super) fn steps_of_layers(&self, first: &StateSet, steps: u64) -> Result<Option<u64>> {
        if self.engine.suits_layers()? {
            return Ok(Some(steps.saturating_mul(4)));
        }
        let by_layers = self.engine.reaching.recall(&first.0).is_some_and(|reaching| reaching.by_layers);
        Ok(by_layers.then_some(steps))
    }

    /// Finds the lost states by the recursion over the lists of all groups. Returns also whether these
    /// are all; after `steps` steps they are those found so far.
    pub(super) fn by_lists(&self, first: &StateSet, steps: u64) -> Result<(StateSet, bool)> {
        let (store, work) = (&self.engine.store, &self.engine.store.work);
        let mut nodes = 0;
        for part in &self.candidates {
            nodes += store.size(&part.states)? as u64;
        }
        let steps = steps.max(store.thresholds().lose_steps_per_node.saturating_mul(nodes));
        let until = work.steps.load(Relaxed).saturating_add(steps);
        let (mut lost, mut open) = (self.lost.clone(), vec![true; self.candidates.len()]);
        while let Some(at) = open.iter().position(|&is_open| is_open) {
            open[at] = false;
            let left = until.saturating_sub(work.steps.load(Relaxed));
            let (new, done) = self.lost_among(&self.candidates[at], &lost, left)?;
            lost = store.or(&lost, &new)?;
            if !done {
                return Ok((self.since(first, &lost)?, false));
            }
            let place = self.candidates[at].place;
            let others = self.candidates.iter().enumerate();
            for (other, part) in others.filter(|(other, part)| *other != at && part.place >= place) {
                open[other] |= !store.is_zero(&store.minus(&new, &part.safe)?);
            }
        }
        Ok((self.since(first, &lost)?, true))
    }

    /// Finds the candidates with the same labels that are lost because of `lost` and of each other. Returns also
    /// whether these are all.
    ///
    /// The recursion is given up earlier if the sets on the way are much larger than the candidates: then
    /// layers, which do not have them, are faster.
    fn lost_among(&self, part: &Candidates, lost: &Bdd, steps: u64) -> Result<(Bdd, bool)> {
        let (store, thresholds) = (&self.engine.store, self.engine.store.thresholds());
        let (avoided, open) = (part.avoided(store, lost)?, store.minus(&part.states, lost)?);
        if part.are_safe {
            return Ok((layers::stuck(store, &avoided, open, part.lists)?, true));
        }
        let trial = thresholds.lose_trial_steps.min(steps);
        let (mut found, mut done) = store.lose(&avoided, &open, part.lists, trial)?;
        if !done && trial < steps {
            let many = store.size(&open)?.saturating_mul(thresholds.lose_growth);
            if !store.has_nodes(&found, many)? {
                let rest = store.minus(&open, &found)?;
                (found, done) = store.lose(&found, &rest, part.lists, steps - trial)?;
            }
        }
        Ok((store.and(&open, &found)?, done))
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
    /// groups write the same few bits of variables that move back and forth, and the states have few nodes. The
    /// recursion then exchanges losses between the values of these bits many times. The answer depends on the
    /// relations and the states alone, so it is computed once.
    pub(super) fn suits_layers(&self) -> Result<bool> {
        if let Some(&suits) = self.suits_layers.get() {
            return Ok(suits);
        }
        let suits = self.shares_few_bits()?;
        Ok(*self.suits_layers.get_or_init(|| suits))
    }

    /// Returns whether most groups write the same few bits, these move back and forth, and the states have few
    /// nodes.
    fn shares_few_bits(&self) -> Result<bool> {
        let (thresholds, width) = (self.store.thresholds(), self.encoding.width());
        if self.store.has_nodes(&self.states.0, width.saturating_mul(thresholds.nodes_per_bit))? {
            return Ok(false);
        }
        let mut writers = vec![0; width];
        for list in &self.groups {
            let bits: BTreeSet<u32> = list.entries().flat_map(|e| e.support.bits()).copied().collect();
            bits.into_iter().for_each(|bit| writers[bit as usize] += 1);
        }
        let many =
            |bit: &u32| writers[*bit as usize] * 100 >= self.groups.len() * thresholds.shared_by_percent;
        let mut shared = 0;
        for variable in self.program.variable_ids() {
            let bits = self.encoding.positions(variable).iter().filter(|bit| many(bit)).count();
            if bits > 0 && self.moves_back_and_forth(variable)? {
                shared += bits;
            }
        }
        Ok(shared > 0 && shared * 100 <= width * thresholds.most_shared_percent)
    }
}
