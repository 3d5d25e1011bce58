//! Checks of the objectives that nodes pursue.
//!
//! A target is achieved if every path from the first nodes that pursue it can still reach it, whatever the opponent
//! chooses: then it is almost surely reached. A formula over the whole path is achieved if no path, with the choices of
//! the opponent, stays in nodes whose marks violate it: almost surely, what a path visits infinitely often is an end
//! component. Each of them is searched for a part that violates the formula.

use super::graph::Set;
use super::nodes::{Aim, Check, Checker};
use super::space::{Accepting, disjuncts, holds};
use meliora_base::error::Result;
use meliora_model::predicate::Predicate;
use meliora_model::preference::{Goal, ObjectiveSet};

impl Checker<'_> {
    /// Checks the objectives that nodes pursue.
    pub(super) fn pursuits(&self) -> Check {
        let (promise, nodes) = (&self.policy.promise, &self.policy.nodes);
        match promise.aim {
            Aim::Sasi | Aim::Spi => {
                let none = |node: usize| nodes[node].pursues.is_empty();
                (0..nodes.len())
                    .try_for_each(|node| self.ensure(node, none(node), "the policy pursues no objective"))
            }
            Aim::Achieve => {
                for (node, own) in nodes.iter().enumerate() {
                    let is_own = !promise.objectives.is_empty() && own.pursues == promise.objectives;
                    self.ensure(node, is_own, "the node does not pursue the objectives of the policy")?;
                }
                let all = vec![true; nodes.len()];
                promise.objectives.iter().try_for_each(|objective| self.achieves(objective, &all))
            }
            Aim::Plan => {
                (0..nodes.len()).try_for_each(|node| self.planned(node))?;
                let mut pursued = ObjectiveSet::new();
                nodes.iter().for_each(|node| pursued.extend_with(&node.pursues));
                pursued.iter().try_for_each(|objective| {
                    let within: Set = nodes.iter().map(|node| node.pursues.contains(objective)).collect();
                    self.achieves(objective, &within)
                })
            }
        }
    }

    /// Checks that a node of a plan pursues a most preferred objective when no improvement is ahead any more, and goes
    /// over to a preferred one only.
    fn planned(&self, node: usize) -> Check {
        let own = &self.policy.nodes[node];
        let (pursues, preferred) = (own.pursues.iter().next(), &own.most_preferred);
        self.ensure(node, own.pursues.len() < 2, "a plan pursues one objective")?;
        if own.ahead != Some(0) {
            self.ensure(node, pursues.is_none(), "improvements are ahead, and an objective is pursued")?;
            let begin = |&to: &usize| self.policy.nodes[to].ahead == Some(0);
            return self.graph.successors(node).filter(begin).try_for_each(|to| self.begins(to));
        }
        let Some(objective) = pursues else {
            return self.ensure(node, preferred.is_empty(), "the plan pursues no most preferred objective");
        };
        if node < self.policy.starts {
            self.begins(node)?;
        }
        for to in self.graph.successors(node) {
            let next = &self.policy.nodes[to];
            let goes_on = next.ahead == Some(0) && !next.pursues.is_empty();
            self.ensure(node, goes_on, "after a step, the plan pursues nothing")?;
            if next.pursues != own.pursues {
                let order = &self.preferences.order;
                let is_better = next.pursues.iter().all(|other| order.strictly(other, objective));
                self.ensure(
                    node,
                    is_better,
                    "the plan leaves its objective for one that is not preferred to it",
                )?;
                self.is_most_preferred(to)?;
            }
        }
        Ok(())
    }

    /// Checks the objective of a node where a pursuit begins: that of the policy where it is a most preferred one.
    fn begins(&self, node: usize) -> Check {
        self.is_most_preferred(node)?;
        let own = &self.policy.nodes[node];
        let mut named = self.policy.promise.objectives.iter();
        let named = named.find(|&objective| own.most_preferred.contains(objective));
        let is_named = named.is_none_or(|named| own.pursues.contains(named));
        self.ensure(node, is_named, "the plan does not pursue the objective of the policy")
    }

    fn is_most_preferred(&self, node: usize) -> Check {
        let own = &self.policy.nodes[node];
        let is_one = own.pursues.iter().all(|objective| own.most_preferred.contains(objective));
        self.ensure(node, is_one, "the objective that is pursued is not a most preferred one")
    }

    /// Checks that an objective is achieved almost surely by paths that stay within some nodes.
    fn achieves(&self, objective: usize, within: &[bool]) -> Check {
        let objective = &self.preferences.objectives[objective];
        let name = &objective.name;
        match &objective.goal {
            Goal::Reach(target) => self.reaches(name, &self.mask(target)?, within),
            Goal::Satisfy { condition, decided, .. } => {
                let decided = self.mask(decided)?;
                let ends = |&node: &usize| within[node] && self.graph.choices(node).next().is_none();
                if let Some(node) = (0..self.graph.len()).filter(ends).find(|&node| !decided[node]) {
                    return self.fault(node, format!("the policy ends before `{name}` is achieved"));
                }
                let all = disjuncts(condition, self.graph.len(), |mark| self.mask(mark))?;
                match self.violating(&all, within)? {
                    Some(node) => self.fault(node, format!("a path of the policy violates `{name}`")),
                    None => Ok(()),
                }
            }
        }
    }

    fn mask(&self, condition: &Predicate) -> Result<Set> {
        self.policy.nodes.iter().map(|node| holds(self.program, condition, &node.state)).collect()
    }

    fn reaches(&self, name: &str, target: &[bool], within: &[bool]) -> Check {
        let near = self.graph.least(target.to_vec(), |node, near| {
            self.graph.can_choose(node, |next| next.iter().any(|&to| near[to] || !within[to]))
        })?;
        // Nodes after the target need not reach it again.
        let mut seen = vec![false; within.len()];
        let mut open: Vec<usize> = (0..self.policy.starts).collect();
        for node in (0..within.len()).filter(|&node| !within[node]) {
            open.extend(self.graph.successors(node));
        }
        while let Some(node) = open.pop() {
            if !within[node] || std::mem::replace(&mut seen[node], true) || target[node] {
                continue;
            }
            if !near[node] {
                return self.fault(node, format!("no path of the policy leads to the target of `{name}`"));
            }
            open.extend(self.graph.successors(node));
        }
        Ok(())
    }

    /// Returns a node of an end component within some nodes that no disjunct accepts.
    fn violating(&self, all: &[Accepting], within: &[bool]) -> Check<Option<usize>> {
        for component in self.graph.end_components(within)? {
            let Some(accepting) = all.iter().find(|own| own.accepts(&component)) else {
                return Ok(component.first().copied());
            };
            // A part that violates this disjunct lacks one of its sets.
            for set in &accepting.again {
                let mut part = vec![false; within.len()];
                component.iter().for_each(|&node| part[node] = !set[node]);
                if let Some(node) = self.violating(all, &part)? {
                    return Ok(Some(node));
                }
            }
        }
        Ok(None)
    }
}
