//! The solutions of all systems of equations of one graph, with one kind of numbers.

use bitvec::vec::BitVec;

use crate::equations::game_graph::{Edge, Extremes, LOST};
use crate::equations::graph::Graph;
use crate::equations::meter::Meter;
use crate::equations::solution::Solution;
use crate::equations::system::{Quantity, Sets, System};
use crate::solvers::sides::Sides;
use crate::solvers::solve::solved;
use meliora_base::error::Result;
use meliora_base::interval::{Bounds, Interval};
use meliora_base::number::Number;

/// The solutions so far.
#[derive(Debug)]
pub(crate) struct Solved<N> {
    /// The fractions of the graph as numbers.
    pub(crate) fractions: Vec<N>,
    /// P_1, P_2, …
    pub(crate) probability: Vec<Solution<N>>,
    /// C_1, C_2, …
    pub(crate) cost: Vec<Solution<N>>,
    pub(crate) number: Option<Solution<N>>,
    /// The nodes where N is infinite; empty without an opponent.
    pub(crate) endless: BitVec,
}

impl<N: Number> Solved<N> {
    /// Creates solutions without results.
    pub(crate) fn new() -> Self {
        Solved {
            fractions: Vec::new(),
            probability: Vec::new(),
            cost: Vec::new(),
            number: None,
            endless: BitVec::new(),
        }
    }

    /// Solves the systems of all levels, and that of the expected numbers. In a game, we maximise P_k and N and minimise
    /// C_k, and the opponent does the contrary.
    ///
    /// # Errors
    /// A limit is reached; the solutions before it are kept.
    pub(crate) fn run(&mut self, graph: &Graph, levels: usize, meter: &mut Meter<'_>) -> Result<()> {
        meter.take(graph.fractions().len() * N::BYTES)?;
        self.fractions = graph.fractions().iter().map(N::of).collect();
        for k in 1..=levels as u32 {
            let below = self.probability.last();
            let (solution, end) = solved(graph, Quantity::Probability(k), (below, &self.fractions), meter)?;
            self.probability.push(solution);
            end?;
        }
        for k in 1..=levels as u32 {
            let below = self.cost.last();
            let (solution, end) = solved(graph, Quantity::Cost(k), (below, &self.fractions), meter)?;
            self.cost.push(solution);
            end?;
        }
        if graph.theirs.is_some() {
            return self.run_number_of_game(graph, meter);
        }
        let below = self.probability.first();
        let (number, end) = solved(graph, Quantity::Number, (below, &self.fractions), meter)?;
        self.number = Some(number);
        end
    }

    /// Solves the equations of the expected numbers of improvements of a game: an opponent may let us improve without end.
    fn run_number_of_game(&mut self, graph: &Graph, meter: &mut Meter<'_>) -> Result<()> {
        let nodes = 0..graph.nodes() as u32;
        meter.take(graph.choices.bytes())?;
        self.endless = endless(graph, meter)?;
        meter.release(graph.choices.bytes());
        let is_endless = |node: u32| node != LOST && self.endless[node as usize];
        let is_open = |node: u32| graph.rank(node).positive > 0 && !is_endless(node);
        let stays = |choice: u32| !graph.edges(choice).any(|edge| is_endless(edge.to));
        let sets = Sets {
            open: nodes.map(is_open).collect(),
            ones: BitVec::repeat(false, graph.nodes()),
            permitted: (0..graph.choices_in_all() as u32).map(stays).collect(),
        };
        let asked = (Quantity::Number, Extremes::against(Quantity::Number.leader()));
        let system = System::of_sets((graph, &sets), asked, None, &self.fractions);
        let mut solution = system.start(meter)?;
        let end = system.solve(&mut solution, meter);
        self.number = Some(solution);
        end
    }

    pub(crate) fn probability(&self, node: u32, index: usize) -> Option<Bounds> {
        self.probability.get(index)?.get(node).map(Bounds::of)
    }

    pub(crate) fn cost(&self, node: u32, index: usize) -> Option<Bounds> {
        self.cost.get(index)?.get(node).map(Bounds::of)
    }

    pub(crate) fn number(&self, node: u32) -> Option<Bounds> {
        if self.endless.get(node as usize).is_some_and(|endless| *endless) {
            return Some(Bounds { interval: Interval::point(f64::INFINITY), exact: None });
        }
        self.number.as_ref()?.get(node).map(Bounds::of)
    }

    /// Returns the probability of level `index` + 1 if a choice is taken.
    pub(crate) fn choice_probability(&self, graph: &Graph, choice: u32, index: usize) -> Option<Bounds> {
        let quantity = Quantity::Probability(index as u32 + 1);
        self.choice(graph, quantity, &self.probability, choice, index)
    }

    /// Returns the cost of level `index` + 1 if a choice is taken; `None` if it is not permitted.
    pub(crate) fn choice_cost(&self, graph: &Graph, choice: u32, index: usize) -> Option<Bounds> {
        self.choice(graph, Quantity::Cost(index as u32 + 1), &self.cost, choice, index)
    }

    fn choice(
        &self,
        graph: &Graph,
        quantity: Quantity,
        solutions: &[Solution<N>],
        choice: u32,
        index: usize,
    ) -> Option<Bounds> {
        let is_unknown = |edge: Edge| {
            let follows = || quantity.after(edge).follows_from(graph.rank(edge.to));
            edge.to != LOST && graph.is_frontier(edge.to) && !follows()
        };
        if graph.edges(choice).any(is_unknown) {
            return None;
        }
        let below = index.checked_sub(1).and_then(|below| solutions.get(below));
        let system = System::new(graph, quantity, below, &self.fractions);
        system.value(choice, solutions.get(index)?).as_ref().map(Bounds::of)
    }
}

/// Returns the nodes of a game from which we improve without end with positive probability, whatever the opponent does.
fn endless(graph: &Graph, meter: &mut Meter<'_>) -> Result<BitVec> {
    let (nodes, mut choices) = (graph.nodes(), graph.choices.clone());
    // A node without choices is where paths are lost.
    choices.to.iter_mut().filter(|to| **to == LOST).for_each(|to| *to = nodes as u32);
    choices.first.extend(choices.first.last().copied());
    let counts = |choice: u32| graph.edges(choice).any(|edge| edge.counts());
    let counting = (0..graph.choices_in_all() as u32).map(counts).collect();
    let allowed = BitVec::repeat(true, graph.choices_in_all());
    let mut left: BitVec = (0..nodes as u32).map(|node| graph.rank(node).positive > 0).collect();
    let mut ours: BitVec = (0..nodes as u32).map(|node| !graph.is_theirs(node)).collect();
    left.push(false);
    ours.push(true);
    Sides::new(&choices, &ours, &allowed, meter)?.recurring(&counting, &left, meter)
}
