//! The almost-sure solver: a nested fixpoint that does not examine all states in every round.
//!
//! Every state that can still win stores a choice that leads to a state on a lower level, closer to
//! the goal. When states are lost, the solver examines only the states whose stored choice was
//! removed. Most of them have another choice that leads lower. States without any choice are lost at
//! once. The others are detached, and the states that depend on them are examined too, and so on.
//! Detached states that find no choice on any level are lost in the next round. The cost of a round
//! depends on the neighbourhood of the examined states; a backward search would examine all edges.

use super::frontier::Frontier;
use super::{ExplicitEngine, StateSet};
use crate::edge_labels::EdgeLabels;
use crate::engine::Region;
use meliora_base::error::Result;
use meliora_space::graph::Predecessors;
use meliora_space::index::NOBODY;
use meliora_space::meter::Array;
use meliora_space::set::{BitSet, clear, set, test};

/// The edge labels of a game, by source and target state.
pub(super) trait Rules {
    /// Returns whether the edge is not dropped.
    fn keeps(&self, from: usize, to: usize) -> bool;
    /// Returns whether the edge is a goal edge.
    fn wins(&self, from: usize, to: usize) -> bool;
}

/// The rules of reachability: edges into the target are goal edges, no edge is dropped.
pub(super) struct Entering<'a>(pub(super) &'a [u64]);

impl Rules for Entering<'_> {
    #[inline]
    fn keeps(&self, _: usize, _: usize) -> bool {
        true
    }

    #[inline]
    fn wins(&self, _: usize, to: usize) -> bool {
        test(self.0, to)
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
    edge_labels: Vec<[&'a [u64]; 2]>,
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
        let words = |x: &'a StateSet| engine.bits(x).map(BitSet::words);
        let pairs = edge_labels.iter().map(|labels| Ok([words(&labels.goal)?, words(&labels.dropped)?]));
        Ok(Table { entry, edge_labels: pairs.collect::<Result<_>>()? })
    }

    /// Adds the targets of goal edges to a set.
    pub(super) fn add_goal(&self, to: &mut BitSet) {
        for [goal, _] in &self.edge_labels {
            to.words_mut().iter_mut().zip(*goal).for_each(|(x, y)| *x |= y);
        }
    }
}

impl Rules for Table<'_> {
    #[inline]
    fn keeps(&self, from: usize, to: usize) -> bool {
        self.edge_labels.get(self.entry[from] as usize).is_none_or(|[_, dropped]| !test(dropped, to))
    }

    #[inline]
    fn wins(&self, from: usize, to: usize) -> bool {
        self.edge_labels.get(self.entry[from] as usize).is_some_and(|[goal, _]| test(goal, to))
    }
}

/// The level of a lost state.
const LOST: u32 = u32::MAX;
/// The level of a state without a stored choice that may find one, above all levels of other states.
const DETACHED: u32 = u32::MAX - 1;

struct AlmostSureSolver<'a, R> {
    engine: &'a ExplicitEngine,
    graph: &'a Predecessors,
    rules: &'a R,
    choices: &'a mut [u64],
    /// A choice that leads closer to the goal for each state that can still win: one bit per choice.
    stored: Array<u64>,
    /// States that have a choice and whose predecessors are not examined yet.
    work: Frontier,
    /// The level of each state: its stored choice has a goal edge, or an edge into a state on a
    /// lower level. [`DETACHED`] or [`LOST`] without a stored choice.
    level: Array<u32>,
}

impl ExplicitEngine {
    /// Computes νY. μX. { s ∈ S : some (s,a) ∈ C has only goal edges and edges into Y, and one goal
    /// edge or edge into X }, ignoring dropped edges, together with the pairs of C that stay. Every
    /// pair of C must have its state in S, and each of its edges must be a goal edge or lead into
    /// S, or into states that are `lost`. Without an opponent, also returns the states that the first search finds.
    pub(super) fn pursue<R: Rules>(
        &self,
        states: &BitSet,
        mut choices: BitSet,
        (rules, goal): (&R, &BitSet),
        lost: &BitSet,
    ) -> Result<(Region<BitSet, BitSet>, Option<BitSet>)> {
        if self.opponent().is_some() {
            return Ok((self.pursue_in_game(states, choices, rules, lost)?, None));
        }
        let mut solver = self.solver(rules, choices.words_mut())?;
        solver.lose(lost)?;
        solver.search(states, goal)?;
        let possible = solver.found();
        solver.remove(states, goal)?;
        let mut left = states.copy()?;
        let words = left.words_mut();
        states.iter().filter(|&s| solver.level[s] == LOST).for_each(|state| clear(words, state));
        Ok((Region { states: left, choices }, Some(possible)))
    }

    fn solver<'a, R>(&'a self, rules: &'a R, choices: &'a mut [u64]) -> Result<AlmostSureSolver<'a, R>> {
        Ok(AlmostSureSolver {
            engine: self,
            graph: self.graph.predecessors()?,
            rules,
            choices,
            stored: Array::filled(&self.meter, self.graph.choices().div_ceil(64), 0)?,
            level: Array::filled(&self.meter, self.graph.states(), DETACHED)?,
            work: Frontier::new(&self.meter, self.graph.states())?,
        })
    }
}

impl<R: Rules> AlmostSureSolver<'_, R> {
    /// Returns whether the edge is plain: only then does it matter whether `to` can win.
    #[inline]
    fn is_plain(&self, from: usize, to: usize) -> bool {
        self.rules.keeps(from, to) && !self.rules.wins(from, to)
    }

    /// Removes some states and their attractor, before any state has a choice.
    fn lose(&mut self, lost: &BitSet) -> Result<()> {
        for state in lost.iter() {
            self.level[state] = LOST;
            self.work.add(state);
        }
        self.remove_attractor(&mut Array::new(&self.engine.meter))
    }

    /// Finds a choice for each state that can win.
    fn start(&mut self, goal: &BitSet) -> Result<()> {
        let (graph, choices, stored) = (self.graph, &*self.choices, &mut self.stored);
        for state in goal.iter() {
            self.engine.tick()?;
            for &choice in graph.of(state) {
                if !test(choices, choice as usize) {
                    continue;
                }
                let owner = graph.owner(choice) as usize;
                if self.level[owner] == DETACHED && self.rules.wins(owner, state) {
                    set(stored, choice as usize);
                    self.level[owner] = 0;
                    self.work.add(owner);
                }
            }
        }
        self.spread()
    }

    /// Searches backwards from the states in `work`, which have a choice.
    fn spread(&mut self) -> Result<()> {
        let (graph, choices, stored) = (self.graph, &*self.choices, &mut self.stored);
        while let Some(state) = self.work.take() {
            self.engine.tick()?;
            let level = above(self.level[state]);
            for &choice in graph.of(state) {
                let owner = graph.owner(choice) as usize;
                let is_open = self.level[owner] == DETACHED && test(choices, choice as usize);
                if is_open && self.rules.keeps(owner, state) {
                    set(stored, choice as usize);
                    self.level[owner] = level;
                    self.work.add(owner);
                }
            }
        }
        Ok(())
    }

    /// Removes lost states and their attractor until all other states of S can win.
    fn remove(&mut self, states: &BitSet, goal: &BitSet) -> Result<()> {
        let mut affected = Array::new(&self.engine.meter);
        // A search takes less time than to detach more states one by one: it visits only those that reach the goal.
        let most = states.count() as usize / 4;
        loop {
            self.remove_attractor(&mut affected)?;
            let mut detached = self.descend_all(affected)?;
            if detached.is_empty() {
                return Ok(());
            }
            self.detach_dependents(&mut detached, most)?;
            if detached.len() > most {
                self.detach_all(states);
                self.search(states, goal)?;
            } else {
                self.attach(&detached)?;
            }
            detached.truncate(0);
            affected = detached;
        }
    }

    /// Detaches all states of S that are not lost.
    fn detach_all(&mut self, states: &BitSet) {
        self.stored.fill(0);
        for state in states.iter() {
            self.level[state] = self.level[state].max(DETACHED);
        }
    }

    /// Finds a choice for each detached state of S that can win by the remaining choices; the others are lost.
    fn search(&mut self, states: &BitSet, goal: &BitSet) -> Result<()> {
        self.start(goal)?;
        states.iter().for_each(|state| self.lose_if_detached(state));
        Ok(())
    }

    /// Returns the states that have a choice.
    fn found(&self) -> BitSet {
        let mut found = BitSet::empty(&self.engine.meter, self.level.len());
        for (word, levels) in found.words_mut().iter_mut().zip(self.level.chunks(64)) {
            *word = levels.iter().rev().fold(0, |word, &level| word << 1 | u64::from(level < DETACHED));
        }
        found
    }

    /// Removes the choices that may step into a lost state by a plain edge, including those of the
    /// lost states; states without a choice are lost then, too. Adds the states of which the stored choice was removed
    /// to the affected ones.
    fn remove_attractor(&mut self, affected: &mut Array<u32>) -> Result<()> {
        let graph = self.graph;
        while let Some(state) = self.work.take() {
            self.engine.tick()?;
            for &choice in graph.of(state) {
                if !test(self.choices, choice as usize) {
                    continue;
                }
                let owner = graph.owner(choice) as usize;
                if self.is_plain(owner, state) {
                    self.drop_choice(choice as usize, owner, affected)?;
                    self.lose_if_stuck(owner);
                }
            }
        }
        Ok(())
    }

    /// Detaches the states whose stored choice may step into a detached state by a plain edge, if no other choice
    /// leads to a lower level, and so on until more than `most` states are detached.
    fn detach_dependents(&mut self, detached: &mut Array<u32>, most: usize) -> Result<()> {
        let graph = self.graph;
        let mut next = 0;
        while next < detached.len() && detached.len() <= most {
            self.engine.tick()?;
            let state = detached[next] as usize;
            next += 1;
            for &choice in graph.of(state) {
                if !test(&self.stored, choice as usize) {
                    continue;
                }
                let owner = graph.owner(choice) as usize;
                if self.is_plain(owner, state) {
                    clear(&mut self.stored, choice as usize);
                    if !self.descend(owner) {
                        detached.push(owner as u32)?;
                    }
                }
            }
        }
        Ok(())
    }

    /// Removes a choice of a state. Adds the state to the affected ones if the choice was stored.
    #[inline]
    fn drop_choice(&mut self, choice: usize, state: usize, affected: &mut Array<u32>) -> Result<()> {
        clear(self.choices, choice);
        if test(&self.stored, choice) {
            clear(&mut self.stored, choice);
            affected.push(state as u32)?;
        }
        Ok(())
    }

    /// Marks a state without a choice as lost.
    #[inline]
    fn lose_if_stuck(&mut self, state: usize) {
        let is_open = self.level[state] != LOST;
        if is_open && !self.engine.graph.choices_of(state).any(|choice| test(self.choices, choice)) {
            self.level[state] = LOST;
            self.work.add(state);
        }
    }

    /// Marks a state as lost if it is detached.
    #[inline]
    fn lose_if_detached(&mut self, state: usize) {
        if self.level[state] == DETACHED {
            self.level[state] = LOST;
            self.work.add(state);
        }
    }

    /// Stores another choice of each state that is not lost, and returns the states that are detached by this.
    fn descend_all(&mut self, mut states: Array<u32>) -> Result<Array<u32>> {
        let mut kept = 0;
        for at in 0..states.len() {
            let state = states[at];
            self.engine.tick()?;
            if self.level[state as usize] != LOST && !self.descend(state as usize) {
                states[kept] = state;
                kept += 1;
            }
        }
        states.truncate(kept);
        Ok(states)
    }

    /// Stores another choice of a state that leads lower; detaches the state if there is none.
    #[inline]
    fn descend(&mut self, state: usize) -> bool {
        let way = self.way_out(state, self.level[state]);
        match way {
            Some((other, _)) => set(&mut self.stored, other as usize),
            None => self.level[state] = DETACHED,
        }
        way.is_some()
    }

    /// Searches another choice for each detached state; states without one are lost.
    fn attach(&mut self, detached: &[u32]) -> Result<()> {
        for &state in detached {
            self.engine.tick()?;
            if let Some((choice, level)) = self.way_out(state as usize, DETACHED) {
                set(&mut self.stored, choice as usize);
                self.level[state as usize] = level;
                self.work.add(state as usize);
            }
        }
        self.spread()?;
        detached.iter().for_each(|&state| self.lose_if_detached(state as usize));
        Ok(())
    }

    /// Finds a remaining choice that has a goal edge, or an edge to a state below the level `bound`.
    /// Returns the choice and the level of `state` for it: 0, or the successor's plus 1.
    fn way_out(&self, state: usize, bound: u32) -> Option<(u32, u32)> {
        for choice in self.engine.graph.choices_of(state) {
            if !test(self.choices, choice) {
                continue;
            }
            for &to in self.engine.graph.successors_of(choice) {
                let to = to as usize;
                if self.rules.wins(state, to) {
                    return Some((choice as u32, 0));
                }
                if self.level[to] < bound && self.rules.keeps(state, to) {
                    return Some((choice as u32, above(self.level[to])));
                }
            }
        }
        None
    }
}

/// Returns the next level; the highest levels have one number.
#[inline]
fn above(level: u32) -> u32 {
    (level + 1).min(DETACHED - 1)
}
