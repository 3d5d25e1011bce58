//! What can be won almost surely, round by round without looking at everything in each.
//!
//! Every state that can still win remembers a choice by which it gets closer, to a state on a lower
//! level. When states are lost, only those are looked at again whose remembered choice was
//! disallowed: most find another one that leads lower. Those that do not are detached, whoever
//! depends on them is looked at too, and so on; of the detached, those that find no choice on any
//! level are the next to be lost. So a round costs what is around the states that it looks at,
//! where a backward search would cost all edges.

use super::graph::Predecessors;
use super::index::NOBODY;
use super::meter::Array;
use super::set::{BitSet, clear, test};
use super::{ExplicitEngine, StateSet};
use crate::engine::{EdgeLabels, Region};
use crate::error::Result;

/// What the edges of a game are worth.
pub(super) trait Rules {
    /// Whether the edge is there.
    fn keeps(&self, from: usize, to: usize) -> bool;
    /// Whether to take it wins.
    fn wins(&self, from: usize, to: usize) -> bool;
}

/// To enter a target wins.
pub(super) struct Entering<'a>(pub(super) &'a BitSet);

impl Rules for Entering<'_> {
    #[inline]
    fn keeps(&self, _: usize, _: usize) -> bool {
        true
    }

    #[inline]
    fn wins(&self, _: usize, to: usize) -> bool {
        self.0.has(to)
    }
}

/// [`EdgeLabels`], with the number of its own for each state.
pub(super) struct Table<'a> {
    entry: Array<u32>,
    edge_labels: Vec<(&'a [u64], &'a [u64])>,
}

impl<'a> Table<'a> {
    /// The rules of `edge_labels`.
    ///
    /// # Errors
    /// The memory limit would be passed.
    pub(super) fn new(engine: &ExplicitEngine, edge_labels: &'a [EdgeLabels<StateSet>]) -> Result<Self> {
        let mut entry = Array::filled(&engine.meter, engine.graph.states(), NOBODY)?;
        for (number, m) in edge_labels.iter().enumerate() {
            m.from.0.iter().for_each(|s| entry[s] = number as u32);
        }
        let edge_labels = edge_labels.iter().map(|m| (m.goal.0.words(), m.dropped.0.words())).collect();
        Ok(Table { entry, edge_labels })
    }
}

impl Rules for Table<'_> {
    #[inline]
    fn keeps(&self, from: usize, to: usize) -> bool {
        self.edge_labels.get(self.entry[from] as usize).is_none_or(|&(_, dropped)| !test(dropped, to))
    }

    #[inline]
    fn wins(&self, from: usize, to: usize) -> bool {
        self.edge_labels.get(self.entry[from] as usize).is_some_and(|&(goal, _)| test(goal, to))
    }
}

struct AlmostSureSolver<'a, R> {
    engine: &'a ExplicitEngine,
    graph: &'a Predecessors,
    rules: &'a R,
    choices: BitSet,
    /// For each state that can win a choice that gets it closer.
    by: Array<u32>,
    /// That choice wins or may step to a state on a level below this one.
    level: Array<u32>,
}

impl ExplicitEngine {
    /// νY. μX. { s ∈ S : some (s,a) ∈ C has every edge winning or into Y, and one winning or into X },
    /// of edges that are there; with the pairs of C that stay. Every pair of C has its state in S and
    /// all edges winning or into S.
    pub(super) fn pursue<R: Rules>(
        &self,
        states: &BitSet,
        choices: BitSet,
        rules: &R,
    ) -> Result<Region<BitSet, BitSet>> {
        let graph = self.graph.predecessors()?;
        let by = Array::filled(&self.meter, self.graph.states(), NOBODY)?;
        let level = Array::filled(&self.meter, self.graph.states(), 0)?;
        let mut solver = AlmostSureSolver { engine: self, graph, rules, choices, by, level };
        solver.start()?;
        let mut lost = Array::new(&self.meter);
        for state in states.iter().filter(|&s| solver.by[s] == NOBODY) {
            lost.push(state as u32)?;
        }
        while !lost.is_empty() {
            let detached = solver.remove_attractor(&lost)?;
            lost = solver.attach(detached)?;
        }
        let mut left = states.copy()?;
        for state in states.iter().filter(|&s| solver.by[s] == NOBODY) {
            clear(left.words_mut(), state);
        }
        Ok(Region { states: left, choices: solver.choices })
    }
}

impl<R: Rules> AlmostSureSolver<'_, R> {
    /// An edge that is there and does not win: what becomes of its end matters.
    #[inline]
    fn leans(&self, from: u32, to: usize) -> bool {
        let from = from as usize;
        self.rules.keeps(from, to) && !self.rules.wins(from, to)
    }

    /// Finds a choice for each state that can win.
    fn start(&mut self) -> Result<()> {
        let mut work = Array::new(&self.engine.meter);
        for choice in self.choices.iter() {
            let owner = self.graph.owner(choice as u32);
            let mut ends = self.engine.graph.successors_of(choice).iter();
            if self.by[owner as usize] == NOBODY
                && ends.any(|&to| self.rules.wins(owner as usize, to as usize))
            {
                self.by[owner as usize] = choice as u32;
                work.push(owner)?;
            }
        }
        self.spread(work)
    }

    /// From the states in `work`, which have a choice, backwards; nearer states first, so that few
    /// others depend on each.
    fn spread(&mut self, mut work: Array<u32>) -> Result<()> {
        let (graph, choices) = (self.graph, self.choices.words());
        let mut next = 0;
        while next < work.len() {
            self.engine.tick()?;
            let state = work[next] as usize;
            next += 1;
            for &choice in graph.of(state) {
                let owner = graph.owner(choice) as usize;
                if self.by[owner] == NOBODY
                    && test(choices, choice as usize)
                    && self.rules.keeps(owner, state)
                {
                    self.by[owner] = choice;
                    self.level[owner] = self.level[state].saturating_add(1);
                    work.push(owner as u32)?;
                }
            }
        }
        Ok(())
    }

    /// Takes the choices away that may step into a lost state, among them all of the lost states
    /// themselves; detaches states that then have no choice that leads lower.
    fn remove_attractor(&mut self, lost: &[u32]) -> Result<Array<u32>> {
        let graph = self.graph;
        let mut detached = Array::new(&self.engine.meter);
        for &state in lost {
            self.engine.tick()?;
            for &choice in graph.of(state as usize) {
                let owner = graph.owner(choice);
                if test(self.choices.words(), choice as usize) && self.leans(owner, state as usize) {
                    clear(self.choices.words_mut(), choice as usize);
                    self.detach(owner, choice, &mut detached)?;
                }
            }
        }
        let mut next = 0;
        while next < detached.len() {
            self.engine.tick()?;
            let state = detached[next] as usize;
            next += 1;
            for &choice in graph.of(state) {
                let owner = graph.owner(choice);
                if self.by[owner as usize] == choice && self.leans(owner, state) {
                    self.detach(owner, choice, &mut detached)?;
                }
            }
        }
        Ok(detached)
    }

    /// Lets a state do without a choice that it may have remembered.
    #[inline]
    fn detach(&mut self, state: u32, choice: u32, detached: &mut Array<u32>) -> Result<()> {
        let at = state as usize;
        if self.by[at] == choice {
            match self.way_out(at, Some(self.level[at])) {
                Some((other, _)) => self.by[at] = other,
                None => {
                    self.by[at] = NOBODY;
                    detached.push(state)?;
                }
            }
        }
        Ok(())
    }

    /// Looks for another choice for each of these states; gives those without one.
    fn attach(&mut self, detached: Array<u32>) -> Result<Array<u32>> {
        let mut work = Array::new(&self.engine.meter);
        for &state in detached.iter() {
            self.engine.tick()?;
            if let Some((choice, level)) = self.way_out(state as usize, None) {
                self.by[state as usize] = choice;
                self.level[state as usize] = level;
                work.push(state)?;
            }
        }
        self.spread(work)?;
        let mut lost = Array::new(&self.engine.meter);
        for &state in detached.iter().filter(|&&s| self.by[s as usize] == NOBODY) {
            lost.push(state)?;
        }
        Ok(lost)
    }

    /// A choice that is left and may win at once or step to a state that can win, of a level below
    /// `bound`; with the least level that it fits.
    fn way_out(&self, state: usize, bound: Option<u32>) -> Option<(u32, u32)> {
        for choice in self.engine.graph.choices_of(state) {
            if !test(self.choices.words(), choice) {
                continue;
            }
            for &to in self.engine.graph.successors_of(choice) {
                let to = to as usize;
                if self.rules.wins(state, to) {
                    return Some((choice as u32, 0));
                }
                let level = self.level[to];
                let lower = self.by[to] != NOBODY && bound.is_none_or(|b| level < b);
                if lower && self.rules.keeps(state, to) {
                    return Some((choice as u32, level.saturating_add(1)));
                }
            }
        }
        None
    }
}
