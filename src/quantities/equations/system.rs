//! The equations of a quantity and a level: which nodes have one, and the value of each choice.

use std::fmt;

use bitvec::vec::BitVec;

use crate::equations::graph::{Edge, Graph, LOST};
use crate::equations::meter::Meter;
use crate::equations::number::{Interval, Number};
use crate::equations::solution::Solution;
use meliora_base::error::{Limit, Result};

/// The optimum that is wanted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Sense {
    Max,
    Min,
}

/// A method; see [`crate`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Method {
    /// Policy iteration by elimination with doubles.
    Eliminate,
    /// Optimistic value iteration.
    Iterate,
    /// Policy iteration by elimination with fractions.
    Exact,
}

/// The quantity of a system of equations.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Quantity {
    /// P_k
    Probability(u32),
    /// C_k
    Cost(u32),
    /// N
    Number,
    /// The largest expected cost until a counted edge, where every strategy takes one almost surely.
    Reward,
    /// T_k, the least expected number of steps by candidates; see [`crate::answers::ties`]
    Steps(u32),
}

impl Quantity {
    /// Returns the number of improvements k; 1 for others.
    pub(crate) fn level(self) -> u32 {
        match self {
            Quantity::Probability(k) | Quantity::Cost(k) | Quantity::Steps(k) => k,
            Quantity::Number | Quantity::Reward => 1,
        }
    }
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Quantity::Probability(k) => write!(f, "P_{k}"),
            Quantity::Cost(k) => write!(f, "C_{k}"),
            Quantity::Number => write!(f, "N"),
            Quantity::Reward => write!(f, "the reward"),
            Quantity::Steps(k) => write!(f, "the steps to P_{k}"),
        }
    }
}

/// The choices among which the least expected number of steps decides.
#[derive(Debug)]
pub(crate) struct Candidates {
    /// The candidates, by their numbers in the graph.
    pub(crate) choices: BitVec,
    /// The choices that take no step: those of junctions.
    pub(crate) free: BitVec,
    /// The numbers of the costs 0 and 1 among the fractions of the graph.
    pub(crate) costs: [u32; 2],
}

impl Candidates {
    /// Creates a set of choices that all take a step.
    #[cfg(test)]
    pub(crate) fn of(choices: BitVec, costs: [u32; 2]) -> Self {
        let free = BitVec::repeat(false, choices.len());
        Candidates { choices, free, costs }
    }

    /// Returns whether a choice is a candidate.
    pub(crate) fn contains(&self, choice: u32) -> bool {
        self.choices[choice as usize]
    }

    /// Returns the number of steps that a choice takes, by its number among the fractions.
    pub(crate) fn cost(&self, choice: u32) -> u32 {
        self.costs[usize::from(!self.free[choice as usize])]
    }
}

/// A side of a game whose choices are fixed: the equations are those of the other side.
#[derive(Debug)]
pub(crate) struct Fixed {
    /// The choices that may be taken, by their numbers in the graph.
    pub(crate) choices: BitVec,
    /// The optimum that the other side wants.
    pub(crate) sense: Sense,
}

/// A system of equations over a graph, with the solution of the level below.
pub(crate) struct System<'a, N> {
    pub(crate) graph: &'a Graph,
    pub(crate) quantity: Quantity,
    /// The solution of level k-1; `None` for level 1. For numbers P_1, if it is known: this is N where at
    /// most one improvement is possible.
    pub(crate) below: Option<&'a Solution<N>>,
    /// The fractions of the graph as numbers.
    pub(crate) fractions: &'a [N],
    /// The only method to use, for tests.
    pub(crate) only: Option<Method>,
    /// The choices that may be taken, if not all; for steps also their costs.
    pub(crate) candidates: Option<&'a Candidates>,
    /// The side of a game that does not choose any more.
    pub(crate) fixed: Option<&'a Fixed>,
}

/// The value at the end of an edge.
pub(crate) enum End<N> {
    /// The unknown of a node, and 1 more for an improvement that is counted.
    Open(u32),
    /// A known value.
    Known(N),
}

impl<'a, N: Number> System<'a, N> {
    /// Creates the system of a quantity of a graph, with the solution of the level below.
    pub(crate) fn new(
        graph: &'a Graph,
        quantity: Quantity,
        below: Option<&'a Solution<N>>,
        fractions: &'a [N],
    ) -> Self {
        System { graph, quantity, below, fractions, only: None, candidates: None, fixed: None }
    }

    pub(crate) fn sense(&self) -> Sense {
        if let Some(fixed) = self.fixed {
            return fixed.sense;
        }
        match self.quantity {
            Quantity::Cost(_) | Quantity::Steps(_) => Sense::Min,
            Quantity::Probability(_) | Quantity::Number | Quantity::Reward => Sense::Max,
        }
    }

    /// Returns whether a node has an equation: for others, the value follows from the rank, or there
    /// is none.
    pub(crate) fn is_open(&self, node: u32) -> bool {
        let rank = self.graph.rank(node);
        match self.quantity {
            Quantity::Probability(k) => rank.positive >= k && rank.sure < k,
            Quantity::Number => rank.positive > u32::from(self.below.is_some()),
            Quantity::Cost(k) => rank.sure >= k,
            Quantity::Reward => rank.sure > 0,
            Quantity::Steps(k) => rank.positive >= k,
        }
    }

    /// Returns whether a choice may be taken: one of the candidates, if there are some; else one of a side that is not
    /// fixed, or that this side takes, and for costs one with which the improvements stay certain.
    pub(crate) fn permits(&self, choice: u32) -> bool {
        if let Some(candidates) = self.candidates {
            return candidates.contains(choice);
        }
        self.fixed.is_none_or(|fixed| fixed.choices[choice as usize]) && self.keeps_certain(choice)
    }

    /// Returns whether a component follows a choice of a node: one that may be taken. At a junction, ranks depend on both
    /// choices, whichever is fixed.
    pub(crate) fn follows(&self, node: u32, choice: u32) -> bool {
        let is_free = self.fixed.is_some() && self.graph.is_junction(node) && self.keeps_certain(choice);
        is_free || self.permits(choice)
    }

    /// Returns whether the improvements stay certain with a choice, if they must.
    pub(crate) fn keeps_certain(&self, choice: u32) -> bool {
        let Quantity::Cost(k) = self.quantity else { return true };
        let certain =
            |edge: Edge| edge.to != LOST && self.graph.rank(edge.to).sure >= k - u32::from(edge.counts());
        self.graph.edges(choice).all(certain)
    }

    /// Returns the value at the end of an edge.
    pub(crate) fn end(&self, edge: Edge, solution: &Solution<N>) -> End<N> {
        if edge.to == LOST {
            return End::Known(N::zero());
        }
        if edge.counts() && self.quantity != Quantity::Number {
            return End::Known(match (self.below, self.quantity) {
                (Some(below), _) => below.get(edge.to).cloned().unwrap_or_else(N::zero),
                (None, Quantity::Cost(_) | Quantity::Reward | Quantity::Steps(_)) => N::zero(),
                (None, _) => N::one(),
            });
        }
        let solution = match self.below {
            Some(first) if self.quantity == Quantity::Number && !self.is_open(edge.to) => first,
            _ => solution,
        };
        match solution.get(edge.to) {
            Some(value) => End::Known(value.clone()),
            None => End::Open(edge.to),
        }
    }

    /// Returns the cost of a choice, by its position among the fractions; `None` if the quantity has
    /// no costs.
    pub(crate) fn cost(&self, choice: u32) -> Option<u32> {
        match self.quantity {
            Quantity::Cost(_) | Quantity::Reward => Some(self.graph.cost(choice)),
            Quantity::Steps(_) => self.candidates.map(|candidates| candidates.cost(choice)),
            Quantity::Probability(_) | Quantity::Number => None,
        }
    }

    /// Returns the constant part of a choice that does not depend on its successors.
    pub(crate) fn own_constant(&self, choice: u32) -> N {
        self.cost(choice).map_or_else(N::zero, |cost| self.fractions[cost as usize].clone())
    }

    /// Returns an edge's constant for the expected number: 1 for an improvement.
    pub(crate) fn bonus(&self, edge: Edge) -> bool {
        edge.counts() && self.quantity == Quantity::Number
    }

    /// Returns the value of a choice under a solution; `None` if it is not permitted or a successor
    /// is not known.
    pub(crate) fn value(&self, choice: u32, solution: &Solution<N>) -> Option<N> {
        if !self.permits(choice) {
            return None;
        }
        let mut sum = self.own_constant(choice);
        for edge in self.graph.edges(choice) {
            let End::Known(mut value) = self.end(edge, solution) else { return None };
            if self.bonus(edge) {
                value = value.plus(&N::one());
            }
            sum = sum.plus(&self.fractions[edge.probability() as usize].times(&value));
        }
        Some(sum)
    }

    /// Creates a solution that contains only the facts.
    pub(crate) fn start(&self, meter: &mut Meter<'_>) -> Result<Solution<N>> {
        let is_one = |node: u32| match self.quantity {
            Quantity::Probability(k) => self.graph.rank(node).sure >= k,
            _ => false,
        };
        let has_facts =
            matches!(self.quantity, Quantity::Probability(_) | Quantity::Number | Quantity::Steps(_));
        let fact = has_facts.then_some(&is_one as &dyn Fn(u32) -> bool);
        Solution::new(self.graph.nodes(), |node| self.is_open(node), fact, meter)
    }

    /// Returns the greatest value of a node of which nothing is known.
    pub(crate) fn most(&self) -> f64 {
        if matches!(self.quantity, Quantity::Probability(_)) { 1.0 } else { f64::INFINITY }
    }

    /// Returns the bounds of a node of which nothing is known.
    ///
    /// # Errors
    /// There are none among exact numbers.
    pub(crate) fn anything(&self) -> Result<N> {
        let bounds = N::rounded(Interval { lower: 0.0, upper: self.most() });
        let what = "no exact value was found; bounds are found without `--exact`".to_owned();
        bounds.ok_or(Limit::Size { what }.into())
    }
}
