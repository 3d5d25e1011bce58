//! A game as the solvers see it: numbered states with owners, their choices, and exact probabilities.

use std::ops::Range;
use std::sync::Arc;

use bitvec::vec::BitVec;
use meliora_base::exact::Ratio;
use meliora_model::Optimum;
use meliora_space::weighted::Fractions;
use num_traits::{One, Zero};

use super::choices::Choices;
use super::narrow::Narrow;

/// The number that stands for a missing node, choice, row or position.
pub const NONE: u32 = u32::MAX;
/// The target of an edge that is lost: it weakens, so the path has failed.
pub const LOST: u32 = u32::MAX;

/// An edge of a choice.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Edge {
    /// The node that is entered, or [`LOST`].
    pub to: u32,
    /// Twice the number of the probability, plus 1 if the step counts.
    weight: u32,
}

impl Edge {
    /// Creates an edge to a node, or [`LOST`], with the number of its probability in
    /// [`GameGraph::fractions`]; `counts` says whether the step is an improvement.
    pub fn new(to: u32, probability: u32, counts: bool) -> Self {
        // 2^30 fractions need more than 32 GiB; the meter ends the work long before.
        assert!(probability < 1 << 30);
        Edge { to, weight: 2 * probability + u32::from(counts) }
    }

    /// Returns the stored number of the probability and of whether the step counts.
    pub(crate) fn weight(self) -> u32 {
        self.weight
    }

    /// Returns the number of the probability in [`GameGraph::fractions`].
    pub fn probability(self) -> u32 {
        self.weight / 2
    }

    /// Returns whether the step is an improvement: the next level counts from there.
    pub fn counts(self) -> bool {
        self.weight % 2 == 1
    }
}

/// The extremes that the players of a game look for; without a game, ours counts alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Extremes {
    /// The extreme of our states.
    pub ours: Optimum,
    /// The extreme of those of the opponent.
    pub theirs: Optimum,
}

impl Extremes {
    /// All choices look for the same extreme.
    pub fn all(optimum: Optimum) -> Self {
        Extremes { ours: optimum, theirs: optimum }
    }

    /// We look for an extreme against an opponent who looks for the other one.
    pub fn against(ours: Optimum) -> Self {
        Extremes { ours, theirs: opposite(ours) }
    }

    /// Returns the goal with both extremes exchanged: that of 1 minus a probability.
    pub fn opposite(self) -> Self {
        Extremes { ours: opposite(self.ours), theirs: opposite(self.theirs) }
    }
}

/// Returns the other extreme.
pub(crate) fn opposite(optimum: Optimum) -> Optimum {
    if optimum == Optimum::Max { Optimum::Min } else { Optimum::Max }
}

/// A game on numbered states. Without an opponent, it is an MDP.
#[derive(Debug, Default)]
pub struct GameGraph {
    /// The choices of the states, and their successors.
    pub choices: Choices,
    /// The row of each state among [`GameGraph::choices`], or [`NONE`] of one without choices, if the rows are not in the
    /// order of the states.
    pub(crate) row_of: Option<Vec<u32>>,
    /// The weight of each edge; see [`Edge`].
    pub(crate) weights: Narrow,
    pub(crate) fractions: Fractions,
    /// The states in which the opponent chooses; `None` if every state is ours.
    pub(crate) theirs: Option<BitVec>,
}

impl GameGraph {
    /// Returns the number of states.
    pub fn states(&self) -> usize {
        self.row_of.as_ref().map_or(self.choices.first.len() - 1, Vec::len)
    }

    /// Adds an edge to the choice that is being built.
    pub(crate) fn add_edge(&mut self, edge: Edge) {
        self.choices.to.push(edge.to);
        self.weights.push(edge.weight());
    }

    /// Ends the choice whose edges were added.
    pub(crate) fn end_choice(&mut self) {
        self.choices.end_choice();
    }

    /// Ends the node whose choices were added.
    pub(crate) fn end_node(&mut self) {
        self.choices.end_node();
    }

    /// Returns the states in which the greatest value is looked for.
    pub fn maximisers(&self, goal: Extremes) -> BitVec {
        let ours = goal.ours == Optimum::Max;
        match &self.theirs {
            Some(theirs) if goal.ours != goal.theirs => theirs.iter().map(|theirs| *theirs != ours).collect(),
            _ => BitVec::repeat(ours, self.states()),
        }
    }

    /// Returns whether the opponent chooses in a node.
    #[inline]
    pub fn is_theirs(&self, node: u32) -> bool {
        self.theirs.as_ref().and_then(|theirs| theirs.get(node as usize)).is_some_and(|theirs| *theirs)
    }

    /// Returns the choices of a node.
    #[inline]
    pub fn choices(&self, node: u32) -> Range<u32> {
        match self.row_of.as_ref().map_or(node, |rows| rows[node as usize]) {
            NONE => 0..0,
            row => self.choices.first[row as usize]..self.choices.first[row as usize + 1],
        }
    }

    /// Returns the edges of a choice.
    #[inline]
    pub fn edges(&self, choice: u32) -> impl Iterator<Item = Edge> + Clone {
        self.positions(choice..choice + 1).map(|at| self.edge(at))
    }

    /// Returns the successors of a choice with the numbers of their probabilities.
    #[inline]
    pub fn outcomes(&self, choice: usize) -> impl Iterator<Item = (u32, u32)> + Clone {
        self.edges(choice as u32).map(|edge| (edge.to, edge.probability()))
    }

    /// Returns the edge at a position.
    #[inline]
    pub(crate) fn edge(&self, at: u32) -> Edge {
        Edge { to: self.choices.to[at as usize], weight: self.weights.get(at as usize) }
    }

    /// Returns the positions of the edges of some choices that follow each other.
    #[inline]
    pub(crate) fn positions(&self, choices: Range<u32>) -> Range<u32> {
        self.choices.start[choices.start as usize]..self.choices.start[choices.end as usize]
    }

    /// Returns the positions of the edges of a node.
    pub(crate) fn edges_of(&self, node: u32) -> Range<u32> {
        self.positions(self.choices(node))
    }

    /// Returns all probabilities, and all costs of a graph, by number.
    #[inline]
    pub fn fractions(&self) -> &[Ratio] {
        self.fractions.list()
    }

    /// Returns the same, for nodes of strategies that share them.
    pub fn shared_fractions(&self) -> Vec<Arc<Ratio>> {
        self.fractions().iter().cloned().map(Arc::new).collect()
    }

    /// Returns the number of choices of all nodes.
    pub fn choices_in_all(&self) -> usize {
        self.choices.start.len() - 1
    }

    /// Returns the number of edges of all choices.
    pub(crate) fn edges_in_all(&self) -> usize {
        self.choices.to.len()
    }
}

/// The rewards of a structure in a game.
#[derive(Debug, Default)]
pub struct Rewards {
    pub(crate) fractions: Fractions,
    /// The number of what each state earns, whatever is chosen there.
    pub(crate) of_state: Narrow,
    /// The number of what each choice earns, with the reward of its state.
    pub(crate) of_choice: Narrow,
}

impl Rewards {
    /// Returns rewards that depend on states alone: 1 in some states, 0 in the others.
    pub fn of_set(game: &GameGraph, set: &BitVec) -> Self {
        let mut rewards = Rewards::default();
        let numbers = [Ratio::zero(), Ratio::one()].map(|value| rewards.fractions.number(value));
        for state in 0..game.states() {
            let number = numbers[usize::from(set[state])];
            rewards.of_state.push(number);
            game.choices.of(state as u32).for_each(|_| rewards.of_choice.push(number));
        }
        rewards
    }

    /// Returns rewards that depend on choices alone: those of all choices of a game, in their order.
    pub fn of_choices(game: &GameGraph, all: impl Iterator<Item = Ratio>) -> Self {
        let mut rewards = Rewards::default();
        let nothing = rewards.fractions.number(Ratio::zero());
        (0..game.states()).for_each(|_| rewards.of_state.push(nothing));
        for reward in all {
            let number = rewards.fractions.number(reward);
            rewards.of_choice.push(number);
        }
        rewards
    }

    /// Returns whether a choice earns nothing.
    pub fn is_free(&self, choice: usize) -> bool {
        Zero::is_zero(self.choice(choice))
    }

    /// Returns what a choice earns, with the reward of its state.
    #[inline]
    pub fn choice(&self, choice: usize) -> &Ratio {
        &self.fractions.list()[self.of_choice.get(choice) as usize]
    }

    /// Returns what a state earns, whatever is chosen there.
    pub fn state(&self, state: usize) -> &Ratio {
        &self.fractions.list()[self.of_state.get(state) as usize]
    }
}
