//! Bounds of the values of some nodes from a part of the graph.
//!
//! Nodes that were not explored get the best values that their ranks allow, so the solution of the part bounds the values of
//! the whole graph from one side: P_k and N from above, C_k from below. If the choices that attain it enter no unexplored
//! node, their values bound those of the whole graph from the other side. Else nodes are explored along the fewest steps from
//! the entered ones to an improvement, until some choices end in the part: where the unexplored nodes are entered rarely, these
//! are almost as good. If they are not, more nodes are to be explored.
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

/// The best choices for one quantity.
#[derive(Debug)]
struct Followed {
    quantity: Quantity,
    /// The nodes that these choices reach.
    nodes: BitVec,
    /// These choices.
    picks: BitVec,
    /// The nodes in which the way with the fewest steps to an improvement is taken.
    nearest: BitVec,
}

/// The search for choices that end in a part of a graph: the best ones, and from nodes that were not solved or from which
/// they never lead to an improvement, those with the fewest steps to one.
#[derive(Debug)]
pub(crate) struct Search {
    /// P_1, P_2, …, C_1, C_2, …, N
    followed: Vec<Followed>,
    /// The nodes whose choices were not followed yet.
    open: Vec<(Quantity, u32)>,
    /// Nodes that are to be explored, or whose next nodes are to be measured, before they are followed.
    waiting: Vec<(Quantity, u32)>,
    /// The number of choices of the nodes that were solved: those of nodes that are explored later follow them.
    solved: u32,
    /// The values that are asked for, and those after one choice.
    asked: Vec<(Quantity, u32)>,
    /// True unless an equation was not solved, or a node has no way to an improvement.
    is_known: bool,
    /// True if the bounds of the values that are asked for are narrow.
    pub(crate) is_narrow: bool,
}

/// A part of a graph, the solutions of its equations, and the search for choices that end in it.
pub(crate) struct Part<'a> {
    pub(crate) graph: &'a Graph,
    pub(crate) solved: &'a mut Solved<Interval>,
    pub(crate) search: &'a mut Search,
}

impl Search {
    /// Begins a search in a part of a graph, in which unexplored nodes have the best values: these solutions become bounds
    /// for the whole graph. `is_known` says whether all systems were solved. Cost: linear.
    pub(crate) fn begin(
        graph: &Graph,
        solved: &mut Solved<Interval>,
        starts: &[u32],
        is_known: bool,
    ) -> Search {
        let none = BitVec::new;
        let of = |quantity| Followed { quantity, nodes: none(), picks: none(), nearest: none() };
        let followed = solved.quantities().take(solved.solutions.len()).map(of).collect();
        let (open, waiting, asked) = (Vec::new(), Vec::new(), Vec::new());
        let mut search = Search {
            followed,
            open,
            waiting,
            solved: graph.choices_in_all() as u32,
            asked,
            is_known,
            is_narrow: false,
        };
        let mut part = Part { graph, solved, search: &mut search };
        part.resize();
        part.enter_starts(starts);
        part.bound(&[]);
        search.asked = search.open.iter().chain(&search.waiting).copied().collect();
        search
    }

    /// Returns whether a choice is one of a node that was solved.
    pub(crate) fn has_solved(&self, choice: u32) -> bool {
        choice < self.solved
    }

    /// Returns the nodes that the choices reach, the unexplored ones first: the nodes near them are to be explored next.
    pub(crate) fn entered(self, graph: &Graph) -> Vec<u32> {
        let all =
            self.followed.into_iter().map(|own| own.nodes).reduce(|all, own| all | own).unwrap_or_default();
        let (mut nodes, explored): (Vec<u32>, Vec<u32>) =
            all.iter_ones().map(|node| node as u32).partition(|&node| graph.is_frontier(node));
        nodes.extend(explored);
        nodes
    }
}

impl Part<'_> {
    /// Follows the choices as far as the nodes are explored. Returns the nodes that are to be explored, or whose next nodes
    /// are to be measured, before the next call; none if the choices end in the part. Cost: linear in the nodes that the choices
    /// reach.
    pub(crate) fn follow(&mut self) -> Vec<u32> {
        self.resize();
        let (waiting, ready): (Vec<_>, Vec<_>) = std::mem::take(&mut self.search.waiting)
            .into_iter()
            .partition(|&(_, node)| self.graph.is_frontier(node));
        self.search.waiting = waiting;
        self.search.open.extend(ready);
        while let Some((quantity, node)) = self.search.open.pop() {
            let Some(choice) = self.pick(quantity, node) else {
                self.search.is_known = false;
                continue;
            };
            let at = self.solved.place(quantity);
            self.search.followed[at].picks.set(choice as usize, true);
            self.graph.edges(choice).for_each(|edge| self.enter_by(quantity, edge));
        }
        if self.search.waiting.is_empty() {
            (0..self.search.followed.len()).for_each(|at| self.turn(at));
        }
        self.search.waiting.iter().map(|&(_, node)| node).collect()
    }

    /// Adds nodes and choices that were explored since.
    fn resize(&mut self) {
        let (nodes, choices) = (self.graph.nodes(), self.graph.choices_in_all());
        for own in &mut self.search.followed {
            own.nodes.resize(nodes, false);
            own.nearest.resize(nodes, false);
            own.picks.resize(choices, false);
        }
    }

    /// Enters some nodes and the ends of their choices with all quantities.
    fn enter_starts(&mut self, starts: &[u32]) {
        let graph = self.graph;
        for at in 0..self.search.followed.len() {
            let quantity = self.search.followed[at].quantity;
            starts.iter().for_each(|&start| self.enter(quantity, start));
            let choices = starts.iter().flat_map(|&start| graph.choices(start));
            choices.flat_map(|choice| graph.edges(choice)).for_each(|edge| self.enter_by(quantity, edge));
        }
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
        let at = self.solved.place(quantity);
        if !self.search.followed[at].nodes.replace(node as usize, true) {
            let is_frontier = self.graph.is_frontier(node);
            let list = if is_frontier { &mut self.search.waiting } else { &mut self.search.open };
            list.push((quantity, node));
        }
    }

    /// Returns the choice of a node that is followed.
    fn pick(&self, quantity: Quantity, node: u32) -> Option<u32> {
        let is_nearest = self.search.followed[self.solved.place(quantity)].nearest[node as usize];
        let best = self.solved.get(quantity).map_or(NONE, |own| own.pick(node));
        if best != NONE && !is_nearest { Some(best) } else { self.nearest(quantity, node) }
    }

    /// Returns the choice of a node that may be the first of the fewest steps to an improvement.
    fn nearest(&self, quantity: Quantity, node: u32) -> Option<u32> {
        let system = System::new(self.graph, quantity, None, &self.solved.fractions);
        let steps = |edge: Edge| if edge.counts() { 0 } else { self.graph.steps(edge.to) };
        let entering = |choice: u32| self.graph.edges(choice).filter(|edge| edge.to != LOST).map(steps).min();
        let choices = self.graph.choices(node).filter(|&choice| system.permits(choice));
        choices.filter_map(|choice| Some((entering(choice)?, choice))).min().map(|(_, choice)| choice)
    }

    /// Turns the nodes from which the choices of a cost never lead to an improvement towards the nearest one.
    fn turn(&mut self, at: usize) {
        let quantity = self.search.followed[at].quantity;
        if !matches!(quantity, Quantity::Cost(_)) {
            return;
        }
        for node in self.lost(at) {
            let own = &mut self.search.followed[at];
            if own.nearest.replace(node as usize, true) {
                self.search.is_known = false;
                continue;
            }
            self.graph.choices(node).for_each(|choice| own.picks.set(choice as usize, false));
            self.search.waiting.push((quantity, node));
        }
    }

    /// Returns the nodes from which the choices of a quantity never lead to an improvement. Cost: n log n for the
    /// nodes that the choices reach.
    fn lost(&self, at: usize) -> Vec<u32> {
        let Followed { nodes, picks, .. } = &self.search.followed[at];
        let (mut left, mut into, mut open) = (nodes.clone(), Vec::new(), Vec::new());
        for node in nodes.iter_ones().map(|node| node as u32) {
            let picked = self.graph.choices(node).filter(|&choice| picks[choice as usize]);
            for edge in picked.flat_map(|choice| self.graph.edges(choice)) {
                if edge.counts() { open.push(node) } else { into.push((edge.to, node)) }
            }
        }
        into.sort_unstable();
        while let Some(node) = open.pop() {
            if left.replace(node as usize, false) {
                let first = into.partition_point(|&(to, _)| to < node);
                open.extend(into[first..].iter().take_while(|&&(to, _)| to == node).map(|&(_, from)| from));
            }
        }
        left.iter_ones().map(|node| node as u32).collect()
    }

    /// Bounds the values of the nodes from the other side, if the choices end in the part. Cost: the solution of the equations
    /// of these choices.
    ///
    /// # Errors
    /// A limit is reached.
    pub(crate) fn judge(&mut self, meter: &mut Meter<'_>) -> Result<()> {
        if !self.search.is_known || !self.search.waiting.is_empty() {
            return Ok(());
        }
        self.solved.add_fractions(self.graph);
        let attained = self.attained(meter)?;
        self.bound(&attained);
        let Search { asked, .. } = &*self.search;
        self.search.is_narrow = asked.iter().all(|&(quantity, node)| self.is_narrow(quantity, node));
        Ok(())
    }

    /// Solves the equations of the choices alone.
    fn attained(&self, meter: &mut Meter<'_>) -> Result<Vec<Solution<Interval>>> {
        let mut found: Vec<Solution<Interval>> = Vec::new();
        for Followed { quantity, nodes, picks, .. } in &self.search.followed {
            let below = self.solved.below(*quantity).map(|at| &found[at]);
            let system = System::new(self.graph, *quantity, below, &self.solved.fractions);
            let system = System { scope: Some(nodes), found: Some(picks), ..system };
            let mut solution = system.start(meter)?;
            system.solve(&mut solution, meter)?;
            found.push(solution);
        }
        Ok(found)
    }

    /// Bounds the values of all nodes from both sides, as far as the choices were followed.
    fn bound(&mut self, attained: &[Solution<Interval>]) {
        let graph = self.graph;
        for (at, Followed { quantity, nodes, .. }) in self.search.followed.iter().enumerate() {
            let own = attained.get(at);
            let most = if quantity.is_probability() { 1.0 } else { f64::INFINITY };
            self.solved.solutions[at].revise(|node, hoped| {
                let own = own.filter(|_| nodes[node as usize]).and_then(|own| own.get(node));
                let is_endless = *quantity == Quantity::Number && graph.rank(node).positive == EVERY;
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
