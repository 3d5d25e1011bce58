//! The solutions of all systems of equations of one graph, with one kind of numbers.

use bitvec::vec::BitVec;

use crate::equations::graph::Graph;
use crate::equations::meter::Meter;
use crate::equations::number::{Bounds, Interval, Number};
use crate::equations::solution::Solution;
use crate::equations::system::{Quantity, System};
use meliora_base::error::Result;

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

    /// Solves the systems of all levels, and that of the expected numbers.
    ///
    /// # Errors
    /// A limit is reached; the solutions before it are kept.
    pub(crate) fn run(&mut self, graph: &Graph, levels: usize, meter: &mut Meter<'_>) -> Result<()> {
        meter.take(graph.fractions().len() * N::BYTES)?;
        self.fractions = graph.fractions().iter().map(N::of).collect();
        for k in 1..=levels as u32 {
            next(graph, &self.fractions, Quantity::Probability(k), &mut self.probability, meter)?;
        }
        for k in 1..=levels as u32 {
            next(graph, &self.fractions, Quantity::Cost(k), &mut self.cost, meter)?;
        }
        let below = self.probability.first();
        let (number, end) = solution(graph, &self.fractions, Quantity::Number, below, meter)?;
        self.number = Some(number);
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
        let below = index.checked_sub(1).and_then(|below| solutions.get(below));
        let system = System::new(graph, quantity, below, &self.fractions);
        system.value(choice, solutions.get(index)?).as_ref().map(Bounds::of)
    }
}

/// Solves the next system of a list.
fn next<N: Number>(
    graph: &Graph,
    fractions: &[N],
    quantity: Quantity,
    solutions: &mut Vec<Solution<N>>,
    meter: &mut Meter<'_>,
) -> Result<()> {
    let (solution, end) = solution(graph, fractions, quantity, solutions.last(), meter)?;
    solutions.push(solution);
    end
}

/// Solves a system; returns the known part of its solution, and an error if a limit was reached.
fn solution<N: Number>(
    graph: &Graph,
    fractions: &[N],
    quantity: Quantity,
    below: Option<&Solution<N>>,
    meter: &mut Meter<'_>,
) -> Result<(Solution<N>, Result<()>)> {
    let system = System::new(graph, quantity, below, fractions);
    let mut solution = system.start(meter)?;
    let end = system.solve(&mut solution, meter);
    Ok((solution, end))
}
