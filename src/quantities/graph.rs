//! The graph of the solver: numbered nodes, their kept choices, and edges with exact probabilities.

use std::ops::Range;

use bitvec::vec::BitVec;

use super::meter::Meter;
use super::narrow::Narrow;
use meliora_engine::explicit::weighted::Fractions;
use meliora_model::error::Result;
use meliora_model::exact::Ratio;

/// The target of an edge that is lost: it weakens, so the path has failed.
pub(super) const LOST: u32 = u32::MAX;
/// The rank of a node that is in every level.
pub(super) const EVERY: u32 = u32::MAX;

/// An edge of a choice.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Edge {
    /// The node that is entered, or [`LOST`].
    pub(super) to: u32,
    /// Twice the number of the probability, plus 1 if the step counts.
    weight: u32,
}

impl Edge {
    /// Creates an edge to a node, or [`LOST`], with the number of its probability in
    /// [`Graph::fractions`]; `counts` says whether the step is an improvement.
    pub(super) fn new(to: u32, probability: u32, counts: bool) -> Self {
        // 2^31 fractions need more than 64 GiB; the meter ends the work long before.
        assert!(probability < 1 << 31);
        Edge { to, weight: 2 * probability + u32::from(counts) }
    }

    /// Returns the number of the probability in [`Graph::fractions`].
    pub(super) fn probability(self) -> u32 {
        self.weight / 2
    }

    /// Returns whether the step is an improvement: the next level counts from there.
    pub(super) fn counts(self) -> bool {
        self.weight % 2 == 1
    }
}

/// What is known of a node before any number is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Rank {
    /// The greatest k with P_k > 0, or [`EVERY`].
    pub(super) positive: u32,
    /// The greatest k with P_k = 1, or [`EVERY`].
    pub(super) sure: u32,
}

/// A node: a state in an arena. Under `prefix`, an improving step first enters a *junction*, a node
/// with up to two choices of cost 0 that take no step: to count the improvement, or not.
///
/// Large models have as many nodes as fit into memory, so numbers are stored in as few bytes as they
/// need: about 10 bytes per node, and 6 per choice and per edge.
#[derive(Debug, Default)]
pub(super) struct Graph {
    /// The two ranks of each node plus 1; 0 for [`EVERY`].
    positive: Narrow,
    sure: Narrow,
    junction: BitVec,
    /// The first choice of each node, and the number of its choices.
    first_choice: Vec<u32>,
    choices: Narrow,
    first_edge: Vec<u32>,
    /// The node that each edge enters, and its weight.
    to: Vec<u32>,
    weights: Narrow,
    /// The cost of each choice, by its number in [`Graph::fractions`].
    costs: Narrow,
    /// The position of each choice among the choices of its state in the order of the program.
    positions: Narrow,
    /// All probabilities and costs.
    pub(super) known: Fractions,
}

impl Graph {
    /// Returns the number of nodes.
    pub(super) fn nodes(&self) -> usize {
        self.junction.len()
    }

    /// Adds a node without choices.
    pub(super) fn add_node(&mut self, rank: Rank, junction: bool, meter: &mut Meter) -> Result<u32> {
        meter.take(self.bytes_of_node())?;
        let node = meter.number(self.nodes())?;
        self.positive.push(rank.positive.wrapping_add(1));
        self.sure.push(rank.sure.wrapping_add(1));
        self.junction.push(junction);
        self.first_choice.push(0);
        self.choices.push(0);
        Ok(node)
    }

    /// Returns the bytes of a node.
    fn bytes_of_node(&self) -> usize {
        4 + self.positive.width() + self.sure.width() + self.choices.width()
    }

    /// Returns what is known of a node.
    pub(super) fn rank(&self, node: u32) -> Rank {
        let [positive, sure] =
            [&self.positive, &self.sure].map(|list| list.get(node as usize).wrapping_sub(1));
        Rank { positive, sure }
    }

    /// Returns whether a node is a junction.
    pub(super) fn is_junction(&self, node: u32) -> bool {
        self.junction[node as usize]
    }

    /// Begins the choices of a node. They are added one after the other, each with its edges, until
    /// [`Graph::end`].
    ///
    /// # Errors
    /// There are too many choices.
    pub(super) fn begin(&mut self, node: u32, meter: &Meter) -> Result<()> {
        self.first_choice[node as usize] = meter.number(self.first_edge.len())?;
        Ok(())
    }

    /// Adds a choice: its position among the choices of the state and the number of its cost.
    ///
    /// # Errors
    /// There are too many edges.
    pub(super) fn add_choice(&mut self, position: u32, cost: u32, meter: &Meter) -> Result<()> {
        self.positions.push(position);
        self.costs.push(cost);
        self.first_edge.push(meter.number(self.to.len())?);
        Ok(())
    }

    /// Adds an edge to the last choice.
    pub(super) fn add_edge(&mut self, edge: Edge) {
        self.to.push(edge.to);
        self.weights.push(edge.weight);
    }

    /// Ends the choices of a node.
    ///
    /// # Errors
    /// A limit is reached.
    pub(super) fn end(&mut self, node: u32, meter: &mut Meter) -> Result<()> {
        let first = self.first_choice[node as usize];
        let count = meter.number(self.first_edge.len())? - first;
        self.choices.set(node as usize, count);
        let (start, end) = self.edge_range(first, first + count);
        let (choice, edge) = (self.positions.width() + self.costs.width() + 4, self.weights.width() + 4);
        meter.take(count as usize * choice + (end - start) as usize * edge)
    }

    /// Returns all probabilities and costs by number.
    pub(super) fn fractions(&self) -> &[Ratio] {
        self.known.list()
    }

    /// Returns the number of a fraction.
    pub(super) fn fraction(&mut self, fraction: Ratio) -> u32 {
        self.known.number(fraction)
    }

    /// Returns the choices of a node.
    pub(super) fn choices(&self, node: u32) -> Range<u32> {
        let first = self.first_choice[node as usize];
        first..first + self.choices.get(node as usize)
    }

    /// Returns the number of the cost of a choice in [`Graph::fractions`].
    pub(super) fn cost(&self, choice: u32) -> u32 {
        self.costs.get(choice as usize)
    }

    /// Returns the position of a choice among the choices of its state.
    pub(super) fn position(&self, choice: u32) -> usize {
        self.positions.get(choice as usize) as usize
    }

    /// Returns the edges of a choice.
    pub(super) fn edges(&self, choice: u32) -> impl Iterator<Item = Edge> + Clone {
        let (start, end) = self.edge_range(choice, choice + 1);
        (start..end).map(|position| self.at(position))
    }

    fn at(&self, position: u32) -> Edge {
        Edge { to: self.to[position as usize], weight: self.weights.get(position as usize) }
    }

    /// Returns the positions of the first edge of a range of choices, and of the one after the last.
    pub(super) fn edge_range(&self, first: u32, end: u32) -> (u32, u32) {
        let start =
            |choice: u32| self.first_edge.get(choice as usize).copied().unwrap_or(self.to.len() as u32);
        (start(first), start(end))
    }

    /// Returns the number of edges of all choices.
    pub(super) fn edges_in_all(&self) -> usize {
        self.to.len()
    }

    /// Returns the node that an edge enters, or [`LOST`], by its position.
    pub(super) fn target(&self, position: u32) -> u32 {
        self.to[position as usize]
    }

    /// Returns the bytes of the graph.
    pub(super) fn bytes(&self) -> usize {
        self.nodes() * self.bytes_of_node()
            + self.first_edge.len() * (4 + self.costs.width() + self.positions.width())
            + self.to.len() * (4 + self.weights.width())
    }
}
