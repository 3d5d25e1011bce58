//! The graph of the solver: numbered nodes, their kept choices, and edges with exact probabilities.

use std::ops::Range;

use ahash::AHashMap;
use bitvec::vec::BitVec;

use crate::equations::choices::Choices;
use crate::equations::meter::Meter;
use crate::equations::narrow::Narrow;
use meliora_base::error::Result;
use meliora_base::exact::Ratio;
use meliora_engine::explicit::weighted::Fractions;

/// The number that stands for a missing node, choice or position.
pub(crate) const NONE: u32 = u32::MAX;
/// The target of an edge that is lost: it weakens, so the path has failed.
pub(crate) const LOST: u32 = u32::MAX;
/// The rank of a node that is in every level.
pub(crate) const EVERY: u32 = u32::MAX;

/// An edge of a choice.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Edge {
    /// The node that is entered, or [`LOST`].
    pub(crate) to: u32,
    /// Twice the number of the probability, plus 1 if the step counts.
    weight: u32,
}

impl Edge {
    /// Creates an edge to a node, or [`LOST`], with the number of its probability in
    /// [`Graph::fractions`]; `counts` says whether the step is an improvement.
    pub(crate) fn new(to: u32, probability: u32, counts: bool) -> Self {
        // 2^30 fractions need more than 32 GiB; the meter ends the work long before.
        assert!(probability < 1 << 30);
        Edge { to, weight: 2 * probability + u32::from(counts) }
    }

    /// Returns the number of the probability in [`Graph::fractions`].
    pub(crate) fn probability(self) -> u32 {
        self.weight / 2
    }

    /// Returns whether the step is an improvement: the next level counts from there.
    pub(crate) fn counts(self) -> bool {
        self.weight % 2 == 1
    }
}

/// The rank of a node, before any number is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub(crate) struct Rank {
    /// The greatest k with P_k > 0, or [`EVERY`].
    pub(crate) positive: u32,
    /// The greatest k with P_k = 1, or [`EVERY`].
    pub(crate) sure: u32,
}

/// The rank of a node, and whether it is a junction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct Kind {
    rank: Rank,
    junction: bool,
}

/// A node: a state in an arena. Under `prefix`, an improving step first enters a *junction*, a node
/// with up to two choices of cost 0 that take no step: to count the improvement, or not.
///
/// Large models have as many nodes as fit into memory, so numbers are stored in as few bytes as they need.
#[derive(Debug, Default)]
pub(crate) struct Graph {
    /// The kind of each node, and the kinds in use: few nodes differ in them.
    kind_of: Narrow,
    kinds: Vec<Kind>,
    kind_numbers: AHashMap<Kind, u32>,
    /// The choices of each node whose choices have begun, and the nodes that their edges enter.
    pub(crate) choices: Choices,
    /// The weight of each edge.
    pub(crate) weights: Narrow,
    /// The cost of each choice, by its number in [`Graph::fractions`].
    costs: Narrow,
    /// The position of each choice among those of its state.
    pub(crate) positions: Narrow,
    /// All probabilities and costs.
    pub(crate) known: Fractions,
    /// The nodes of a game in which the opponent chooses, up to the last one whose choices have begun; `None` without an
    /// opponent.
    pub(crate) theirs: Option<BitVec>,
}

impl Graph {
    /// Returns the number of nodes.
    pub(crate) fn nodes(&self) -> usize {
        self.kind_of.len()
    }

    /// Adds a node without choices.
    pub(crate) fn add_node(&mut self, rank: Rank, junction: bool, meter: &mut Meter) -> Result<u32> {
        meter.take(self.bytes_of_node())?;
        let node = meter.number(self.nodes())?;
        let kind = self.kind(Kind { rank, junction });
        self.kind_of.push(kind);
        Ok(node)
    }

    /// Returns the number of a kind, a new one if the kind is new.
    fn kind(&mut self, kind: Kind) -> u32 {
        let Graph { kinds, kind_numbers, .. } = self;
        *kind_numbers.entry(kind).or_insert_with(|| {
            kinds.push(kind);
            kinds.len() as u32 - 1
        })
    }

    /// Returns the bytes of a node.
    fn bytes_of_node(&self) -> usize {
        4 + self.kind_of.width()
    }

    /// Returns the rank of a node.
    pub(crate) fn rank(&self, node: u32) -> Rank {
        self.kinds[self.kind_of.get(node as usize) as usize].rank
    }

    /// Returns whether a node is a junction.
    pub(crate) fn is_junction(&self, node: u32) -> bool {
        self.kinds[self.kind_of.get(node as usize) as usize].junction
    }

    /// Returns whether the opponent of a game chooses in a node.
    pub(crate) fn is_theirs(&self, node: u32) -> bool {
        let theirs = self.theirs.as_ref().and_then(|theirs| theirs.get(node as usize));
        theirs.is_some_and(|theirs| *theirs)
    }

    /// Notes the side that chooses in a node of a game.
    pub(crate) fn set_owner(&mut self, node: u32, is_theirs: bool) {
        if let Some(theirs) = &mut self.theirs {
            theirs.resize(node as usize + 1, false);
            theirs.set(node as usize, is_theirs);
        }
    }

    /// Begins the choices of a node, after those of all nodes before it. They are added one after the other until
    /// [`Graph::end`].
    ///
    /// # Errors
    /// There are too many edges.
    pub(crate) fn begin(&mut self, node: u32, meter: &Meter) -> Result<()> {
        meter.number(self.choices.to.len())?;
        self.choices.first.resize(node as usize + 1, self.costs.len() as u32);
        Ok(())
    }

    /// Adds a choice: its position among the choices of the state and the number of its cost.
    pub(crate) fn add_choice(&mut self, position: u32, cost: u32) {
        self.positions.push(position);
        self.costs.push(cost);
        self.choices.start.push(self.choices.to.len() as u32);
    }

    /// Adds an edge to the last choice.
    pub(crate) fn add_edge(&mut self, edge: Edge) {
        self.choices.to.push(edge.to);
        self.weights.push(edge.weight);
        self.choices.start.last_mut().into_iter().for_each(|end| *end += 1);
    }

    /// Ends the choices of a node.
    ///
    /// # Errors
    /// A limit is reached.
    pub(crate) fn end(&mut self, node: u32, meter: &mut Meter) -> Result<()> {
        meter.number(self.choices.to.len())?;
        self.choices.first.push(self.costs.len() as u32);
        let edges = self.edges_of(node).len() * (4 + self.weights.width());
        meter.take(edges + self.choices.of(node).len() * self.bytes_of_choice())
    }

    /// Returns the bytes of a choice without its edges.
    fn bytes_of_choice(&self) -> usize {
        4 + self.costs.width() + self.positions.width()
    }

    /// Returns all probabilities and costs by number.
    pub(crate) fn fractions(&self) -> &[Ratio] {
        self.known.list()
    }

    /// Returns the number of a fraction.
    pub(crate) fn fraction(&mut self, fraction: Ratio) -> u32 {
        self.known.number(fraction)
    }

    /// Returns the choices of a node.
    pub(crate) fn choices(&self, node: u32) -> Range<u32> {
        let first =
            |node: usize| self.choices.first.get(node).map_or(self.costs.len() as u32, |&first| first);
        first(node as usize)..first(node as usize + 1)
    }

    /// Returns the number of the cost of a choice in [`Graph::fractions`].
    pub(crate) fn cost(&self, choice: u32) -> u32 {
        self.costs.get(choice as usize)
    }

    /// Returns the position of a choice among the choices of its state.
    pub(crate) fn position(&self, choice: u32) -> usize {
        self.positions.get(choice as usize) as usize
    }

    /// Returns the edges of a choice.
    pub(crate) fn edges(&self, choice: u32) -> impl Iterator<Item = Edge> + Clone {
        let edges =
            self.choices.start[choice as usize] as usize..self.choices.start[choice as usize + 1] as usize;
        edges.map(|at| Edge { to: self.choices.to[at], weight: self.weights.get(at) })
    }

    /// Returns the positions of the edges of a node.
    pub(crate) fn edges_of(&self, node: u32) -> Range<u32> {
        let choices = self.choices(node);
        self.choices.start[choices.start as usize]..self.choices.start[choices.end as usize]
    }

    /// Returns the number of choices of all nodes.
    pub(crate) fn choices_in_all(&self) -> usize {
        self.costs.len()
    }

    /// Returns the number of edges of all choices.
    pub(crate) fn edges_in_all(&self) -> usize {
        self.choices.to.len()
    }

    /// Returns the bytes of the graph.
    pub(crate) fn bytes(&self) -> usize {
        self.nodes() * self.bytes_of_node()
            + self.choices_in_all() * self.bytes_of_choice()
            + self.edges_in_all() * (4 + self.weights.width())
    }
}
