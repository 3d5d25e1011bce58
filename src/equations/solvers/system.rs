//! The equations of a game: which nodes have one, and the value of each choice. A model without an opponent is a game in
//! which all states look for the same extreme.
//!
//! A level of improvements is a system whose counted edges have the known values of the level below.

use std::fmt;

use bitvec::vec::BitVec;

use crate::graphs::game_graph::{Edge, Extremes, GameGraph, LOST, Rewards};
use crate::graphs::graph::{Graph, Rank};
use crate::graphs::meter::Meter;
use crate::graphs::narrow::Narrow;
use crate::solvers::solution::{Members, Rest, Solution};
use meliora_base::error::{Limit, Result};
use meliora_base::exact::Ratio;
use meliora_base::interval::Interval;
use meliora_base::number::Number;
use meliora_model::Optimum;

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
pub enum Quantity {
    /// P_k
    Probability(u32),
    /// C_k, or a cost until a target that is to be reached almost surely.
    Cost(u32),
    /// N
    Number,
    /// The costs of all steps.
    Reward,
    /// T_k, the least expected number of steps by candidates; see [`Quantities::decide_ties`](crate::Quantities::decide_ties)
    Steps(u32),
}

impl Quantity {
    /// Returns the extreme of the side that *leads*: the one that has to leave a component for it. Nothing is gained by
    /// staying in one; a target that is never reached costs infinitely much.
    pub(crate) fn leader(self) -> Optimum {
        match self {
            Quantity::Cost(_) | Quantity::Steps(_) => Optimum::Min,
            Quantity::Probability(_) | Quantity::Number | Quantity::Reward => Optimum::Max,
        }
    }

    /// Returns the quantity that counts after an edge.
    pub(crate) fn after(self, edge: Edge) -> Self {
        let less = u32::from(edge.counts());
        match self {
            Quantity::Probability(k) => Quantity::Probability(k - less),
            Quantity::Cost(k) => Quantity::Cost(k - less),
            other => other,
        }
    }

    /// Returns whether the value of a node follows from its rank, or there is none.
    pub(crate) fn follows_from(self, rank: Rank) -> bool {
        match self {
            Quantity::Probability(k) => rank.positive < k || rank.sure >= k,
            Quantity::Cost(k) => k == 0 || rank.sure < k,
            _ => rank.positive == 0,
        }
    }

    /// Returns whether this is a probability: at most 1.
    pub(crate) fn is_probability(self) -> bool {
        matches!(self, Quantity::Probability(_))
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
}

/// A side of a game whose choices are fixed: the equations are those of the other side.
#[derive(Debug)]
pub(crate) struct Fixed {
    /// The choices that may be taken, by their numbers in the graph.
    pub(crate) choices: BitVec,
    /// The extreme that the other side wants.
    pub(crate) optimum: Optimum,
}

/// The nodes that have equations, the nodes with the value 1, and the choices that may be taken.
#[derive(Debug)]
pub(crate) struct Sets {
    pub(crate) open: BitVec,
    pub(crate) ones: BitVec,
    pub(crate) permitted: BitVec,
}

/// The nodes that have equations.
#[derive(Clone, Copy)]
pub(crate) enum Domain<'a> {
    /// By the ranks of a graph.
    Ranks(&'a Graph),
    Sets(&'a Sets),
}

/// The numbers of what choices gain or pay, and these amounts.
#[derive(Clone, Copy)]
pub(crate) struct Gains<'a, N> {
    numbers: Option<&'a Narrow>,
    exact: &'a [Ratio],
    values: &'a [N],
}

/// A system of equations.
pub(crate) struct System<'a, N> {
    pub(crate) game: &'a GameGraph,
    pub(crate) quantity: Quantity,
    pub(crate) goal: Extremes,
    pub(crate) domain: Domain<'a>,
    pub(crate) gains: Gains<'a, N>,
    /// The values at the ends of counted edges, if known: those of the level below.
    pub(crate) below: Option<&'a Solution<N>>,
    /// The values of the nodes that have no equation, if they are more than 0 and 1.
    pub(crate) closed: Option<&'a Solution<N>>,
    /// The fractions of the graph as numbers.
    pub(crate) fractions: &'a [N],
    /// The only method to use, for tests.
    pub(crate) only: Option<Method>,
    /// The choices that may be taken, if not all; for steps also their costs.
    pub(crate) candidates: Option<&'a Candidates>,
    /// The side of a game that does not choose any more.
    pub(crate) fixed: Option<&'a Fixed>,
    /// The choices of open nodes that may be taken, once they are found.
    pub(crate) found: Option<&'a BitVec>,
    /// The nodes that alone have equations, if not all.
    pub(crate) scope: Option<&'a BitVec>,
    pub(crate) one: N,
}

/// The value at the end of an edge.
pub(crate) enum End<'s, N> {
    /// The unknown of a node.
    Open(u32),
    /// A known value; 0 where there is none.
    Known(Option<&'s N>),
}

impl<'a, N: Number> System<'a, N> {
    /// Creates the system of a quantity of a graph, with the solution of the level below. Of expected numbers, this is P_1
    /// if it is known to be N where at most one improvement is possible.
    pub(crate) fn new(
        graph: &'a Graph,
        quantity: Quantity,
        below: Option<&'a Solution<N>>,
        fractions: &'a [N],
    ) -> Self {
        let has_costs = matches!(quantity, Quantity::Cost(_) | Quantity::Reward);
        let numbers = has_costs.then_some(&graph.costs);
        let (below, closed) = if quantity == Quantity::Number { (None, below) } else { (below, None) };
        let gains = Gains { numbers, exact: graph.fractions(), values: fractions };
        let asked = (quantity, Extremes::against(quantity.leader()));
        System { below, closed, ..System::of(graph, Domain::Ranks(graph), asked, gains, fractions) }
    }

    /// Creates a system without values of other nodes.
    fn of(
        game: &'a GameGraph,
        domain: Domain<'a>,
        (quantity, goal): (Quantity, Extremes),
        gains: Gains<'a, N>,
        fractions: &'a [N],
    ) -> Self {
        System {
            game,
            quantity,
            goal,
            domain,
            gains,
            below: None,
            closed: None,
            fractions,
            only: None,
            candidates: None,
            fixed: None,
            found: None,
            scope: None,
            one: N::one(),
        }
    }

    /// Creates the system of some nodes of a game, whose edges are not counted. `fractions` are those of the game, and
    /// `gains` those of rewards as numbers.
    pub(crate) fn of_sets(
        (game, sets): (&'a GameGraph, &'a Sets),
        asked: (Quantity, Extremes),
        rewards: Option<(&'a Rewards, &'a [N])>,
        fractions: &'a [N],
    ) -> Self {
        let gains = match rewards {
            Some((own, values)) => {
                Gains { numbers: Some(&own.of_choice), exact: own.fractions.list(), values }
            }
            None => Gains { numbers: None, exact: &[], values: &[] },
        };
        System::of(game, Domain::Sets(sets), asked, gains, fractions)
    }

    /// Returns the choices of open nodes that may be taken. Cost: linear.
    pub(crate) fn permitted(&self) -> BitVec {
        let mut permitted = BitVec::repeat(false, self.game.choices_in_all());
        for node in (0..self.game.states() as u32).filter(|&node| self.is_open(node)) {
            self.game.choices(node).for_each(|choice| permitted.set(choice as usize, self.permits(choice)));
        }
        permitted
    }

    /// Returns the same system, which looks up [`System::permitted`] choices.
    pub(crate) fn with_found<'b>(&'b self, found: &'b BitVec) -> System<'b, N> {
        System { gains: Gains { ..self.gains }, found: Some(found), one: self.one.clone(), ..*self }
    }

    /// Fixes the choices of a side.
    pub(crate) fn fixed(mut self, fixed: Option<&'a Fixed>) -> Self {
        if let Some(Fixed { optimum, .. }) = fixed {
            self.goal = Extremes::all(*optimum);
        }
        self.fixed = fixed;
        self
    }

    /// Returns the extreme that a node looks for.
    pub(crate) fn optimum(&self, node: u32) -> Optimum {
        match self.goal.ours == self.goal.theirs || !self.game.is_theirs(node) {
            true => self.goal.ours,
            false => self.goal.theirs,
        }
    }

    /// Returns whether a node is one of the leading side; see [`Quantity::leader`].
    pub(crate) fn leads(&self, node: u32) -> bool {
        self.optimum(node) == self.quantity.leader()
    }

    /// Returns whether a node has an equation: for others, the value follows from the rank, or there
    /// is none.
    pub(crate) fn is_open(&self, node: u32) -> bool {
        match self.domain {
            Domain::Sets(sets) => sets.open[node as usize],
            Domain::Ranks(graph) => self.opens(graph.rank(node)) && self.has(graph, node),
        }
    }

    /// Returns whether the equation of a node is known and in the scope.
    fn has(&self, graph: &Graph, node: u32) -> bool {
        !graph.is_frontier(node) && self.scope.is_none_or(|scope| scope[node as usize])
    }

    /// Returns whether nodes of a rank have equations.
    fn opens(&self, rank: Rank) -> bool {
        match self.quantity {
            Quantity::Probability(_) => !self.quantity.follows_from(rank),
            Quantity::Number => rank.positive > u32::from(self.closed.is_some()),
            Quantity::Cost(k) => rank.sure >= k,
            Quantity::Reward => rank.sure > 0,
            Quantity::Steps(k) => rank.positive >= k,
        }
    }

    /// Returns whether a choice may be taken: one of the candidates, if there are some; else one of a side that is not
    /// fixed, or that this side takes, and for costs one with which the improvements stay certain.
    pub(crate) fn permits(&self, choice: u32) -> bool {
        if let Some(found) = self.found {
            return found[choice as usize];
        }
        if let Some(candidates) = self.candidates {
            return candidates.choices[choice as usize];
        }
        self.fixed.is_none_or(|fixed| fixed.choices[choice as usize]) && self.keeps_certain(choice)
    }

    /// Returns whether a component follows a choice of a node: one that may be taken. At a junction, ranks depend on both
    /// choices, whichever is fixed.
    pub(crate) fn follows(&self, node: u32, choice: u32) -> bool {
        let is_junction = matches!(self.domain, Domain::Ranks(graph) if graph.is_junction(node));
        let is_free = self.fixed.is_some() && is_junction && self.keeps_certain(choice);
        is_free || self.permits(choice)
    }

    /// Returns whether the improvements stay certain with a choice, if they must.
    fn keeps_certain(&self, choice: u32) -> bool {
        let (graph, k) = match (&self.domain, self.quantity) {
            (Domain::Sets(sets), _) => return sets.permitted[choice as usize],
            (Domain::Ranks(graph), Quantity::Cost(k)) => (graph, k),
            _ => return true,
        };
        let certain =
            |edge: Edge| edge.to != LOST && graph.rank(edge.to).sure >= k - u32::from(edge.counts());
        graph.edges(choice).all(certain)
    }

    /// Returns the value at the end of an edge.
    pub(crate) fn end<'s>(&'s self, edge: Edge, solution: &'s Solution<N>) -> End<'s, N> {
        if edge.to == LOST {
            return End::Known(None);
        }
        if let Domain::Ranks(graph) = self.domain
            && graph.is_frontier(edge.to)
        {
            return End::Known(self.hoped(graph, edge));
        }
        if edge.counts() && self.quantity != Quantity::Number {
            return End::Known(match (self.below, self.quantity) {
                (Some(below), _) => below.get(edge.to),
                (None, Quantity::Probability(_)) => Some(&self.one),
                (None, _) => None,
            });
        }
        let solution = match self.closed {
            Some(closed) if !self.is_open(edge.to) => closed,
            _ => solution,
        };
        match solution.get(edge.to) {
            Some(value) => End::Known(Some(value)),
            None => End::Open(edge.to),
        }
    }

    /// Returns the best value that the rank of an unexplored node allows.
    fn hoped(&self, graph: &Graph, edge: Edge) -> Option<&N> {
        let positive = graph.rank(edge.to).positive;
        match self.quantity.after(edge) {
            Quantity::Probability(k) => (positive >= k).then_some(&self.one),
            Quantity::Number => self.fractions.get(graph.most_improvements(edge.to) as usize),
            Quantity::Cost(k) if k > 0 => self.fractions.get(graph.least_cost(edge.to) as usize),
            Quantity::Cost(_) | Quantity::Reward | Quantity::Steps(_) => None,
        }
    }

    /// Returns the number of the gain of a choice; `None` if the quantity has no costs.
    fn gain_number(&self, choice: u32) -> Option<usize> {
        if let (Quantity::Steps(_), Some(candidates)) = (self.quantity, self.candidates) {
            return Some(candidates.costs[usize::from(!candidates.free[choice as usize])] as usize);
        }
        self.gains.numbers.map(|numbers| numbers.get(choice as usize) as usize)
    }

    /// Returns what a choice gains or pays, whatever follows; `None` if the quantity has no costs.
    pub(crate) fn gain(&self, choice: u32) -> Option<&N> {
        self.gain_number(choice).map(|number| &self.gains.values[number])
    }

    /// Does the same as [`System::gain`] with fractions.
    pub(crate) fn exact_gain(&self, choice: u32) -> Option<&Ratio> {
        self.gain_number(choice).map(|number| &self.gains.exact[number])
    }

    /// Returns an edge's constant for the expected number: 1 for an improvement.
    pub(crate) fn bonus(&self, edge: Edge) -> bool {
        self.quantity == Quantity::Number && edge.counts()
    }

    /// Returns the value of a choice under a solution; `None` if it is not permitted or a successor
    /// is not known.
    pub(crate) fn value(&self, choice: u32, solution: &Solution<N>) -> Option<N> {
        let (sum, _, is_known) = self.parts(choice, solution)?;
        is_known.then_some(sum)
    }

    /// Returns the value of a choice without the successors that are not known, the probability of the others, and whether
    /// these are all; `None` if it is not permitted.
    #[inline]
    pub(crate) fn parts(&self, choice: u32, solution: &Solution<N>) -> Option<(N, N, bool)> {
        if !self.permits(choice) {
            return None;
        }
        let (mut sum, mut known, mut whole) =
            (self.gain(choice).cloned().unwrap_or_else(N::zero), N::zero(), true);
        for edge in self.game.edges(choice) {
            let p = &self.fractions[edge.probability() as usize];
            if self.bonus(edge) {
                sum = sum.plus(p);
            }
            match self.end(edge, solution) {
                End::Known(value) => {
                    if let Some(value) = value {
                        sum = sum.plus(&p.times(value));
                    }
                    known = known.plus(p);
                }
                End::Open(_) => whole = false,
            }
        }
        Some((sum, known, whole))
    }

    /// Creates a solution that contains only the facts.
    pub(crate) fn start(&self, meter: &mut Meter<'_>) -> Result<Solution<N>> {
        let nodes = self.game.states();
        match self.domain {
            Domain::Sets(sets) => {
                let rest = Rest::ones(Members::new(nodes, |node| sets.ones[node as usize]));
                Solution::new(Members::new(nodes, |node| sets.open[node as usize]), rest, meter)
            }
            Domain::Ranks(graph) => {
                // Most levels of a large graph have few ranks.
                let of_rank = |is_such: &dyn Fn(Rank) -> bool| match graph.has_rank(is_such) {
                    true => Members::new(nodes, |node| is_such(graph.rank(node))),
                    false => Members::none(nodes),
                };
                let rest = match self.quantity {
                    Quantity::Cost(_) | Quantity::Reward => Rest::Unknown,
                    Quantity::Probability(k) => Rest::ones(of_rank(&|rank| rank.sure >= k)),
                    Quantity::Number | Quantity::Steps(_) => Rest::ones(Members::none(nodes)),
                };
                let open = match graph.has_rank(|rank| self.opens(rank)) {
                    true => Members::new(nodes, |node| self.is_open(node)),
                    false => Members::none(nodes),
                };
                Solution::new(open, rest, meter)
            }
        }
    }

    /// Returns the greatest value of a node of which nothing is known.
    pub(crate) fn most(&self) -> f64 {
        if self.quantity.is_probability() { 1.0 } else { f64::INFINITY }
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
