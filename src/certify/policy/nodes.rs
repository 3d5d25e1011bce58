//! Policies with memory: nodes, each a state with what the policy remembers there, and the actions that it takes.
//!
//! The check lists all states that the model can reach from those of the nodes, and computes anew which objectives are
//! sure in them. Each field of a node is then checked against its state, and against the nodes that follow:
//!
//! - `most_preferred` is MP(s), and s is a state from which the requirements can be kept.
//! - `reference` is what steps are compared with. It begins as MP of the start, and changes only by an improvement, to
//!   MP of the state that improves on it. With `safety = action` it is always that of the state. No step weakens it.
//! - `ahead` improvements are still to come, almost surely (SASI, plan) or possibly (SPI); see `levels`.
//! - `pursues` are the objectives that the policy achieves from here on almost surely; see `pursuits`.
//! - `commits` says that a plan has given up other objectives: later steps are not compared with a reference.
//!
//! All of this holds against every opponent: a node where it chooses has all its choices, unless the policy ends there.
//! The check does not show that no other policy promises more.

use ahash::{AHashMap, AHashSet};

use super::graph::Graph;
use super::rules::{FaultKind, PolicyFault, Taken, step};
use super::space::{Space, steps};
use crate::safety::has_reference;
use meliora_base::error::{Error, Result};
use meliora_base::progress::ProgressSink;
use meliora_dump::manifest::SafetyMode;
use meliora_model::preference::{Change, ObjectiveSet, Preferences};
use meliora_model::{Program, State};

meliora_base::named! {
    /// The aim of a policy.
    pub enum Aim {
        /// It makes improvements almost surely.
        Sasi,
        /// It makes improvements with positive probability.
        Spi,
        /// It makes improvements almost surely, and then achieves a most preferred objective almost surely.
        Plan,
        /// It achieves some objectives almost surely.
        Achieve,
    }
}

/// The promise of a policy.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Promise {
    /// The aim.
    pub aim: Aim,
    /// The comparison of steps: `prefix` or `action`.
    pub safety: SafetyMode,
    /// The objectives that it achieves or, where they are most preferred, those that a plan pursues.
    pub objectives: ObjectiveSet,
}

/// A policy with memory.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NodePolicy {
    /// The promise.
    pub promise: Promise,
    /// The number of nodes where paths may start: the first ones.
    pub starts: usize,
    /// The nodes.
    pub nodes: Vec<Node>,
}

/// A state with what the policy remembers there.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Node {
    /// The state.
    pub state: State,
    /// The most preferred objectives of the state.
    pub most_preferred: ObjectiveSet,
    /// The objectives that steps are compared with.
    pub reference: ObjectiveSet,
    /// The number of improvements to come; `None` for any number.
    pub ahead: Option<usize>,
    /// The objectives that are pursued.
    pub pursues: ObjectiveSet,
    /// True if a plan has committed to the objective that it pursues.
    pub commits: bool,
    /// The actions, of which each is taken with the same probability, or all choices of the opponent; none where the
    /// policy ends.
    pub actions: Vec<Taking>,
}

/// An action of a node.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Taking {
    /// The action.
    pub taken: Taken,
    /// The node of each successor.
    pub next: Vec<usize>,
}

/// A policy that keeps its promise.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Accepted {
    /// The number of states of the model that were listed.
    pub states: usize,
}

/// The reason why a check ends.
pub(super) enum Stop {
    Fault(PolicyFault),
    Error(Error),
}

impl<E: Into<Error>> From<E> for Stop {
    fn from(error: E) -> Self {
        Stop::Error(error.into())
    }
}

pub(super) type Check<T = ()> = std::result::Result<T, Stop>;

/// A policy under a check.
pub(super) struct Checker<'c> {
    pub(super) program: &'c Program,
    pub(super) preferences: &'c Preferences,
    pub(super) policy: &'c NodePolicy,
    /// The nodes with their steps: one choice in a node of ours, since the policy makes it.
    pub(super) graph: Graph<'c>,
}

impl NodePolicy {
    /// Checks that the policy keeps its promise from each of its starts, of which `initial`, the initial states of the
    /// model, are some. Cost: one step of the program per state that the model reaches, and a fixpoint per objective.
    ///
    /// # Errors
    /// A limit; a command has no meaning in a state. A fault of the policy is a result.
    pub fn check(
        &self,
        program: &Program,
        preferences: &Preferences,
        initial: &[State],
        sink: &dyn ProgressSink,
    ) -> Result<std::result::Result<Accepted, PolicyFault>> {
        let mut checker = Checker { program, preferences, policy: self, graph: Graph::new(sink) };
        match checker.run(initial, sink) {
            Ok(accepted) => Ok(Ok(accepted)),
            Err(Stop::Fault(fault)) => Ok(Err(fault)),
            Err(Stop::Error(error)) => Err(error),
        }
    }

    /// Returns the node that paths from a state start in.
    pub fn start(&self, state: &State) -> Option<usize> {
        self.nodes[..self.starts].iter().position(|node| node.state == *state)
    }

    /// Returns whether a step between two nodes is an improvement.
    pub fn improves(&self, preferences: &Preferences, from: usize, to: usize) -> bool {
        let (from, to) = (&self.nodes[from], &self.nodes[to]);
        to.reference == to.most_preferred
            && preferences.change(&from.reference, &to.most_preferred) == Change::Improving
    }
}

impl Checker<'_> {
    fn run(&mut self, initial: &[State], sink: &dyn ProgressSink) -> Check<Accepted> {
        self.starts(initial)?;
        for node in 0..self.policy.nodes.len() {
            if let Some(limit) = sink.stop() {
                return Err(limit.into());
            }
            let (theirs, choices) = self.steps(node)?;
            self.graph.add(theirs, choices);
        }
        let states = self.states(sink)?;
        for node in 0..self.policy.nodes.len() {
            self.memory(node)?;
            for to in self.graph.successors(node) {
                self.reference(node, to)?;
            }
        }
        self.levels()?;
        self.pursuits()?;
        Ok(Accepted { states })
    }

    pub(super) fn fault<T>(&self, node: usize, what: impl Into<String>) -> Check<T> {
        self.broken(&self.policy.nodes[node].state, FaultKind::Broken(what.into()))
    }

    fn broken<T>(&self, state: &State, kind: FaultKind) -> Check<T> {
        Err(Stop::Fault(PolicyFault { state: state.clone(), kind }))
    }

    pub(super) fn ensure(&self, node: usize, holds: bool, what: &str) -> Check {
        if holds { Ok(()) } else { self.fault(node, what) }
    }

    /// Checks that each initial state has one node.
    fn starts(&self, initial: &[State]) -> Check {
        let nodes = &self.policy.nodes[..self.policy.starts];
        let mut known = AHashSet::new();
        if let Some(node) = nodes.iter().position(|node| !known.insert(&node.state)) {
            return self.fault(node, "two nodes start in a state");
        }
        match initial.iter().find(|state| !known.contains(state)) {
            Some(state) => {
                self.broken(state, FaultKind::Broken("no node starts in an initial state".to_owned()))
            }
            None => Ok(()),
        }
    }

    /// Returns who chooses in a node, and the nodes that each choice leads to; checks that they are the successors in the
    /// model.
    fn steps(&self, node: usize) -> Check<(bool, Vec<Vec<usize>>)> {
        let own = &self.policy.nodes[node];
        let (steps, theirs) = steps(self.program, &own.state)?;
        let mut known = AHashSet::new();
        for Taking { taken, next } in &own.actions {
            let found = match step(self.program, taken, steps.clone()) {
                Ok(found) => found,
                Err(kind) => return self.broken(&own.state, kind),
            };
            self.ensure(node, known.insert(found.choice.clone()), "an action occurs twice")?;
            let of: AHashMap<&State, usize> =
                next.iter().map(|&to| (&self.policy.nodes[to].state, to)).collect();
            let is_each = next.len() == found.successors.len()
                && found.successors.iter().all(|(s, _)| of.contains_key(s));
            self.ensure(node, is_each, "the nodes after an action do not have its successors, each once")?;
        }
        let all = own.actions.iter().map(|own| own.next.clone());
        if !theirs {
            let merged: Vec<usize> = all.flatten().collect();
            return Ok((false, if merged.is_empty() { Vec::new() } else { vec![merged] }));
        }
        let is_whole = known.is_empty() || known.len() == steps.len();
        self.ensure(node, is_whole, "a choice of the opponent is missing")?;
        Ok((true, all.collect()))
    }

    /// Checks what the nodes say of their states; returns the number of states that were listed.
    fn states(&self, sink: &dyn ProgressSink) -> Check<usize> {
        let nodes = &self.policy.nodes;
        let mut space = Space::explore(self.program, nodes.iter().map(|node| &node.state), sink)?;
        let kept = space.require(self.preferences)?;
        let numbers: Vec<usize> = nodes.iter().filter_map(|node| space.number(&node.state)).collect();
        let found = space.most_preferred(self.preferences, &numbers)?;
        for (node, (number, found)) in numbers.iter().zip(&found).enumerate() {
            self.ensure(node, kept[*number], "no strategy keeps the requirements from this state")?;
            if nodes[node].most_preferred != *found {
                let names = self.preferences.names(found).join(", ");
                return self.fault(node, format!("the most preferred objectives are {{{names}}}"));
            }
        }
        Ok(space.graph.len())
    }

    /// Checks that what a node remembers fits the aim, and that it begins with the class of its state.
    fn memory(&self, node: usize) -> Check {
        let (own, aim) = (&self.policy.nodes[node], self.policy.promise.aim);
        let compares = aim != Aim::Achieve && has_reference(self.policy.promise.safety) && !own.commits;
        let is_own = own.reference == own.most_preferred;
        let begins = node < self.policy.starts;
        self.ensure(node, is_own || compares && !begins, "the reference is not the class of the state")?;
        let change = self.preferences.change(&own.reference, &own.most_preferred);
        self.ensure(node, change != Change::Weakening, "the state weakens the reference")?;
        let commits = aim == Aim::Plan && own.ahead == Some(0) && !own.pursues.is_empty();
        self.ensure(node, !own.commits || commits, "only a plan that pursues an objective commits")?;
        let improves = aim != Aim::Achieve || own.ahead == Some(0);
        self.ensure(node, improves, "a policy that achieves objectives makes no improvement")
    }

    /// Checks that a step does not weaken the reference, and changes it by an improvement only.
    fn reference(&self, from: usize, to: usize) -> Check {
        let Promise { aim, safety, .. } = self.policy.promise;
        if aim == Aim::Achieve {
            return Ok(());
        }
        let (a, b) = (&self.policy.nodes[from], &self.policy.nodes[to]);
        let change = self.preferences.change(&a.reference, &b.most_preferred);
        let weakens = change == Change::Weakening && !a.commits;
        self.ensure(from, !weakens, "a step weakens the reference")?;
        let may_renew = change == Change::Improving || !has_reference(safety) || a.commits || b.commits;
        let is_kept = has_reference(safety) && a.reference == b.reference;
        let is_right = is_kept || may_renew && b.reference == b.most_preferred;
        self.ensure(from, is_right, "a step that does not improve changes the reference")
    }

    /// Returns whether a step is an improvement.
    pub(super) fn improves(&self, from: usize, to: usize) -> bool {
        self.policy.improves(self.preferences, from, to)
    }
}
