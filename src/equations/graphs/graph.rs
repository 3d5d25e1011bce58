//! The graph of the solver: numbered nodes, their kept choices, and edges with exact probabilities.

use std::ops::{Deref, DerefMut};

use ahash::AHashMap;
use bitvec::vec::BitVec;
use meliora_space::weighted::Fractions;

pub(crate) use crate::graphs::game_graph::NONE;
use crate::graphs::game_graph::{Edge, GameGraph};
use crate::graphs::meter::Meter;
use crate::graphs::narrow::Narrow;
use meliora_base::error::Result;
use meliora_base::exact::Ratio;

/// The rank of a node that is in every level.
pub const EVERY: u32 = u32::MAX;

/// The rank of a node, before any number is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Rank {
    /// The greatest k with P_k > 0, or [`EVERY`].
    pub positive: u32,
    /// The greatest k with P_k = 1, or [`EVERY`].
    pub sure: u32,
}

/// The facts about a node that it shares with many others.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct Kind {
    rank: Rank,
    junction: bool,
    /// A lower bound of the number of steps to an improvement.
    steps: u32,
}

/// A node: a state in an arena. Under `prefix`, an improving step first enters a *junction*, a node
/// with up to two choices of cost 0 that take no step: to count the improvement, or not.
///
/// Large models have as many nodes as fit into memory, so numbers are stored in as few bytes as they need.
#[derive(Debug, Default)]
pub struct Graph {
    /// The kind of each node, and the kinds in use: few nodes differ in them.
    kind_of: Narrow,
    kinds: Vec<Kind>,
    kind_numbers: AHashMap<Kind, u32>,
    /// The number of the kind of the last node.
    last: u32,
    /// In a part of a graph, the number of nodes of the [frontier](Graph::is_frontier).
    pub(crate) frontier: usize,
    /// In a part of a graph, the greatest number of improvements of each kind, and its least cost until an improvement, by
    /// their numbers among the fractions.
    best: Vec<[u32; 2]>,
    /// A lower bound of the cost of a step.
    step_cost: Ratio,
    /// The nodes with their choices and owners, as far as these have begun; the fractions are those of costs, too.
    pub(crate) game: GameGraph,
    /// The cost of each choice, by its number in [`GameGraph::fractions`].
    pub(crate) costs: Narrow,
    /// The position of each choice among those of its state.
    pub(crate) positions: Narrow,
}

impl Deref for Graph {
    type Target = GameGraph;

    fn deref(&self) -> &GameGraph {
        &self.game
    }
}

impl DerefMut for Graph {
    fn deref_mut(&mut self) -> &mut GameGraph {
        &mut self.game
    }
}

impl Graph {
    /// Lets nodes have owners, before the first one is added: the graph is a game.
    pub fn be_game(&mut self) {
        self.theirs = Some(BitVec::new());
    }

    /// Returns whether the graph is a game.
    pub fn is_game(&self) -> bool {
        self.theirs.is_some()
    }

    /// Lets nodes be explored in any order, before the first one is added: the graph may end as a part of a larger one.
    /// `step_cost` is a lower bound of the cost of a step.
    pub fn be_part(&mut self, step_cost: Ratio) {
        self.row_of.get_or_insert_default();
        self.step_cost = step_cost;
    }

    /// Returns the probabilities and costs, for more of them.
    pub fn fractions_mut(&mut self) -> &mut Fractions {
        &mut self.game.fractions
    }

    /// Returns the nodes that the choices of a node enter, or [`LOST`](crate::LOST).
    pub fn successors(&self, node: u32) -> impl Iterator<Item = u32> {
        self.edges_of(node).map(|at| self.edge(at).to)
    }

    /// Returns the number of nodes.
    pub fn nodes(&self) -> usize {
        self.kind_of.len()
    }

    /// Adds a node without choices.
    pub fn add_node(&mut self, rank: Rank, junction: bool, meter: &mut Meter) -> Result<u32> {
        meter.take(self.bytes_of_node())?;
        let node = meter.number(self.nodes())?;
        let kind = self.kind(Kind { rank, junction, steps: 0 });
        self.kind_of.push(kind);
        if let Some(rows) = &mut self.row_of {
            rows.push(NONE);
            self.frontier += usize::from(rank.positive > 0);
        }
        Ok(node)
    }

    /// Returns a lower bound of the number of steps of a node to an improvement, if it is certain; 0 if none is known.
    pub fn steps(&self, node: u32) -> u32 {
        self.kinds[self.kind_of.get(node as usize) as usize].steps
    }

    /// Notes a lower bound of the number of steps of a node to an improvement.
    pub fn note_steps(&mut self, node: u32, steps: u32) {
        let known = self.kinds[self.kind_of.get(node as usize) as usize];
        let kind = self.kind(Kind { steps, ..known });
        self.kind_of.set(node as usize, kind);
    }

    /// Returns the number of a kind, a new one if the kind is new.
    fn kind(&mut self, kind: Kind) -> u32 {
        let Graph { kinds, kind_numbers, last, .. } = self;
        // Nodes that are found one after the other are mostly of one kind.
        if kinds.get(*last as usize) != Some(&kind) {
            *last = *kind_numbers.entry(kind).or_insert_with(|| {
                kinds.push(kind);
                kinds.len() as u32 - 1
            });
        }
        *last
    }

    /// Returns the bytes of a node.
    fn bytes_of_node(&self) -> usize {
        let row = if self.row_of.is_some() { 4 } else { 0 };
        4 + row + self.kind_of.width()
    }

    /// Returns the rank of a node.
    #[inline]
    pub fn rank(&self, node: u32) -> Rank {
        self.kinds[self.kind_of.get(node as usize) as usize].rank
    }

    /// Returns whether a node of a part of a graph that may improve is not explored yet.
    pub fn is_frontier(&self, node: u32) -> bool {
        self.row_of.is_some() && self.is_unexplored(node)
    }

    /// Returns whether a node may improve and has no choices yet; in a whole graph, those are added in the order of nodes.
    pub fn is_unexplored(&self, node: u32) -> bool {
        self.row_of.as_ref().is_none_or(|rows| rows[node as usize] == NONE) && self.rank(node).positive > 0
    }

    /// Notes the best values of all kinds.
    fn note_best(&mut self) {
        for kind in self.best.len()..self.kinds.len() {
            let Kind { rank: Rank { positive, .. }, steps, .. } = self.kinds[kind];
            let most = Ratio::from_integer(if positive == EVERY { 0 } else { positive }.into());
            let least = &self.step_cost * Ratio::from_integer(steps.into());
            let best = [most, least].map(|value| self.fraction(value));
            self.best.push(best);
        }
    }

    /// Returns the greatest number of improvements of an unexplored node, by its number among the fractions; meaningless if
    /// there is none.
    pub(crate) fn most_improvements(&self, node: u32) -> u32 {
        self.best[self.kind_of.get(node as usize) as usize][0]
    }

    /// Returns a lower bound of the cost until an improvement, if it is certain, by its number among the fractions.
    pub(crate) fn least_cost(&self, node: u32) -> u32 {
        self.best[self.kind_of.get(node as usize) as usize][1]
    }

    /// Returns whether some node may have such a rank. Cost: linear in the number of different ranks.
    pub(crate) fn has_rank(&self, is_such: impl Fn(Rank) -> bool) -> bool {
        self.kinds.iter().any(|kind| is_such(kind.rank))
    }

    /// Returns whether a node is a junction.
    #[inline]
    pub fn is_junction(&self, node: u32) -> bool {
        self.kinds[self.kind_of.get(node as usize) as usize].junction
    }

    /// Notes the side that chooses in a node of a game.
    pub fn set_owner(&mut self, node: u32, is_theirs: bool) {
        if let Some(theirs) = &mut self.theirs {
            theirs.resize(node as usize + 1, false);
            theirs.set(node as usize, is_theirs);
        }
    }

    /// Begins the choices of a node; in a whole graph, after those of all nodes before it. They are added one after the other
    /// until [`Graph::end`].
    ///
    /// # Errors
    /// There are too many edges.
    pub fn begin(&mut self, node: u32, meter: &Meter) -> Result<()> {
        meter.number(self.choices.to.len())?;
        if self.row_of.is_none() {
            let choices = self.costs.len() as u32;
            self.choices.first.resize(node as usize + 1, choices);
        }
        Ok(())
    }

    /// Adds a choice: its position among the choices of the state and the number of its cost.
    #[inline]
    pub fn add_choice(&mut self, position: u32, cost: u32) {
        self.positions.push(position);
        self.costs.push(cost);
        let edges = self.choices.to.len() as u32;
        self.choices.start.push(edges);
    }

    /// Adds an edge to the last choice.
    #[inline]
    pub fn add_edge(&mut self, edge: Edge) {
        self.choices.to.push(edge.to);
        self.weights.push(edge.weight());
        self.choices.start.last_mut().into_iter().for_each(|end| *end += 1);
    }

    /// Ends the choices of a node.
    ///
    /// # Errors
    /// A limit is reached.
    pub fn end(&mut self, node: u32, meter: &mut Meter) -> Result<()> {
        meter.number(self.choices.to.len())?;
        let (choices, row) = (self.costs.len() as u32, self.choices.first.len() as u32 - 1);
        self.choices.first.push(choices);
        if let Some(rows) = &mut self.row_of {
            rows[node as usize] = row;
            self.frontier -= 1;
        }
        let edges = self.edges_of(node).len() * (4 + self.weights.width());
        meter.take(edges + self.game.choices(node).len() * self.bytes_of_choice())
    }

    /// Ends the graph, or a part of it: the nodes whose choices have not begun have none.
    pub fn finish(&mut self) {
        if self.row_of.is_some() {
            return self.note_best();
        }
        let (nodes, choices) = (self.nodes(), self.costs.len() as u32);
        self.choices.first.resize(nodes + 1, choices);
        if let Some(theirs) = &mut self.theirs {
            theirs.resize(nodes, false);
        }
    }

    /// Returns the bytes of a choice without its edges.
    fn bytes_of_choice(&self) -> usize {
        4 + self.costs.width() + self.positions.width()
    }

    /// Returns the number of a fraction.
    pub fn fraction(&mut self, fraction: Ratio) -> u32 {
        self.game.fractions.number(fraction)
    }

    /// Returns the number of the cost of a choice in [`GameGraph::fractions`].
    pub fn cost(&self, choice: u32) -> u32 {
        self.costs.get(choice as usize)
    }

    /// Returns the position of a choice among the choices of its state.
    pub fn position(&self, choice: u32) -> usize {
        self.positions.get(choice as usize) as usize
    }

    /// Returns the bytes of the graph.
    pub fn bytes(&self) -> usize {
        self.nodes() * self.bytes_of_node()
            + self.choices_in_all() * self.bytes_of_choice()
            + self.edges_in_all() * (4 + self.weights.width())
    }
}
