//! Bounds that one step confirms, with ranks: what a certificate needs.
//!
//! Let B be the operator of the optimality equations. Upper bounds U of probabilities are confirmed
//! by U ≥ B(U), and lower bounds L of costs by L ≤ B(L). Lower bounds of probabilities and upper
//! bounds of costs need L ≤ B(L) or U ≥ B(U) by choices that do not stay forever: such a choice
//! enters a smaller rank with positive probability.
//!
//! In a game, every choice of the opponent must confirm a bound where one of ours suffices, and one where every one of ours
//! must. So bounds are found for one player: lower bounds of probabilities and upper bounds of costs against a strategy of
//! ours that attains the values, the others against a strategy of the opponent that does. A strategy of ours keeps
//! reaching an improvement, whatever the opponent does, so its bounds have ranks.
//!
//! Bounds of a component that is one state are the exact value of its equation, rounded outwards. For other components,
//! the solver finds bounds for the confirmed bounds of what the component reaches, which one step confirms where doubles
//! suffice. Else the exact solution as fractions is tried, up to 100 groups.
//!
//! Bounds that are not confirmed are trivial: 0, 1 or infinite.

use std::collections::VecDeque;

use ahash::AHashSet;
use num_traits::{One, Zero};

use crate::graphs::game_graph::{Edge, LOST};
use crate::graphs::graph::{Graph, NONE};
use crate::graphs::meter::{Meter, Stop};
use crate::solvers::groups::Groups;
use crate::solvers::solution::Solution;
use crate::solvers::system::{Fixed, Quantity, System};
use meliora_base::bound::{Bound, MOST_BITS};
use meliora_base::error::Result;
use meliora_base::exact::Ratio;
use meliora_base::interval::Interval;
use meliora_model::Optimum;

/// The number of groups up to which a component is solved with fractions.
const FEW: usize = 100;

/// The side of a bound.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Side {
    Lower,
    Upper,
}

impl Side {
    /// Returns the bound of this side.
    fn of(self, Interval { lower, upper }: Interval) -> f64 {
        if self == Side::Lower { lower } else { upper }
    }

    /// Returns the side of the bounds that need ranks.
    pub(crate) fn ranked(quantity: Quantity) -> Self {
        if matches!(quantity, Quantity::Probability(_)) { Side::Lower } else { Side::Upper }
    }
}

/// Bounds of one quantity from one side that one step confirms.
#[derive(Debug)]
pub struct Inductive {
    /// The bound of each node.
    pub bounds: Vec<Bound>,
    /// The rank of each node: some choice that confirms its bound enters a smaller one with positive probability.
    pub ranks: Vec<u32>,
    /// The bounds as doubles, rounded outwards.
    rounded: Solution<Interval>,
}

/// The bounds of one quantity from one side that are wanted.
pub(crate) struct Wanted<'a> {
    pub(crate) graph: &'a Graph,
    pub(crate) quantity: Quantity,
    pub(crate) side: Side,
    /// The bounds of the level below.
    pub(crate) below: Option<&'a Inductive>,
    /// The fractions of the graph.
    pub(crate) fractions: &'a [Interval],
    /// True if it must be shown where the probability is 1.
    pub(crate) shows_ones: bool,
    /// In a game, the side whose choices are fixed.
    pub(crate) fixed: Option<&'a Fixed>,
}

impl Wanted<'_> {
    /// Computes the bounds. Cost: that of the solver for components of more than one state, and one
    /// exact step per choice.
    pub(crate) fn find(&self, meter: &mut Meter<'_>) -> Result<Inductive> {
        let system = self.system();
        let rounded = system.start(meter)?;
        let n = self.graph.nodes();
        meter.take(n * (size_of::<Bound>() + 8))?;
        let first = |node: u32| match rounded.get(node) {
            Some(fact) => Bound::Double(fact.lower),
            None => self.nothing(),
        };
        let bounds = (0..n as u32).map(first).collect();
        let mut work = Work { wanted: self, found: Inductive { bounds, ranks: vec![0; n], rounded } };
        let mut position = vec![NONE; n];
        if let Quantity::Probability(k) = self.quantity
            && self.shows_ones
            && self.side == Side::Lower
        {
            let certain = |&node: &u32| self.graph.rank(node).sure >= k;
            let ones: Vec<u32> = (0..n as u32).filter(certain).collect();
            ones.iter().zip(0..).for_each(|(&node, at)| position[node as usize] = at);
            work.rank(&ones, &position);
            ones.iter().for_each(|&node| position[node as usize] = NONE);
        }
        for component in system.components().iter() {
            if !system.is_open(component[0]) {
                continue;
            }
            meter.step()?;
            component.iter().zip(0..).for_each(|(&node, at)| position[node as usize] = at);
            let end = match *component {
                [node] => work.single(node, &position),
                _ => work.component(component, &position, meter),
            };
            component.iter().for_each(|&node| position[node as usize] = NONE);
            end?;
        }
        Ok(work.found)
    }

    fn system(&self) -> System<'_, Interval> {
        let below = self.below.map(|below| &below.rounded);
        System::new(self.graph, self.quantity, below, self.fractions).fixed(self.fixed)
    }

    /// Returns the bound that says nothing.
    fn nothing(&self) -> Bound {
        Bound::Double(match (self.side, self.quantity) {
            (Side::Lower, _) => 0.0,
            (Side::Upper, Quantity::Probability(_)) => 1.0,
            (Side::Upper, _) => f64::INFINITY,
        })
    }

    /// Returns whether bounds need ranks: one choice of ours is enough to confirm them.
    fn is_ranked(&self) -> bool {
        self.side == Side::ranked(self.quantity)
    }

    /// Returns whether one choice of a node is enough to confirm a bound; else every choice must.
    fn one_confirms(&self, node: u32) -> bool {
        self.is_ranked() != self.graph.is_theirs(node)
    }

    /// Rounds a bound outwards; keeps a fraction where a double would be 0, 1 or infinite.
    fn outward(&self, exact: Ratio) -> Bound {
        let near = self.side.of(Interval::around(&exact));
        let says_less = near != 0.0 && near != 1.0 && near.is_finite();
        if says_less { Bound::Double(near) } else { Bound::from(exact) }
    }
}

/// The nodes of a component whose ranks are not known yet.
struct Waiting {
    /// The nodes with choices that enter each node, and these choices.
    into: Vec<Vec<(u32, u32)>>,
    /// The number of choices of each node that must still enter a node with a rank.
    left: Vec<usize>,
    /// The greatest rank that the other choices enter.
    greatest: Vec<u32>,
    /// The choices that enter a rank.
    done: AHashSet<u32>,
}

impl Waiting {
    fn new(nodes: usize) -> Self {
        let (into, left, greatest) = (vec![Vec::new(); nodes], vec![0; nodes], vec![0; nodes]);
        Waiting { into, left, greatest, done: AHashSet::new() }
    }

    /// Notes that a choice of a node enters a rank; returns the greatest rank that its choices enter if all do.
    fn ranked(&mut self, node: usize, choice: u32, rank: u32) -> Option<u32> {
        if !self.done.insert(choice) {
            return None;
        }
        self.left[node] -= 1;
        self.greatest[node] = self.greatest[node].max(rank);
        (self.left[node] == 0).then_some(self.greatest[node])
    }
}

/// Bounds as far as they are known.
struct Work<'w> {
    wanted: &'w Wanted<'w>,
    found: Inductive,
}

impl Work<'_> {
    fn bound(&self, node: u32) -> &Bound {
        &self.found.bounds[node as usize]
    }

    fn set(&mut self, node: u32, bound: Bound) {
        self.found.rounded.store(node, Interval::point(self.wanted.side.of(bound.around())));
        self.found.bounds[node as usize] = bound;
    }

    /// Returns the exact bound at the end of an edge; `None` if it is infinite.
    fn end(&self, edge: Edge) -> Option<Ratio> {
        match (edge.to, edge.counts(), self.wanted.below, self.wanted.quantity) {
            (LOST, ..) => Some(Ratio::zero()),
            (to, true, Some(below), _) => below.bounds[to as usize].exact(),
            (_, true, None, Quantity::Probability(_)) => Some(Ratio::one()),
            (_, true, None, _) => Some(Ratio::zero()),
            (to, false, ..) => self.bound(to).exact(),
        }
    }

    /// Returns the part of a choice's value that does not depend on `own`, and the probability to
    /// enter `own`; `None` if the value is infinite.
    fn parts(&self, choice: u32, own: Option<u32>) -> Option<(Ratio, Ratio)> {
        let graph = self.wanted.graph;
        let cost = matches!(self.wanted.quantity, Quantity::Cost(_)).then(|| graph.cost(choice));
        let mut sum = cost.map_or_else(Ratio::zero, |cost| graph.fractions()[cost as usize].clone());
        let mut back = Ratio::zero();
        for edge in graph.edges(choice) {
            let p = &graph.fractions()[edge.probability() as usize];
            if Some(edge.to) == own && !edge.counts() {
                back += p;
            } else {
                sum += p * self.end(edge)?;
            }
        }
        Some((sum, back))
    }

    /// Returns whether the choice of a node confirms its bound.
    fn confirms(&self, node: u32, choice: u32) -> bool {
        let (value, bound) = (self.parts(choice, None).map(|(sum, _)| sum), self.bound(node).exact());
        match (self.wanted.side, value, bound) {
            (Side::Lower, Some(value), Some(bound)) => bound <= value,
            (Side::Upper, Some(value), Some(bound)) => bound >= value,
            (Side::Lower, None, _) | (Side::Upper, _, None) => true,
            (Side::Lower, _, None) | (Side::Upper, None, _) => false,
        }
    }

    /// Returns whether all bounds of a component are confirmed by one step.
    fn holds(&self, nodes: &[u32]) -> bool {
        let system = self.wanted.system();
        nodes.iter().all(|&node| {
            let mut permitted = self.wanted.graph.choices(node).filter(|&choice| system.permits(choice));
            match self.wanted.one_confirms(node) {
                _ if *self.bound(node) == self.wanted.nothing() => true,
                true => permitted.any(|choice| self.confirms(node, choice)),
                false => permitted.all(|choice| self.confirms(node, choice)),
            }
        })
    }

    /// Returns the rank of an edge: 0 where the bound is given; `None` if it is not known yet.
    fn rank_of(&self, edge: Edge) -> Option<u32> {
        let given = edge.to == LOST || edge.counts() || {
            let rank = self.wanted.graph.rank(edge.to);
            let is_fact = match self.wanted.quantity {
                Quantity::Probability(k) => rank.positive < k || rank.sure >= k && !self.wanted.shows_ones,
                _ => false,
            };
            is_fact || *self.bound(edge.to) == self.wanted.nothing()
        };
        if given {
            return Some(0);
        }
        Some(self.found.ranks[edge.to as usize]).filter(|&rank| rank > 0)
    }

    /// Returns the choices of a node that may justify its rank. A junction takes the better of its
    /// two choices, and counts if they are equal.
    fn justifying(&self, node: u32) -> Vec<u32> {
        let (graph, system) = (self.wanted.graph, self.wanted.system());
        let permitted = graph.choices(node).filter(|&choice| system.follows(node, choice));
        if !graph.is_junction(node) {
            return permitted.filter(|&choice| self.confirms(node, choice)).collect();
        }
        let value = |choice: u32| self.parts(choice, None).map(|(sum, _)| sum);
        let better = |a: u32, b: u32| {
            let is_better = match (self.wanted.side, value(a), value(b)) {
                (Side::Lower, Some(a), Some(b)) => a >= b,
                (Side::Upper, Some(a), Some(b)) => a <= b,
                (_, a, _) => a.is_some(),
            };
            if is_better { a } else { b }
        };
        permitted.reduce(better).into_iter().collect()
    }

    /// Ranks the nodes of a component; returns whether each that says something has a rank.
    fn rank(&mut self, nodes: &[u32], position: &[u32]) -> bool {
        if !self.wanted.is_ranked() {
            return true;
        }
        let nothing = self.wanted.nothing();
        let mut waiting = Waiting::new(nodes.len());
        let mut queue = VecDeque::new();
        nodes.iter().for_each(|&node| self.found.ranks[node as usize] = 0);
        for (index, &node) in nodes.iter().enumerate() {
            if *self.bound(node) == nothing {
                continue;
            }
            if let Some(rank) = self.first_rank(node, index, position, &mut waiting) {
                self.found.ranks[node as usize] = rank + 1;
                queue.push_back(index);
            }
        }
        while let Some(index) = queue.pop_front() {
            let rank = self.found.ranks[nodes[index] as usize];
            for (before, choice) in std::mem::take(&mut waiting.into[index]) {
                let node = nodes[before as usize] as usize;
                if self.found.ranks[node] > 0 {
                    continue;
                }
                if let Some(rank) = waiting.ranked(before as usize, choice, rank) {
                    self.found.ranks[node] = rank + 1;
                    queue.push_back(before as usize);
                }
            }
        }
        nodes.iter().all(|&node| self.found.ranks[node as usize] > 0 || *self.bound(node) == nothing)
    }

    /// Returns the rank that a node enters, if it is known: the least one of a choice of ours, the greatest one of the
    /// opponent's choices. Else the node waits for those that its choices enter.
    fn first_rank(&self, node: u32, index: usize, position: &[u32], waiting: &mut Waiting) -> Option<u32> {
        let (one, justifying) = (self.wanted.one_confirms(node), self.justifying(node));
        let mut known = Vec::new();
        for &choice in &justifying {
            let mut least: Option<u32> = None;
            for edge in self.wanted.graph.edges(choice) {
                match self.rank_of(edge) {
                    Some(rank) => least = Some(least.map_or(rank, |least| least.min(rank))),
                    None => waiting.into[position[edge.to as usize] as usize].push((index as u32, choice)),
                }
            }
            known.extend(least.map(|rank| (choice, rank)));
        }
        let ranks = known.iter().map(|&(_, rank)| rank);
        if one {
            waiting.left[index] = 1;
            return ranks.min();
        }
        let greatest = ranks.max();
        waiting.left[index] = justifying.len() - known.len();
        waiting.greatest[index] = greatest.unwrap_or(0);
        waiting.done.extend(known.iter().map(|&(choice, _)| choice));
        greatest.filter(|_| waiting.left[index] == 0)
    }

    /// Finds the bound of a node that is a component of its own.
    fn single(&mut self, node: u32, position: &[u32]) -> Result<()> {
        let (wanted, system) = (self.wanted, self.wanted.system());
        let (mut best, mut is_finite): (Option<Ratio>, _) = (None, true);
        let optimum = system.optimum(node);
        for choice in wanted.graph.choices(node).filter(|&choice| system.permits(choice)) {
            let Some((sum, back)) = self.parts(choice, Some(node)) else {
                // An upper bound of the greatest value is infinite, then; others have other choices.
                is_finite &= optimum == Optimum::Min;
                continue;
            };
            if back.is_one() {
                continue;
            }
            let value = sum / (Ratio::one() - back);
            best = Some(match (best, optimum) {
                (None, _) => value,
                (Some(best), Optimum::Max) => best.max(value),
                (Some(best), Optimum::Min) => best.min(value),
            });
        }
        let bound = best.filter(|_| is_finite).map_or_else(|| wanted.nothing(), |x| wanted.outward(x));
        self.set(node, bound);
        self.found.rounded.know(node, true);
        if !self.holds(&[node]) || !self.rank(&[node], position) {
            self.set(node, wanted.nothing());
        }
        Ok(())
    }

    /// Finds the bounds of a component: those of the solver for the confirmed bounds of what the component reaches, or
    /// fractions.
    fn component(&mut self, nodes: &[u32], position: &[u32], meter: &mut Meter<'_>) -> Result<()> {
        let known = |work: &mut Self, known: bool| {
            nodes.iter().for_each(|&node| work.found.rounded.know(node, known));
        };
        known(self, false);
        let (wanted, system) = (self.wanted, self.wanted.system());
        system.component(nodes, position, &mut self.found.rounded, meter)?;
        let solved = |&node: &u32| Bound::Double(wanted.side.of(*self.found.rounded.stored(node)));
        let solved: Vec<Bound> = nodes.iter().map(solved).collect();
        if !self.are_bounds(nodes, position, &solved) {
            known(self, false);
            let exact = self.exact(nodes, position, meter)?;
            if !exact.is_some_and(|exact| self.are_bounds(nodes, position, &exact)) {
                self.are_bounds(nodes, position, &vec![wanted.nothing(); nodes.len()]);
            }
        }
        known(self, true);
        Ok(())
    }

    /// Sets the bounds of a component; returns whether they are confirmed.
    fn are_bounds(&mut self, nodes: &[u32], position: &[u32], found: &[Bound]) -> bool {
        nodes.iter().zip(found).for_each(|(&node, bound)| self.set(node, bound.clone()));
        self.holds(nodes) && self.rank(nodes, position)
    }

    /// Returns the exact bounds of a component, if it is small.
    fn exact(&self, nodes: &[u32], position: &[u32], meter: &mut Meter<'_>) -> Result<Option<Vec<Bound>>> {
        let (wanted, system) = (self.wanted, self.wanted.system());
        let groups = Groups::new(&system, nodes, position, meter)?;
        if groups.count() > FEW {
            return Ok(None);
        }
        let found = match system.fractions_of(&groups, &self.found.rounded, &[], usize::MAX, meter) {
            Ok(found) => found,
            Err(Stop::Limit(error)) => return Err(error),
            Err(_) => return Ok(None),
        };
        let values = if wanted.side == Side::Lower { &found.low } else { &found.high };
        let value = |&node: &u32| {
            let mut exact = values[groups.group_of(node)? as usize].clone();
            if let Quantity::Probability(_) = wanted.quantity {
                exact = exact.min(Ratio::one());
            }
            let is_short = exact.numer().bits().max(exact.denom().bits()) <= MOST_BITS;
            is_short.then(|| Bound::from(exact))
        };
        Ok(nodes.iter().map(value).collect())
    }
}
