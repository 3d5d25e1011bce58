//! Induced models: the states, with their memory, that runs under a strategy may visit.

use std::collections::VecDeque;

use ahash::AHashMap;

use crate::strategies::explain::{Action, Explanation};
use crate::strategies::finite_memory::{FiniteMemoryStrategy, Memory};
use meliora_base::error::Result;
use meliora_engine::Engine;
use meliora_model::State;

meliora_base::named! {
    /// The strategy that runs follow.
    pub enum Scheduler {
        /// The first permitted action that comes closer to an improvement.
        Progress,
        /// All permitted actions, each with the same probability.
        Permissive,
    }
}

impl Scheduler {
    /// Returns whether runs may take the action at this position: one that this scheduler may take, or any
    /// action of the opponent until the strategy ends.
    pub(crate) fn takes(self, at: &Explanation, action: usize) -> bool {
        match self {
            _ if at.is_theirs() => !at.is_over() && action < at.actions.len(),
            Scheduler::Permissive => {
                !at.is_achieved() && at.actions.get(action).is_some_and(|a: &Action| a.permitted)
            }
            Scheduler::Progress => at.pick == Some(action),
        }
    }
}

/// A node of an induced model: a state with the strategy's memory.
#[derive(Debug, Clone, PartialEq)]
pub struct Node {
    /// The explanation of the state and its actions.
    pub at: Explanation,
    /// For each action and each of its successors, the node it leads to; `None` for actions that
    /// the scheduler does not take, and for nodes beyond the limit.
    pub next: Vec<Vec<Option<usize>>>,
}

/// The states with memory that are reachable under a strategy.
#[derive(Debug, Clone, PartialEq)]
pub struct InducedModel {
    /// The nodes: first those in which runs start, then the others in breadth-first order.
    pub nodes: Vec<Node>,
    /// True if all reachable nodes are included, that is, if the limit was not reached.
    pub complete: bool,
}

impl InducedModel {
    /// Unfolds a strategy from some states, up to `limit` nodes. Follows also branches that the
    /// improvement MDP drops: the real system may take them. Cost: that of
    /// [`FiniteMemoryStrategy::explain`] per node.
    ///
    /// # Errors
    /// The errors of [`FiniteMemoryStrategy::explain`].
    pub fn unfold<E: Engine>(
        strategy: &mut FiniteMemoryStrategy<E>,
        starts: &[State],
        scheduler: Scheduler,
        limit: usize,
    ) -> Result<Self> {
        let mut unfolding = Unfolding::new(strategy, starts, scheduler, limit)?;
        let mut nodes = Vec::new();
        while let Some(node) = unfolding.next_node()? {
            nodes.push(node);
        }
        Ok(InducedModel { nodes, complete: unfolding.complete })
    }

    /// Returns the maximum number of steps of a run; `None` if it is unbounded or unknown.
    pub fn longest_path(&self) -> Option<usize> {
        let edges = |node: &Node| node.next.iter().flatten().flatten().copied().collect::<Vec<_>>();
        let mut entering = vec![0usize; self.nodes.len()];
        self.nodes.iter().flat_map(edges).for_each(|to| entering[to] += 1);
        let mut ready: Vec<usize> = (0..self.nodes.len()).filter(|&n| entering[n] == 0).collect();
        let mut depth = vec![0usize; self.nodes.len()];
        let mut sorted = 0;
        while let Some(node) = ready.pop() {
            sorted += 1;
            for to in edges(&self.nodes[node]) {
                depth[to] = depth[to].max(depth[node] + 1);
                entering[to] -= 1;
                if entering[to] == 0 {
                    ready.push(to);
                }
            }
        }
        // Nodes on a cycle never become ready.
        let bounded = self.complete && sorted == self.nodes.len();
        bounded.then(|| depth.into_iter().max().unwrap_or(0))
    }
}

/// The nodes of an induced model one after the other, of which only states and memories are kept.
pub struct Unfolding<'s, E: Engine> {
    strategy: &'s mut FiniteMemoryStrategy<E>,
    scheduler: Scheduler,
    limit: usize,
    index: AHashMap<(State, Memory), usize>,
    queue: VecDeque<(State, Memory)>,
    /// True if all reachable nodes are included so far, that is, if the limit was not reached.
    pub complete: bool,
}

impl<'s, E: Engine> Unfolding<'s, E> {
    /// Begins as [`InducedModel::unfold`] does. The strategy remembers the standing of states meanwhile.
    /// Cost: no image.
    ///
    /// # Errors
    /// The errors of [`FiniteMemoryStrategy::start`].
    pub fn new(
        strategy: &'s mut FiniteMemoryStrategy<E>,
        starts: &[State],
        scheduler: Scheduler,
        limit: usize,
    ) -> Result<Self> {
        strategy.remember(true);
        let (index, queue) = (AHashMap::new(), VecDeque::new());
        let mut unfolding = Unfolding { strategy, scheduler, limit, index, queue, complete: true };
        for start in starts {
            let memory = unfolding.strategy.start(start)?;
            unfolding.enter((start.clone(), memory));
        }
        Ok(unfolding)
    }

    /// Returns the next node, in the order of their numbers; `None` after the last one.
    ///
    /// # Errors
    /// The errors of [`FiniteMemoryStrategy::explain`].
    pub fn next_node(&mut self) -> Result<Option<Node>> {
        let Some((state, memory)) = self.queue.pop_front() else { return Ok(None) };
        let at = self.strategy.explain(&state, memory)?;
        let mut next = Vec::with_capacity(at.actions.len());
        for (position, action) in at.actions.iter().enumerate() {
            let taken = self.scheduler.takes(&at, position);
            let to = action.successors.iter();
            next.push(to.map(|s| taken.then(|| self.enter((s.state.clone(), s.next))).flatten()).collect());
        }
        Ok(Some(Node { at, next }))
    }

    /// Returns the number of a node and queues the node if it is new; `None` beyond the limit.
    fn enter(&mut self, key: (State, Memory)) -> Option<usize> {
        if let Some(&found) = self.index.get(&key) {
            return Some(found);
        }
        let number = self.index.len();
        if number >= self.limit {
            self.complete = false;
            return None;
        }
        self.queue.push_back(key.clone());
        self.index.insert(key, number);
        Some(number)
    }
}

impl<E: Engine> Drop for Unfolding<'_, E> {
    fn drop(&mut self) {
        self.strategy.remember(false);
    }
}
