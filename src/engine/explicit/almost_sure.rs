//! The almost-sure solver: a nested fixpoint that does not examine all states in every round.
//!
//! Every state that can still win stores a choice that leads to a state on a lower level, closer to
//! the goal. When states are lost, the solver examines only the states whose stored choice was
//! removed. Most of them have another choice that leads lower. The others are detached, and the
//! states that depend on them are examined too, and so on. Detached states that find no choice on
//! any level are lost in the next round. The cost of a round depends on the neighbourhood of the
//! examined states; a backward search would examine all edges.

use super::frontier::Frontier;
use super::{ExplicitEngine, StateSet};
use crate::edge_labels::EdgeLabels;
use crate::engine::Region;
use meliora_base::error::Result;
use meliora_space::graph::Predecessors;
use meliora_space::index::NOBODY;
use meliora_space::meter::Array;
use meliora_space::set::{BitSet, clear, test};

/// The edge labels of a game, by source and target state.
pub(super) trait Rules {
    /// Returns whether the edge is not dropped.
    fn keeps(&self, from: usize, to: usize) -> bool;
    /// Returns whether the edge is a goal edge.
    fn wins(&self, from: usize, to: usize) -> bool;
}

/// The rules of reachability: edges into the target are goal edges, no edge is dropped.
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

/// The rules of staying: all edges are plain.
pub(super) struct Plain;

impl Rules for Plain {
    #[inline]
    fn keeps(&self, _: usize, _: usize) -> bool {
        true
    }

    #[inline]
    fn wins(&self, _: usize, _: usize) -> bool {
        false
    }
}

/// Rules given by [`EdgeLabels`], with the position of the entry for each state.
pub(super) struct Table<'a> {
    entry: Array<u32>,
    /// The goal and the dropped states.
    edge_labels: Vec<[&'a BitSet; 2]>,
}

impl<'a> Table<'a> {
    /// Creates the rules of `edge_labels`.
    ///
    /// # Errors
    /// The memory limit is reached, or a set belongs to another engine.
    pub(super) fn new(engine: &ExplicitEngine, edge_labels: &'a [EdgeLabels<StateSet>]) -> Result<Self> {
        let mut entry = Array::filled(&engine.meter, engine.graph.states(), NOBODY)?;
        for (number, labels) in edge_labels.iter().enumerate() {
            engine.bits(&labels.from)?.iter().for_each(|s| entry[s] = number as u32);
        }
        let pairs = edge_labels.iter();
        let pairs = pairs.map(|labels| Ok([engine.bits(&labels.goal)?, engine.bits(&labels.dropped)?]));
        Ok(Table { entry, edge_labels: pairs.collect::<Result<_>>()? })
    }

    /// Returns the targets of goal edges.
    ///
    /// # Errors
    /// The memory limit is reached.
    pub(super) fn goal(&self, nothing: BitSet) -> Result<BitSet> {
        let mut goals = self.edge_labels.iter().map(|[goal, _]| goal);
        goals.try_fold(nothing, |all, goal| all.zip(goal, |x, y| x | y))
    }
}

impl Rules for Table<'_> {
    #[inline]
    fn keeps(&self, from: usize, to: usize) -> bool {
        self.edge_labels.get(self.entry[from] as usize).is_none_or(|[_, dropped]| !dropped.has(to))
    }

    #[inline]
    fn wins(&self, from: usize, to: usize) -> bool {
        self.edge_labels.get(self.entry[from] as usize).is_some_and(|[goal, _]| goal.has(to))
    }
}

struct AlmostSureSolver<'a, R> {
    engine: &'a ExplicitEngine,
    graph: &'a Predecessors,
    rules: &'a R,
    choices: &'a mut [u64],
    /// For each state that can still win, a choice that leads closer to the goal.
    by: Array<u32>,
    /// States that have a choice and whose predecessors are not examined yet.
    work: Frontier,
    /// The level of each state: its stored choice has a goal edge, or an edge into a state on a
    /// lower level.
    level: Array<u32>,
}

impl ExplicitEngine {
    /// Computes νY. μX. { s ∈ S : some (s,a) ∈ C has only goal edges and edges into Y, and one goal
    /// edge or edge into X }, ignoring dropped edges, together with the pairs of C that stay. Every
    /// pair of C must have its state in S, and each of its edges must be a goal edge or lead into
    /// S.
    pub(super) fn pursue<R: Rules>(
        &self,
        states: &BitSet,
        mut choices: BitSet,
        (rules, goal): (&R, &BitSet),
    ) -> Result<Region<BitSet, BitSet>> {
        if self.opponent().is_some() {
            return self.pursue_in_game(states, choices, rules);
        }
        let graph = self.graph.predecessors()?;
        let by = Array::filled(&self.meter, self.graph.states(), NOBODY)?;
        let level = Array::filled(&self.meter, self.graph.states(), 0)?;
        let work = Frontier::new(&self.meter, self.graph.states())?;
        let own = choices.words_mut();
        let mut solver = AlmostSureSolver { engine: self, graph, rules, choices: own, by, level, work };
        solver.start(goal)?;
        let mut lost = Array::new(&self.meter);
        for state in states.iter().filter(|&s| solver.by[s] == NOBODY) {
            lost.push(state as u32)?;
        }
        while !lost.is_empty() {
            let detached = solver.remove_attractor(&lost)?;
            lost = solver.attach(detached)?;
        }
        let mut left = states.copy()?;
        let words = left.words_mut();
        states.iter().filter(|&s| solver.by[s] == NOBODY).for_each(|state| clear(words, state));
        Ok(Region { states: left, choices })
    }
}

impl<R: Rules> AlmostSureSolver<'_, R> {
    /// Returns whether the edge is plain: only then does it matter whether `to` can win.
    #[inline]
    fn is_plain(&self, from: u32, to: usize) -> bool {
        let from = from as usize;
        self.rules.keeps(from, to) && !self.rules.wins(from, to)
    }

    /// Finds a choice for each state that can win.
    fn start(&mut self, goal: &BitSet) -> Result<()> {
        let (graph, choices) = (self.graph, &*self.choices);
        for state in goal.iter() {
            self.engine.tick()?;
            for &choice in graph.of(state) {
                let owner = graph.owner(choice) as usize;
                if self.by[owner] == NOBODY && test(choices, choice as usize) && self.rules.wins(owner, state)
                {
                    self.by[owner] = choice;
                    self.work.add(owner);
                }
            }
        }
        self.spread()
    }

    /// Searches backwards from the states in `work`, which have a choice.
    fn spread(&mut self) -> Result<()> {
        let (graph, choices) = (self.graph, &*self.choices);
        while let Some(state) = self.work.take() {
            self.engine.tick()?;
            for &choice in graph.of(state) {
                let owner = graph.owner(choice) as usize;
                if self.by[owner] == NOBODY
                    && test(choices, choice as usize)
                    && self.rules.keeps(owner, state)
                {
                    self.by[owner] = choice;
                    self.level[owner] = self.level[state].saturating_add(1);
                    self.work.add(owner);
                }
            }
        }
        Ok(())
    }

    /// Removes the choices that may step into a lost state by a plain edge, including those of the
    /// lost states. Detaches and returns the states that then have no choice that leads to a lower
    /// level.
    fn remove_attractor(&mut self, lost: &[u32]) -> Result<Array<u32>> {
        let graph = self.graph;
        let mut detached = Array::new(&self.engine.meter);
        for &state in lost {
            self.engine.tick()?;
            for &choice in graph.of(state as usize) {
                let owner = graph.owner(choice);
                if test(self.choices, choice as usize) && self.is_plain(owner, state as usize) {
                    clear(self.choices, choice as usize);
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
                if self.by[owner as usize] == choice && self.is_plain(owner, state) {
                    self.detach(owner, choice, &mut detached)?;
                }
            }
        }
        Ok(detached)
    }

    /// Replaces a choice that a state may have stored; detaches the state if no other choice leads
    /// lower.
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

    /// Searches another choice for each detached state and returns the states without one.
    fn attach(&mut self, detached: Array<u32>) -> Result<Array<u32>> {
        for &state in detached.iter() {
            self.engine.tick()?;
            if let Some((choice, level)) = self.way_out(state as usize, None) {
                self.by[state as usize] = choice;
                self.level[state as usize] = level;
                self.work.add(state as usize);
            }
        }
        self.spread()?;
        let mut lost = Array::new(&self.engine.meter);
        for &state in detached.iter().filter(|&&s| self.by[s as usize] == NOBODY) {
            lost.push(state)?;
        }
        Ok(lost)
    }

    /// Finds a remaining choice that has a goal edge, or an edge to a state that can still win,
    /// below the level `bound` if there is one. Returns the choice and the level of `state` for it:
    /// 0, or the successor's plus 1.
    fn way_out(&self, state: usize, bound: Option<u32>) -> Option<(u32, u32)> {
        for choice in self.engine.graph.choices_of(state) {
            if !test(self.choices, choice) {
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
