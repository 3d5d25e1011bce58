//! The search for lost states over sets of states alone.
//!
//! A choice is allowed as long as it has no step into a lost state, so the lost states say which choices
//! are left. Edge labels say from which states a step into which lost states does not count, and which
//! choices are missing from the start. So each set of states with the same labels has a search of its own, and
//! the searches take turns.

use std::sync::atomic::Ordering::Relaxed;

use super::fixpoints::parts::by_exception;
use super::quiet::Quiet;
use super::relations::tuples::{ListTuple, ListTuples};
use super::store::Store;
use super::store::diagram::Bdd;
use super::store::walk::Direction;
use super::{ChoiceSet, StateSet, SymbolicEngine};
use crate::edge_labels::EdgeLabels;
use crate::engine::Region;
use meliora_base::error::Result;

/// A search for lost states.
pub(super) struct Losing<'e> {
    engine: &'e SymbolicEngine,
    /// The states that are lost or outside.
    lost: Bdd,
    /// The other states that may be lost, by their edge labels and by their steps.
    candidates: Vec<Candidates<'e>>,
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
    /// a barred state, and in a game with edge labels.
    pub(super) fn new(
        engine: &'e SymbolicEngine,
        left: &Region<StateSet, ChoiceSet>,
        won: &StateSet,
        edge_labels: &[EdgeLabels<StateSet>],
    ) -> Result<Option<Self>> {
        let opponent = engine.opponent();
        if opponent.is_some() && !edge_labels.is_empty() {
            return Ok(None);
        }
        let (store, loops) = (&engine.store, &left.choices.0[engine.groups.len()]);
        let outside = store.minus(&store.any(engine.enabled.iter().cloned())?, &left.states.0)?;
        let staying = store.or(loops, &engine.without_edges(&left.choices)?)?;
        let candidates = store.minus(&store.minus(&left.states.0, &won.0)?, &staying)?;
        let lists = opponent.map_or_else(|| engine.tuple(), |opponent| engine.removal_lists(opponent))?;
        let candidates = Candidates::by_labels(store, lists, candidates, edge_labels)?;
        let search = Losing { engine, lost: outside, candidates };
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

    /// Finds the lost states by the recursion over the lists of all groups, from those known to be lost. Returns also
    /// whether these are all; after `steps` steps they are those found so far.
    pub(super) fn by_lists(&self, first: &StateSet, steps: u64) -> Result<(StateSet, bool)> {
        let (store, work) = (&self.engine.store, &self.engine.store.work);
        let until = work.steps.load(Relaxed).saturating_add(steps);
        let (mut lost, mut open) = (store.or(&self.lost, &first.0)?, vec![true; self.candidates.len()]);
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
        work.lost[1].fetch_add(1, Relaxed);
        Ok((self.since(first, &lost)?, true))
    }

    /// Finds the candidates with the same labels that are lost because of `lost` and of each other. Returns also
    /// whether these are all.
    fn lost_among(&self, part: &Candidates, lost: &Bdd, steps: u64) -> Result<(Bdd, bool)> {
        let store = &self.engine.store;
        let (avoided, open) = (part.avoided(store, lost)?, store.minus(&part.states, lost)?);
        if part.are_safe {
            return Ok((store.stuck(&avoided, open, part.lists)?, true));
        }
        let (found, done) = store.lose(&avoided, &open, part.lists, steps)?;
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
}
