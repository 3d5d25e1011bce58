//! What can come of a play under a strategy: the states it may visit, with what it remembers there.

use std::collections::VecDeque;

use ahash::AHashMap;
use serde::Serialize;

use super::explain::{Action, Explanation};
use super::finite_memory::{FiniteMemoryStrategy, Memory};
use crate::engine::Engine;
use crate::error::Result;
use crate::model::State;

/// Which of the two strategies is played.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Scheduler {
    /// Every permitted action, each as likely as the others.
    Permissive,
    /// The first action that makes progress.
    Progress,
}

impl Scheduler {
    /// The name in reports and options.
    pub fn name(self) -> &'static str {
        match self {
            Scheduler::Permissive => "permissive",
            Scheduler::Progress => "progress",
        }
    }

    /// The strategy of a name.
    pub fn named(name: &str) -> Option<Scheduler> {
        [Scheduler::Permissive, Scheduler::Progress].into_iter().find(|scheduler| scheduler.name() == name)
    }

    /// Whether this strategy may take the action at this position.
    pub fn plays(self, at: &Explanation, action: usize) -> bool {
        match self {
            Scheduler::Permissive => at.actions.get(action).is_some_and(|a: &Action| a.permitted),
            Scheduler::Progress => at.pick == Some(action),
        }
    }
}

/// A state with what the play remembers there.
#[derive(Debug, Clone, PartialEq)]
pub struct Node {
    /// The state.
    pub at: Explanation,
    /// For each action and each of its successors the node it leads to; none for actions that the
    /// strategy does not take, and for nodes past the limit.
    pub next: Vec<Vec<Option<usize>>>,
}

/// The part reachable under a strategy.
#[derive(Debug, Clone, PartialEq)]
pub struct InducedModel {
    /// The nodes, those where plays start first, then breadth first.
    pub nodes: Vec<Node>,
    /// Whether all nodes are there: the limit was not passed.
    pub complete: bool,
}

impl InducedModel {
    /// Unfolds a strategy from some states, up to `limit` nodes. Branches that the improvement MDP
    /// drops are followed too: the real system may take them.
    ///
    /// # Errors
    /// As [`FiniteMemoryStrategy::explain`]. Cost: that for each node.
    pub fn unfold<E: Engine>(
        book: &mut FiniteMemoryStrategy<'_, E>,
        starts: &[State],
        scheduler: Scheduler,
        limit: usize,
    ) -> Result<Self> {
        let mut course = InducedModel { nodes: Vec::new(), complete: true };
        let mut index: AHashMap<(State, Memory), usize> = AHashMap::new();
        let mut queue = VecDeque::new();
        for start in starts {
            let found = enter(&mut index, &mut queue, limit, (start.clone(), book.start(start)));
            course.complete &= found.is_some();
        }
        while let Some((state, memory)) = queue.pop_front() {
            let at = book.explain(&state, memory)?;
            let mut next = Vec::with_capacity(at.actions.len());
            for (position, action) in at.actions.iter().enumerate() {
                let played = scheduler.plays(&at, position);
                let mut follow = |key: (State, Memory)| {
                    let found = enter(&mut index, &mut queue, limit, key);
                    course.complete &= found.is_some();
                    found
                };
                let to = action.successors.iter();
                next.push(to.map(|s| played.then(|| follow((s.state.clone(), s.next))).flatten()).collect());
            }
            course.nodes.push(Node { at, next });
        }
        Ok(course)
    }

    /// The most steps that a play can take; none where there is no bound, or where it is not known.
    pub fn longest_play(&self) -> Option<usize> {
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
        // Nodes on a cycle never get ready.
        let bounded = self.complete && sorted == self.nodes.len();
        bounded.then(|| depth.into_iter().max().unwrap_or(0))
    }
}

/// The number of a node, which is queued where it is new; none past the limit.
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
