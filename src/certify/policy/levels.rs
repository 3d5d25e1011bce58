//! Checks of the improvements that nodes promise.
//!
//! Let k > 0 improvements be ahead of a node. A step *leads on* if it is an improvement into a node with at least k - 1
//! ahead; it *stays* if the next node has at least k ahead. From each such node, steps that stay must lead to one that
//! leads on, whatever the opponent chooses. So the improvements are possible, by induction over k. If no other steps are
//! left, they are almost sure: each path stays where it leads on with a probability that is bounded from below.

use super::graph::some_in;
use super::nodes::{Aim, Check, Checker};

impl Checker<'_> {
    /// Checks the improvements ahead of each node.
    pub(super) fn levels(&self) -> Check {
        let nodes = 0..self.policy.nodes.len();
        let is_ahead = |node: usize| self.policy.nodes[node].ahead != Some(0);
        let leads = |from: usize, to: usize| self.improves(from, to) && self.has_ahead(to, from, 1);
        let stays = |from: usize, to: usize| self.has_ahead(to, from, 0);
        for from in nodes.clone().filter(|&node| is_ahead(node)) {
            let mut lost = self.graph.successors(from).filter(|&to| !leads(from, to) && !stays(from, to));
            let is_sure = self.policy.promise.aim == Aim::Spi || lost.next().is_none();
            self.ensure(from, is_sure, "after a step, fewer improvements are sure than the node promises")?;
        }
        let none = vec![false; nodes.len()];
        let able = self.graph.least(none, |from, able| {
            self.graph.can_choose(from, |next| {
                let mut next = next.iter();
                next.any(|&to| leads(from, to) || stays(from, to) && some_in(able, &[to]))
            })
        })?;
        for node in nodes {
            let is_able = able[node] || !is_ahead(node);
            self.ensure(
                node,
                is_able,
                "steps of the policy cannot make the improvements that the node promises",
            )?;
        }
        Ok(())
    }

    /// Returns whether a node promises at least as many improvements as another one, or `less`.
    fn has_ahead(&self, node: usize, other: usize, less: usize) -> bool {
        match (self.policy.nodes[node].ahead, self.policy.nodes[other].ahead) {
            (None, _) => true,
            (Some(_), None) => false,
            (Some(own), Some(wanted)) => own.saturating_add(less) >= wanted,
        }
    }
}
