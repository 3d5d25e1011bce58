//! The quantities of a graph with ranks: P_k, C_k and N of its nodes, and the choices that attain them.

use meliora_base::error::{Error, Result};
use meliora_base::exact::Ratio;
use meliora_base::interval::{Bounds, Interval};

use crate::graphs::game_graph::{Edge, LOST};
use crate::graphs::graph::{Graph, NONE};
use crate::graphs::meter::Meter;
use crate::solvers::horizon::Horizon;
use crate::solvers::part::{Part, Search};
use crate::solvers::solved::Solved;
use crate::solvers::system::Quantity;
use crate::solvers::ties::{self, Solutions, Ties};
use crate::values::confirmed::{self, Confirmed};

#[derive(Debug)]
enum Numbers {
    Rounded(Solved<Interval>),
    Exact(Solved<Ratio>),
}

macro_rules! on {
    ($numbers:expr, $solved:ident => $body:expr) => {
        match $numbers {
            Numbers::Rounded($solved) => $body,
            Numbers::Exact($solved) => $body,
        }
    };
}

/// The quantities of a graph. In a game, we maximise P_k and N and minimise C_k, and the opponent does the contrary.
#[derive(Debug)]
pub struct Quantities {
    levels: usize,
    numbers: Numbers,
    horizon: Option<Horizon>,
    /// The choices that attain the values in the fewest steps, where they are known.
    ties: Option<Ties>,
    /// The search for choices that end in the part of the graph that was explored.
    search: Option<Search>,
}

impl Quantities {
    /// Creates quantities up to P_k and C_k for k = `levels`, without results; fractions instead of bounds if they are to be
    /// `exact`.
    pub fn new(levels: usize, exact: bool) -> Self {
        let numbers = match exact {
            true => Numbers::Exact(Solved::new(levels)),
            false => Numbers::Rounded(Solved::new(levels)),
        };
        Quantities { levels, numbers, horizon: None, ties: None, search: None }
    }

    /// Computes all quantities of a graph; of a part of it, bounds of those of the whole graph. `within` is the number of
    /// steps of the curves of the starts; see [`Quantities::curve`]. The results before an error are kept. Cost: the equations
    /// of each quantity, component by component; one pass over the graph per step and level of the curves.
    ///
    /// # Errors
    /// A limit is reached.
    pub fn solve(
        &mut self,
        graph: &Graph,
        starts: &[u32],
        within: Option<usize>,
        meter: &mut Meter<'_>,
    ) -> Result<()> {
        let levels = self.levels;
        let end = on!(&mut self.numbers, solved => {
            *solved = Solved::new(levels);
            solved.run(graph, meter)
        });
        if let Numbers::Rounded(solved) = &mut self.numbers
            && graph.frontier > 0
        {
            self.search = Some(Search::begin(graph, solved, starts, end.is_ok()));
            self.follow(graph);
            self.judge(graph, meter)?;
        }
        end?;
        if let Some(steps) = within {
            self.horizon.insert(Horizon::default()).run(graph, levels, steps, starts, meter)?;
        }
        Ok(())
    }

    /// Decides ties between choices that attain P_k or C_k by the least expected number of steps until the k-th improvement,
    /// or until fewer than k are possible. Fractions and games keep the choices of the solver. Cost: at most three times that
    /// of costs with [`Quantities::solve`].
    ///
    /// # Errors
    /// A limit is reached.
    pub fn decide_ties(&mut self, graph: &mut Graph, meter: &mut Meter<'_>) -> Result<()> {
        let Numbers::Rounded(solved) = &mut self.numbers else { return Ok(()) };
        if graph.is_game() {
            return Ok(());
        }
        let costs = ties::costs(graph);
        solved.add_fractions(graph);
        let [probability, cost] = solved.by_level();
        let solutions = Solutions { graph, fractions: &solved.fractions, costs, probability, cost };
        self.ties = solutions.decide(meter)?;
        Ok(())
    }

    /// Returns whether the bounds of the starts are narrow: the graph is whole, or its part is enough.
    pub fn is_settled(&self, graph: &Graph) -> bool {
        self.search.as_ref().map_or(graph.frontier == 0, |search| search.is_narrow)
    }

    /// Follows choices in a part of a graph: the best ones, and from nodes that were not solved or from which they never lead
    /// to an improvement, those with the fewest [`Graph::steps`]. Returns the nodes that are to be explored, or whose next
    /// nodes are to be measured, before the next call; none if the choices end in the part. Cost: linear in the nodes that the
    /// choices reach.
    pub fn follow(&mut self, graph: &Graph) -> Vec<u32> {
        self.part(graph).map_or_else(Vec::new, |mut part| part.follow())
    }

    /// Bounds the values from the other side if the choices that were followed end in the part. Cost: the solution of the
    /// equations of these choices.
    ///
    /// # Errors
    /// A limit is reached.
    pub fn judge(&mut self, graph: &Graph, meter: &mut Meter<'_>) -> Result<()> {
        self.part(graph).map_or(Ok(()), |mut part| part.judge(meter))
    }

    /// Returns the part of a graph with its search, if there is one.
    fn part<'a>(&'a mut self, graph: &'a Graph) -> Option<Part<'a>> {
        let (Numbers::Rounded(solved), Some(search)) = (&mut self.numbers, &mut self.search) else {
            return None;
        };
        Some(Part { graph, solved, search })
    }

    /// Returns the nodes that the choices of a part of a graph reach, the unexplored ones first, and forgets them. `None`
    /// before the first solution.
    pub fn take_missing(&mut self, graph: &Graph) -> Option<Vec<u32>> {
        self.search.take().map(|search| search.entered(graph))
    }

    /// Returns whether the equations of a node were solved: it was explored before.
    pub fn is_solved(&self, graph: &Graph, node: u32) -> bool {
        let solved = |search: &Search| graph.choices(node).all(|choice| search.has_solved(choice));
        !graph.is_frontier(node) && self.search.as_ref().is_none_or(solved)
    }

    /// Returns the solution of the equation of a node; `None` if it has none, or a limit was reached before.
    pub fn value(&self, node: u32, quantity: Quantity) -> Option<Bounds> {
        on!(&self.numbers, solved => solved.value(node, quantity))
    }

    /// Returns the value Σ p · v if a choice is taken, with the costs of the choice; `None` if it is not permitted or not
    /// known.
    pub fn of_choice(&self, graph: &Graph, quantity: Quantity, choice: u32) -> Option<Bounds> {
        let is_known = |edge: Edge| {
            let follows = || quantity.after(edge).follows_from(graph.rank(edge.to));
            edge.to == LOST || self.is_solved(graph, edge.to) || follows()
        };
        let is_solved = self.search.as_ref().is_none_or(|search| search.has_solved(choice));
        if !is_solved || !graph.edges(choice).all(is_known) {
            return None;
        }
        on!(&self.numbers, solved => solved.of_choice(graph, quantity, choice))
    }

    /// Returns the choice that a strategy takes in a node to attain P_k (where it is 1, also C_k), or C_k; `None` where P_k
    /// is 0 (for C_k: less than 1), or if it is not known.
    ///
    /// The choices of all nodes together attain the values, up to the precision. Among equally good choices this is one that
    /// comes closer to an improvement and, after [`Quantities::decide_ties`], one with which the expected number of steps is
    /// least.
    pub fn pick(&self, graph: &Graph, quantity: Quantity, node: u32) -> Option<u32> {
        let rank = graph.rank(node);
        let (k, level) = match quantity {
            Quantity::Probability(k) => (k, rank.positive),
            Quantity::Cost(k) => (k, rank.sure),
            _ => return None,
        };
        let index = k.checked_sub(1).filter(|_| level >= k)? as usize;
        let quantity = if rank.sure >= k { Quantity::Cost(k) } else { quantity };
        let choice = match &self.ties {
            Some(ties) => ties.pick(node, index),
            None => on!(&self.numbers, solved => solved.get(quantity)?.pick(node)),
        };
        (choice != NONE).then_some(choice)
    }

    /// Returns the most that the strategy of [`Quantities::pick`] loses of P_k, and of C_k.
    pub fn loss(&self, node: u32, k: usize) -> [f64; 2] {
        let ties = self.ties.as_ref().zip(k.checked_sub(1));
        ties.map_or_else(Default::default, |(ties, index)| ties.loss(node, index))
    }

    /// Returns P_k^0, P_k^1, …, the greatest probabilities of k improvements from a start within 0, 1, … steps, as far as they
    /// are known: lower bounds with an error of some 1e-16 per step.
    pub fn curve(&self, node: u32, k: usize) -> Option<&[f64]> {
        self.horizon.as_ref()?.curve(node, k)
    }

    /// Widens the bounds where one step does not confirm them. `shows_ones` says that ranks do not show where probabilities
    /// are 1. Cost: that of [`Quantities::solve`], and one exact step per choice and bound.
    ///
    /// # Errors
    /// A limit is reached; the values are fractions.
    pub fn confirmed(&self, graph: &Graph, shows_ones: bool, meter: &mut Meter<'_>) -> Result<Confirmed> {
        match &self.numbers {
            Numbers::Rounded(solved) => confirmed::confirmed(solved, graph, shows_ones, meter),
            Numbers::Exact(_) => Err(Error::Usage("certificates need bounds, not exact values".to_owned())),
        }
    }
}
