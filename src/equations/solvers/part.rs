//! Bounds of the values of some nodes from a part of the graph.
//!
//! Nodes that were not explored get the best values that their ranks allow, so the solution of the part bounds the values of
//! the whole graph from one side: P_k and N from above, C_k from below. If the choices that attain it enter no unexplored
//! node, their values bound those of the whole graph from the other side. Else the nodes near the paths of these choices are
//! to be explored next.
//!
//! Sources: E. Hansen and S. Zilberstein, "LAO*: a heuristic search algorithm that finds solutions with loops" (2001);
//! T. Brázdil et al., "Verification of Markov decision processes using learning algorithms" (ATVA 2014).

use bitvec::vec::BitVec;
use meliora_base::error::Result;
use meliora_model::Optimum;

use crate::graphs::game_graph::{Edge, LOST};
use crate::graphs::graph::{EVERY, Graph, NONE};
use crate::graphs::meter::Meter;
use crate::solvers::solution::Solution;
use crate::solvers::solved::Solved;
use crate::solvers::system::{Quantity, System};
use meliora_base::interval::{Interval, PRECISION};

/// The nodes that a part of a graph lacks for the values of some nodes.
#[derive(Debug)]
pub(crate) struct Missing {
    /// True if the bounds of these values are narrow.
    pub(crate) is_narrow: bool,
    /// The nodes that the best choices reach, the unexplored ones first: the nodes near them are to be explored next.
    pub(crate) nodes: Vec<u32>,
}

/// The nodes that the best choices for one quantity reach.
struct Followed {
    quantity: Quantity,
    nodes: BitVec,
    /// These choices.
    picks: BitVec,
}

/// The solutions of a part of a graph, and the nodes that their choices reach.
struct Part<'a> {
    graph: &'a Graph,
    solved: &'a mut Solved<Interval>,
    /// P_1, P_2, …, C_1, C_2, …, N
    followed: Vec<Followed>,
    /// The nodes whose choices were not followed yet.
    open: Vec<(Quantity, u32)>,
    /// The nodes that choices enter.
    entered: BitVec,
}

/// Replaces the solutions of a part of a graph, in which unexplored nodes have the best values, by bounds for the whole
/// graph. `complete` says whether all systems were solved. Cost: some steps over the graph, and the solution of the equations
/// of the best choices.
///
/// # Errors
/// A limit is reached.
pub(crate) fn settle(
    solved: &mut Solved<Interval>,
    graph: &Graph,
    starts: &[u32],
    complete: bool,
    meter: &mut Meter<'_>,
) -> Result<Missing> {
    let mut part = Part::new(graph, solved);
    let asked = part.enter_starts(starts);
    let is_closed = complete && part.follow() && part.entered(true).next().is_none();
    let attained = if is_closed { part.attained(meter) } else { Ok(Vec::new()) };
    part.bound(attained.as_deref().unwrap_or_default());
    attained?;
    let is_narrow = is_closed && asked.iter().all(|&(quantity, node)| part.is_narrow(quantity, node));
    let nodes = part.entered(true).chain(part.entered(false)).collect();
    Ok(Missing { is_narrow, nodes })
}

impl<'a> Part<'a> {
    fn new(graph: &'a Graph, solved: &'a mut Solved<Interval>) -> Self {
        let of = |quantity| Followed {
            quantity,
            nodes: BitVec::repeat(false, graph.nodes()),
            picks: BitVec::repeat(false, graph.choices_in_all()),
        };
        let followed = solved.quantities().take(solved.solutions.len()).map(of).collect();
        Part { graph, solved, followed, open: Vec::new(), entered: BitVec::repeat(false, graph.nodes()) }
    }

    /// Enters some nodes and the ends of their choices with all quantities; returns these.
    fn enter_starts(&mut self, starts: &[u32]) -> Vec<(Quantity, u32)> {
        let graph = self.graph;
        for at in 0..self.followed.len() {
            let quantity = self.followed[at].quantity;
            starts.iter().for_each(|&start| self.enter(quantity, start));
            let choices = starts.iter().flat_map(|&start| graph.choices(start));
            choices.flat_map(|choice| graph.edges(choice)).for_each(|edge| self.enter_by(quantity, edge));
        }
        self.open.clone()
    }

    /// Finds the nodes that the best choices reach; false if one of them has none.
    fn follow(&mut self) -> bool {
        let mut is_known = true;
        while let Some((quantity, node)) = self.open.pop() {
            let choice = self.solved.get(quantity).map_or(NONE, |own| own.pick(node));
            if choice == NONE {
                is_known = false;
                continue;
            }
            let at = self.solved.place(quantity);
            self.followed[at].picks.set(choice as usize, true);
            self.graph.edges(choice).for_each(|edge| self.enter_by(quantity, edge));
        }
        is_known
    }

    /// Enters the end of an edge of a node with a quantity.
    fn enter_by(&mut self, quantity: Quantity, edge: Edge) {
        if edge.to != LOST {
            self.enter(quantity.after(edge), edge.to);
        }
    }

    /// Notes that a quantity of a node is needed, unless the value follows from its rank.
    fn enter(&mut self, quantity: Quantity, node: u32) {
        let rank = self.graph.rank(node);
        if quantity.follows_from(rank) {
            return;
        }
        if quantity == Quantity::Number && rank.positive == 1 && self.solved.below(quantity).is_some() {
            return self.enter(Quantity::Probability(1), node);
        }
        self.entered.set(node as usize, true);
        let at = self.solved.place(quantity);
        if !self.graph.is_frontier(node) && !self.followed[at].nodes.replace(node as usize, true) {
            self.open.push((quantity, node));
        }
    }

    /// Returns the unexplored or the explored nodes that choices enter.
    fn entered(&self, frontier: bool) -> impl Iterator<Item = u32> {
        let all = self.entered.iter_ones().map(|node| node as u32);
        all.filter(move |&node| self.graph.is_frontier(node) == frontier)
    }

    /// Solves the equations of the best choices alone.
    fn attained(&self, meter: &mut Meter<'_>) -> Result<Vec<Solution<Interval>>> {
        let mut found: Vec<Solution<Interval>> = Vec::new();
        for Followed { quantity, nodes, picks } in &self.followed {
            let below = self.solved.below(*quantity).map(|at| &found[at]);
            let system = System::new(self.graph, *quantity, below, &self.solved.fractions);
            let system = System { scope: Some(nodes), found: Some(picks), ..system };
            let mut solution = system.start(meter)?;
            system.solve(&mut solution, meter)?;
            found.push(solution);
        }
        Ok(found)
    }

    /// Bounds the values of all nodes from both sides, as far as the best choices were followed.
    fn bound(&mut self, attained: &[Solution<Interval>]) {
        let graph = self.graph;
        for at in 0..self.followed.len() {
            let quantity = self.followed[at].quantity;
            let own = attained.get(at);
            let most = if quantity.is_probability() { 1.0 } else { f64::INFINITY };
            let nodes = std::mem::take(&mut self.followed[at].nodes);
            self.solved.solutions[at].revise(|node, hoped| {
                let own = own.filter(|_| nodes[node as usize]).and_then(|own| own.get(node));
                let is_endless = quantity == Quantity::Number && graph.rank(node).positive == EVERY;
                match quantity.leader() {
                    Optimum::Max => {
                        let upper = if is_endless { most } else { hoped.upper };
                        Interval { lower: own.map_or(0.0, |own| own.lower), upper }
                    }
                    Optimum::Min => Interval { lower: hoped.lower, upper: own.map_or(most, |own| own.upper) },
                }
            });
        }
    }

    /// Returns whether the bounds of a value are narrow.
    fn is_narrow(&self, quantity: Quantity, node: u32) -> bool {
        let value = self.solved.get(quantity).and_then(|own| own.get(node));
        value.is_some_and(|value| value.relative_width() <= PRECISION)
    }
}
