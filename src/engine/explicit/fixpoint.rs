//! Fixpoints by work lists: each fixpoint examines each edge at most once.

use std::sync::atomic::Ordering::Relaxed;

use super::ExplicitEngine;
use super::almost_sure::{Plain, Rules};
use super::frontier::Frontier;
use crate::engine::Region;
use meliora_base::error::Result;
use meliora_space::explore::PATIENCE;
use meliora_space::graph::Predecessors;
use meliora_space::meter::Array;
use meliora_space::set::{BitSet, clear, set, test};

impl ExplicitEngine {
    /// Computes μX. T ∪ { s : some (s,a) ∈ C has an edge into X that is not dropped }.
    pub(super) fn attract(&self, target: &BitSet, within: &BitSet, rules: &impl Rules) -> Result<BitSet> {
        let graph = self.graph.predecessors()?;
        let mut found = target.copy()?;
        let (x, within) = (found.words_mut(), within.words());
        let mut work = Frontier::new(&self.meter, self.graph.states())?;
        target.iter().for_each(|start| work.add(start));
        while let Some(state) = work.take() {
            self.tick()?;
            for &choice in graph.of(state) {
                let from = graph.owner(choice) as usize;
                if !test(x, from) && test(within, choice as usize) && rules.keeps(from, state) {
                    set(x, from);
                    work.add(from);
                }
            }
        }
        Ok(found)
    }

    /// Computes [`Engine::stay_within`](crate::Engine::stay_within).
    pub(super) fn remain(&self, x: &BitSet, within: &BitSet) -> Result<Region<BitSet, BitSet>> {
        let graph = self.graph.predecessors()?;
        let mut removal = Removal::new(self, graph, x.copy()?, self.choices_of_states(within, x)?)?;
        let outside = self.every_state.zip(x, |all, x| all & !x)?;
        removal.lose(&outside, &Plain)?;
        removal.remove_where(x, |left| left == 0, &Plain)?;
        // A state of the opponent is lost with its first choice, and may have others.
        let choices = match self.opponent() {
            None => removal.choices,
            Some(_) => self.choices_of_states(&removal.choices, &removal.states)?,
        };
        Ok(Region { states: removal.states, choices })
    }

    /// Computes [`Engine::remove_attractor`](crate::Engine::remove_attractor).
    pub(super) fn without_attractor(
        &self,
        left: Region<BitSet, BitSet>,
        won: &BitSet,
        lost: &BitSet,
        rules: &impl Rules,
    ) -> Result<Region<BitSet, BitSet>> {
        let graph = self.graph.predecessors()?;
        let mut removal = Removal::new(self, graph, left.states, left.choices)?;
        // They keep their number of choices, whatever is removed.
        won.iter().for_each(|state| removal.left[state] = u32::MAX);
        removal.lose(lost, rules)?;
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
        // A step of diagrams takes as long as about eight steps over lists.
        self.settings.sink.advance(PATIENCE as u64 / 8);
        match self.settings.sink.stop() {
            Some(limit) => Err(limit.into()),
            None => Ok(()),
        }
    }
}

/// The remaining states and choices while states are removed one after the other.
pub(super) struct Removal<'a> {
    engine: &'a ExplicitEngine,
    graph: &'a Predecessors,
    pub(super) states: BitSet,
    pub(super) choices: BitSet,
    /// For each state, the number of its choices that have to be removed before it is lost.
    left: Array<u32>,
    /// Removed states whose predecessors are not examined yet.
    work: Frontier,
}

impl<'a> Removal<'a> {
    pub(super) fn new(
        engine: &'a ExplicitEngine,
        graph: &'a Predecessors,
        states: BitSet,
        choices: BitSet,
    ) -> Result<Self> {
        let left = engine.removable(&choices)?;
        let work = Frontier::new(&engine.meter, engine.graph.states())?;
        Ok(Removal { engine, graph, states, choices, left, work })
    }

    /// Removes the attractor of some states, which were removed before.
    pub(super) fn lose(&mut self, lost: &BitSet, rules: &impl Rules) -> Result<()> {
        lost.iter().for_each(|state| self.work.add(state));
        self.spread(rules)
    }

    /// Removes the states of X for which `is_lost` is true of the number of choices that they can lose.
    pub(super) fn remove_where(
        &mut self,
        x: &BitSet,
        is_lost: impl Fn(u32) -> bool,
        rules: &impl Rules,
    ) -> Result<()> {
        let states = self.states.words_mut();
        for state in x.iter().filter(|&state| is_lost(self.left[state])) {
            if test(states, state) {
                clear(states, state);
                self.work.add(state);
            }
        }
        self.spread(rules)
    }

    /// Removes the choices that may step into the states in `work` by a plain edge; removes states that are lost
    /// then, and so on.
    fn spread(&mut self, rules: &impl Rules) -> Result<()> {
        let (states, choices) = (self.states.words_mut(), self.choices.words_mut());
        while let Some(state) = self.work.take() {
            self.engine.tick()?;
            for &choice in self.graph.of(state) {
                let from = self.graph.owner(choice) as usize;
                let is_plain = || rules.keeps(from, state) && !rules.wins(from, state);
                if !test(choices, choice as usize) || !is_plain() {
                    continue;
                }
                clear(choices, choice as usize);
                self.left[from] = self.left[from].saturating_sub(1);
                if self.left[from] == 0 && test(states, from) {
                    clear(states, from);
                    self.work.add(from);
                }
            }
        }
        Ok(())
    }
}
