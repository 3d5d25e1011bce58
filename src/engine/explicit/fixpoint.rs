//! Fixpoints by work lists: each fixpoint examines each edge at most once.

use std::sync::atomic::Ordering::Relaxed;

use super::ExplicitEngine;
use super::almost_sure::Rules;
use super::graph::Predecessors;
use super::meter::Array;
use super::set::{BitSet, clear, set, test};
use crate::engine::Region;
use meliora_model::error::Result;

/// Number of states taken from a work list between two checks of the progress sink.
const PATIENCE: usize = 1 << 14;

impl ExplicitEngine {
    /// Computes μX. T ∪ { s : some (s,a) ∈ C has an edge into X that is not dropped }.
    pub(super) fn attract(&self, target: &BitSet, within: &BitSet, rules: &impl Rules) -> Result<BitSet> {
        let graph = self.graph.predecessors()?;
        let mut found = target.copy()?;
        let (x, within) = (found.words_mut(), within.words());
        let mut work = Array::new(&self.meter);
        // New states are expanded before the next target state is added, so that the list contains
        // few target states.
        for start in target.iter() {
            work.push(start as u32)?;
            while let Some(state) = work.pop() {
                self.tick()?;
                for &choice in graph.of(state as usize) {
                    let from = graph.owner(choice) as usize;
                    if !test(x, from) && test(within, choice as usize) && rules.keeps(from, state as usize) {
                        set(x, from);
                        work.push(from as u32)?;
                    }
                }
            }
        }
        Ok(found)
    }

    /// Computes the greatest Z ⊆ X in which every state has a pair of C with all successors in Z,
    /// together with these pairs.
    pub(super) fn remain(&self, x: &BitSet, within: &BitSet) -> Result<Region<BitSet, BitSet>> {
        let graph = self.graph.predecessors()?;
        let mut removal = Removal::new(self, graph, x.copy()?, self.choices_of_states(within, x)?)?;
        let outside = self.every_state.zip(x, |all, x| all & !x)?;
        for state in outside.iter() {
            removal.remove_attractor(state)?;
        }
        for state in x.iter() {
            if test(removal.states.words(), state) && removal.left[state] == 0 {
                clear(removal.states.words_mut(), state);
                removal.remove_attractor(state)?;
            }
        }
        Ok(Region { states: removal.states, choices: removal.choices })
    }

    /// Counts a step and checks the progress sink every [`PATIENCE`] steps.
    #[inline]
    pub(super) fn tick(&self) -> Result<()> {
        let ticks = self.ticks.load(Relaxed).wrapping_add(1);
        self.ticks.store(ticks, Relaxed);
        if ticks.is_multiple_of(PATIENCE) { self.poll() } else { Ok(()) }
    }

    #[cold]
    fn poll(&self) -> Result<()> {
        self.settings.sink.progress("fixpoints", &|| format!("{} steps", self.ticks.load(Relaxed)));
        match self.settings.sink.stop() {
            Some(limit) => Err(limit.into()),
            None => Ok(()),
        }
    }
}

/// The remaining states and choices while states are removed one after the other.
struct Removal<'a> {
    engine: &'a ExplicitEngine,
    graph: &'a Predecessors,
    states: BitSet,
    choices: BitSet,
    /// For each state, the number of its remaining choices.
    left: Array<u32>,
    work: Array<u32>,
}

impl<'a> Removal<'a> {
    fn new(
        engine: &'a ExplicitEngine,
        graph: &'a Predecessors,
        states: BitSet,
        choices: BitSet,
    ) -> Result<Self> {
        let mut left = Array::filled(&engine.meter, engine.graph.states(), 0u32)?;
        for choice in choices.iter() {
            left[graph.owner(choice as u32) as usize] += 1;
        }
        Ok(Removal { engine, graph, states, choices, left, work: Array::new(&engine.meter) })
    }

    /// Removes the choices that may step into `state`, which is already removed; removes states
    /// without a remaining choice, and so on.
    fn remove_attractor(&mut self, state: usize) -> Result<()> {
        let (states, choices) = (self.states.words_mut(), self.choices.words_mut());
        self.work.push(state as u32)?;
        while let Some(state) = self.work.pop() {
            self.engine.tick()?;
            for &choice in self.graph.of(state as usize) {
                if !test(choices, choice as usize) {
                    continue;
                }
                clear(choices, choice as usize);
                let from = self.graph.owner(choice) as usize;
                self.left[from] -= 1;
                if self.left[from] == 0 && test(states, from) {
                    clear(states, from);
                    self.work.push(from as u32)?;
                }
            }
        }
        Ok(())
    }
}
