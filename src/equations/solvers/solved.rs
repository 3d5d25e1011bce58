//! The solutions of all systems of equations of one graph, with one kind of numbers.

use bitvec::vec::BitVec;

use crate::graphs::game_graph::{Extremes, LOST};
use crate::graphs::graph::Graph;
use crate::graphs::meter::Meter;
use crate::solvers::sides::Sides;
use crate::solvers::solution::Solution;
use crate::solvers::solve::solved;
use crate::solvers::system::{Quantity, Sets, System};
use meliora_base::error::Result;
use meliora_base::interval::{Bounds, Interval};
use meliora_base::number::Number;

/// The solutions so far.
#[derive(Debug)]
pub(crate) struct Solved<N> {
    /// The fractions of the graph as numbers.
    pub(crate) fractions: Vec<N>,
    /// P_1, P_2, …, C_1, C_2, …, N, as far as they are solved.
    pub(crate) solutions: Vec<Solution<N>>,
    /// The number of levels.
    levels: usize,
    /// The nodes where N is infinite; empty without an opponent.
    pub(crate) endless: BitVec,
}

impl<N: Number> Solved<N> {
    /// Creates solutions of some levels, without results.
    pub(crate) fn new(levels: usize) -> Self {
        Solved { fractions: Vec::new(), solutions: Vec::new(), levels, endless: BitVec::new() }
    }

    /// Returns the quantities in the order of their solutions.
    pub(crate) fn quantities(&self) -> impl Iterator<Item = Quantity> + use<N> {
        let levels = 1..=self.levels as u32;
        let probabilities = levels.clone().map(Quantity::Probability);
        probabilities.chain(levels.map(Quantity::Cost)).chain([Quantity::Number])
    }

    /// Returns the place of the solution of a quantity.
    pub(crate) fn place(&self, quantity: Quantity) -> usize {
        match quantity {
            Quantity::Probability(k) => k as usize - 1,
            Quantity::Cost(k) => self.levels + k as usize - 1,
            _ => 2 * self.levels,
        }
    }

    /// Returns the place of the solution that the equations of a quantity need: that of the level below, or P_1 for N.
    pub(crate) fn below(&self, quantity: Quantity) -> Option<usize> {
        match quantity {
            Quantity::Probability(1) | Quantity::Cost(1) => None,
            Quantity::Number => (self.levels > 0).then_some(0),
            _ => Some(self.place(quantity) - 1),
        }
    }

    /// Returns the solution of a quantity, if it is known.
    pub(crate) fn get(&self, quantity: Quantity) -> Option<&Solution<N>> {
        self.solutions.get(self.place(quantity))
    }

    /// Returns the solutions P_1, P_2, … and C_1, C_2, …
    pub(crate) fn by_level(&self) -> [&[Solution<N>]; 2] {
        let (probabilities, rest) = self.solutions.split_at(self.levels.min(self.solutions.len()));
        [probabilities, &rest[..self.levels.min(rest.len())]]
    }

    /// Solves the systems of all levels, and that of the expected numbers. In a game, we maximise P_k and N and minimise
    /// C_k, and the opponent does the contrary.
    ///
    /// # Errors
    /// A limit is reached; the solutions before it are kept.
    pub(crate) fn run(&mut self, graph: &Graph, meter: &mut Meter<'_>) -> Result<()> {
        meter.take(graph.fractions().len() * N::BYTES)?;
        self.add_fractions(graph);
        for quantity in self.quantities() {
            let (solution, end) = match quantity {
                Quantity::Number if graph.theirs.is_some() => self.number_of_game(graph, meter)?,
                _ => {
                    let below = self.below(quantity).map(|at| &self.solutions[at]);
                    solved(graph, quantity, (below, &self.fractions), meter)?
                }
            };
            self.solutions.push(solution);
            end?;
        }
        Ok(())
    }

    /// Adds the fractions that a graph has since then.
    pub(crate) fn add_fractions(&mut self, graph: &Graph) {
        self.fractions.extend(graph.fractions()[self.fractions.len()..].iter().map(N::of));
    }

    /// Solves the equations of the expected numbers of improvements of a game: an opponent may let us improve without end.
    fn number_of_game(&mut self, graph: &Graph, meter: &mut Meter<'_>) -> Result<(Solution<N>, Result<()>)> {
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
        Ok((solution, end))
    }

    /// Returns the value of a node.
    pub(crate) fn value(&self, node: u32, quantity: Quantity) -> Option<Bounds> {
        let is_endless = || self.endless.get(node as usize).is_some_and(|endless| *endless);
        if quantity == Quantity::Number && is_endless() {
            return Some(Bounds { interval: Interval::point(f64::INFINITY), exact: None });
        }
        self.get(quantity)?.get(node).map(Bounds::of)
    }

    /// Returns the value of a quantity of some level if a choice is taken; `None` if it is not permitted.
    pub(crate) fn of_choice(&self, graph: &Graph, quantity: Quantity, choice: u32) -> Option<Bounds> {
        let below = self.below(quantity).and_then(|at| self.solutions.get(at));
        let system = System::new(graph, quantity, below, &self.fractions);
        system.value(choice, self.get(quantity)?).as_ref().map(Bounds::of)
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
