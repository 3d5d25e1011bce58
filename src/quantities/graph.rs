//! The graph of the solver: numbered nodes, their kept choices, and edges with exact probabilities.

use super::meter::Meter;
use crate::engine::explicit::weighted::Fractions;
use crate::error::Result;
use crate::model::exact::Ratio;

/// The target of an edge that is lost: it weakens, so the play has failed.
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
#[derive(Debug, Default)]
pub(super) struct Graph {
    pub(super) ranks: Vec<Rank>,
    pub(super) junction: Vec<bool>,
    /// The choices of node n are `first_choice[n]..first_choice[n+1]`, for nodes that are closed.
    first_choice: Vec<(u32, u32)>,
    first_edge: Vec<u32>,
    edges: Vec<Edge>,
    /// The cost of each choice, by its number in [`Graph::fractions`].
    pub(super) costs: Vec<u32>,
    /// The position of each choice among the choices of its state in the order of the program.
    pub(super) positions: Vec<u32>,
    /// All probabilities and costs.
    pub(super) known: Fractions,
}

/// A choice of a node: its position among the choices of the state, the number of its cost, and its
/// edges.
pub(super) type Closed = (u32, u32, Vec<Edge>);

impl Graph {
    /// Returns the number of nodes.
    pub(super) fn nodes(&self) -> usize {
        self.ranks.len()
    }

    /// Adds a node without choices.
    pub(super) fn add_node(&mut self, rank: Rank, junction: bool, meter: &mut Meter) -> Result<u32> {
        meter.take(size_of::<Rank>() + 1 + size_of::<(u32, u32)>())?;
        let node = meter.number(self.ranks.len())?;
        self.ranks.push(rank);
        self.junction.push(junction);
        self.first_choice.push((0, 0));
        Ok(node)
    }

    /// Sets the choices of a node.
    pub(super) fn close(&mut self, node: u32, choices: Vec<Closed>, meter: &mut Meter) -> Result<()> {
        let start = meter.number(self.positions.len())?;
        for (position, cost, edges) in choices {
            meter.take(12 + edges.len() * size_of::<Edge>())?;
            self.positions.push(position);
            self.costs.push(cost);
            self.first_edge.push(meter.number(self.edges.len())?);
            self.edges.extend(edges);
        }
        self.first_choice[node as usize] = (start, meter.number(self.positions.len())?);
        Ok(())
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
    pub(super) fn choices(&self, node: u32) -> std::ops::Range<u32> {
        let (start, end) = self.first_choice[node as usize];
        start..end
    }

    /// Returns the edges of a choice.
    pub(super) fn edges(&self, choice: u32) -> &[Edge] {
        let start = self.first_edge[choice as usize] as usize;
        let end = self.first_edge.get(choice as usize + 1).map_or(self.edges.len(), |&end| end as usize);
        &self.edges[start..end]
    }

    /// Returns the positions of the first edge of a range of choices, and of the one after the last.
    pub(super) fn edge_range(&self, first: u32, end: u32) -> (u32, u32) {
        let start =
            |choice: u32| self.first_edge.get(choice as usize).copied().unwrap_or(self.edges.len() as u32);
        (start(first), start(end))
    }

    /// Returns an edge by its position, and the choice of the range that has it.
    pub(super) fn edge(&self, position: u32, choices: &std::ops::Range<u32>) -> (u32, Edge) {
        let firsts = &self.first_edge[choices.start as usize..choices.end as usize];
        let after = firsts.partition_point(|&first| first <= position) as u32;
        (choices.start + after - 1, self.edges[position as usize])
    }

    /// Returns the bytes of the graph.
    pub(super) fn bytes(&self) -> usize {
        self.nodes() * 24 + self.positions.len() * 12 + self.edges.len() * size_of::<Edge>()
    }
}
