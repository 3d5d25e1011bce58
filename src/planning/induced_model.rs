//! Induced models: the states, with their memory, that runs under a strategy may visit.

use std::collections::VecDeque;

use ahash::AHashMap;
use serde::Serialize;
use strum::{EnumMessage, EnumString, IntoStaticStr, VariantArray};

use super::explain::{Action, Explanation};
use super::finite_memory::{FiniteMemoryStrategy, Memory};
use meliora_engine::Engine;
use meliora_model::State;
use meliora_model::error::Result;

/// The strategy that runs follow.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    Hash,
    Serialize,
    EnumMessage,
    EnumString,
    IntoStaticStr,
    VariantArray,
    schemars::JsonSchema,
)]
#[strum(serialize_all = "lowercase")]
#[serde(rename_all = "lowercase")]
pub enum Scheduler {
    /// The first permitted action that comes closer to an improvement.
    Progress,
    /// All permitted actions, each with the same probability.
    Permissive,
}

impl Scheduler {
    /// Both values.
    pub const ALL: &[Scheduler] = Scheduler::VARIANTS;

    /// Returns the name in reports and options.
    pub fn name(self) -> &'static str {
        self.into()
    }

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
        let mut unfolded = InducedModel { nodes: Vec::new(), complete: true };
        let mut index: AHashMap<(State, Memory), usize> = AHashMap::new();
        let mut queue = VecDeque::new();
        for start in starts {
            let found = enter(&mut index, &mut queue, limit, (start.clone(), strategy.start(start)?));
            unfolded.complete &= found.is_some();
        }
        while let Some((state, memory)) = queue.pop_front() {
            let at = strategy.explain(&state, memory)?;
            let mut next = Vec::with_capacity(at.actions.len());
            for (position, action) in at.actions.iter().enumerate() {
                let taken = scheduler.takes(&at, position);
                let mut follow = |key: (State, Memory)| {
                    let found = enter(&mut index, &mut queue, limit, key);
                    unfolded.complete &= found.is_some();
                    found
                };
                let to = action.successors.iter();
                next.push(to.map(|s| taken.then(|| follow((s.state.clone(), s.next))).flatten()).collect());
            }
            unfolded.nodes.push(Node { at, next });
        }
        Ok(unfolded)
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

/// Returns the number of a node and queues the node if it is new; `None` beyond the limit.
fn enter(
    index: &mut AHashMap<(State, Memory), usize>,
    queue: &mut VecDeque<(State, Memory)>,
    limit: usize,
    key: (State, Memory),
) -> Option<usize> {
    if let Some(&found) = index.get(&key) {
        return Some(found);
    }
    let number = index.len();
    if number >= limit {
        return None;
    }
    queue.push_back(key.clone());
    index.insert(key, number);
    Some(number)
}
