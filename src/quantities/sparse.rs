//! A component in compressed rows of doubles, and its optimality equations rounded outwards.
//!
//! The result of a row with m edges is computed to the nearest and then moved outwards by
//! (m + 8) · 2^-52 of it: all terms are at least 0, so this covers the rounding of probabilities,
//! products and sums.
//!
//! An upper bound has another limit. The result of a row in which nothing is gained or paid is a mean
//! of the values that it leads to, so it is at most the greatest of them, without any rounding. This
//! matters where many policies are equally good and some of them hardly leave the component: along
//! their cycles the rounding of each row adds up, and exceeds what the exits take away.

use std::ops::Range;

use super::component::Sense;
use super::groups::{AsIntervals, Equation, Groups};
use super::meter::Meter;
use super::narrow::{Digits, Narrow};
use super::number::{Interval, Number, Weight};
use super::repeated::Repeated;
use super::solution::Solution;
use super::solve::NONE;
use super::system::System;
use meliora_model::error::Result;

/// The smallest relative improvement for which a policy is changed: more than the error of elimination
/// in most components. If it is not, the policy changes without end and is given up.
const BETTER: f64 = 1e-12;

/// Results below this may have lost digits.
pub(super) const TINY: f64 = 1e-280;

/// A component in compressed rows. Few probabilities and constants are different, so they are stored
/// once.
#[derive(Debug)]
pub(super) struct Sparse {
    pub(super) sense: Sense,
    /// The actions of group g are `first[g]..first[g+1]`.
    first: Vec<u32>,
    /// The first edge of each group, and the number of edges of each action.
    first_edge: Vec<u32>,
    edges: Narrow,
    /// The group that each edge enters, and its probability.
    to: Vec<u32>,
    probabilities: Repeated<1>,
    /// The bounds of the constant of each action, the greatest upper bound at an exit, which is infinite
    /// if more is gained or paid, and the probability to leave the component.
    constants: Repeated<4>,
    /// The choice of each action.
    pub(super) choices: Vec<u32>,
    /// The relative error of a row.
    pub(super) error: f64,
    /// The width of the bounds at the exits.
    pub(super) inherited: f64,
    /// The smallest probability.
    pub(super) least: f64,
}

impl Sparse {
    /// Creates a component without groups.
    pub(super) fn empty(sense: Sense) -> Self {
        Sparse {
            sense,
            first: vec![0],
            first_edge: vec![0],
            edges: Narrow::default(),
            to: Vec::new(),
            probabilities: Repeated::default(),
            constants: Repeated::default(),
            choices: Vec::new(),
            error: 0.0,
            inherited: 0.0,
            least: 1.0,
        }
    }

    /// Copies the rows of a component, divided by the probabilities to leave the groups.
    pub(super) fn new<N: Number>(
        system: &System<'_, N>,
        groups: &Groups<'_>,
        solution: &Solution<N>,
        meter: &mut Meter<'_>,
    ) -> Result<Self> {
        let (mut sparse, mut equation) = (Sparse::empty(system.sense()), Equation::empty());
        groups.visit(system, meter, |group, node, choice, _| {
            sparse.begin(group);
            groups.write::<N, AsIntervals>(system, (group, node, choice), solution, &mut equation);
            sparse.add(choice, &equation);
            Ok(())
        })?;
        sparse.begin(groups.count() as u32);
        Ok(sparse)
    }

    /// Ends the groups before a group.
    pub(super) fn begin(&mut self, group: u32) {
        self.first.resize(group as usize + 1, self.choices.len() as u32);
        self.first_edge.resize(group as usize + 1, self.to.len() as u32);
    }

    /// Adds an action to the last group: its choice, its edges, and the bounds of its constant with the
    /// greatest upper bound at an exit and the probability to leave the component.
    pub(super) fn push(
        &mut self,
        choice: u32,
        edges: impl ExactSizeIterator<Item = (u32, f64)>,
        constant: [f64; 4],
    ) {
        self.edges.push(edges.len() as u32);
        for (to, p) in edges {
            self.to.push(to);
            self.probabilities.push([p]);
        }
        self.constants.push(constant);
        self.choices.push(choice);
    }

    /// Returns whether the constants have no width.
    pub(super) fn is_exact(&self) -> bool {
        self.constants.distinct().iter().all(|[low, high, ..]| low == high)
    }

    /// Adds the equation of a choice to the last group, unless the choice never leaves its group.
    fn add(&mut self, choice: u32, equation: &Equation<Interval>) {
        let &Equation { ref row, high, whole, most, width } = equation;
        let leaving = if whole { Interval::ONE } else { row.leaving() };
        self.inherited = self.inherited.max(width);
        if leaving.is_zero() {
            return;
        }
        let parts = row.edges.iter().map(|edge| &edge.1).chain([&row.escape]);
        self.least = parts.filter(|p| !p.is_zero()).fold(self.least, |least, p| least.min(p.lower));
        let mut constant = Interval { lower: row.constant.lower, upper: high.upper };
        let mut error = (row.edges.len() + 8) as f64 * f64::EPSILON;
        let mut divisor = 1.0;
        if !whole {
            constant = constant.over(&leaving);
            // The quotients are within the width of the divisor.
            error += 4.0 * (leaving.upper / leaving.lower - 1.0);
            divisor = leaving.lower;
        }
        self.error = self.error.max(error);
        let edges = row.edges.iter().map(|(to, p)| (*to, p.lower / divisor));
        self.push(choice, edges, [constant.lower, constant.upper, most, row.escape.lower / divisor]);
    }

    /// Returns the bytes of the rows, and of the iteration over them.
    pub(super) fn bytes(&self) -> usize {
        4 * (2 * self.first.len() + self.to.len() + self.choices.len())
            + self.choices.len() * self.edges.width()
            + self.probabilities.bytes()
            + self.constants.bytes()
            + 32 * self.first.len()
    }

    pub(super) fn groups(&self) -> usize {
        self.first.len() - 1
    }

    /// Returns the actions of a group, each with its edges.
    pub(super) fn actions(&self, group: usize) -> impl Iterator<Item = (usize, Range<usize>)> {
        let actions = self.first[group] as usize..self.first[group + 1] as usize;
        let mut next = self.first_edge[group] as usize;
        actions.map(move |action| {
            let start = next;
            next += self.edges.get(action) as usize;
            (action, start..next)
        })
    }

    /// Returns the edges of an action of a group.
    pub(super) fn edges(&self, group: usize, action: usize) -> Range<usize> {
        let mut actions = self.actions(group);
        actions.find(|(other, _)| *other == action).map_or(0..0, |(_, edges)| edges)
    }

    /// Returns the bounds of the constant of an action, and the probability to leave the component.
    pub(super) fn constant(&self, action: usize) -> ([f64; 2], f64) {
        let &[low, high, _, escape] = self.constants.get(action);
        ([low, high], escape)
    }

    /// Returns the groups that edges enter, and their probabilities.
    pub(super) fn row(&self, edges: Range<usize>) -> impl Iterator<Item = (u32, f64)> {
        edges.map(|edge| (self.to[edge], self.probabilities.get(edge)[0]))
    }

    /// Returns an action of each group, so that the component is left almost surely: each leads out, or to a group that
    /// got its action before. `None` if there are no such actions. Cost: some sweeps, each over the groups that are
    /// left, by turns in both directions.
    ///
    /// # Errors
    /// The work is cancelled.
    pub(super) fn leaving_policy(&self, meter: &mut Meter<'_>) -> Result<Option<Vec<u32>>> {
        let mut policy = vec![NONE; self.groups()];
        let mut open: Vec<u32> = (0..self.groups() as u32).collect();
        while !open.is_empty() {
            let before = open.len();
            let mut end = Ok(());
            open.retain(|&group| {
                if end.is_ok() {
                    end = meter.step();
                }
                let leaves = |(_, edges): &(usize, Range<usize>)| {
                    self.row(edges.clone()).any(|(to, _)| policy[to as usize] != NONE)
                };
                let leaving = |&(action, _): &(usize, Range<usize>)| self.constant(action).1 > 0.0;
                let found = self.actions(group as usize).find(|action| leaving(action) || leaves(action));
                policy[group as usize] = found.map_or(NONE, |(action, _)| action as u32);
                policy[group as usize] == NONE
            });
            end?;
            if open.len() == before {
                return Ok(None);
            }
            open.reverse();
        }
        Ok(Some(policy))
    }

    /// Returns a lower bound of c + Σ p · x of an action, which has the given edges.
    pub(super) fn below(&self, action: usize, edges: Range<usize>, x: &[f64]) -> f64 {
        self.lowered(self.sum(action, edges, false, x))
    }

    /// Returns c + Σ p · x of an action, which has the given edges, to the nearest double, with the lower or
    /// upper bound of the constant.
    pub(super) fn sum(&self, action: usize, edges: Range<usize>, upper: bool, x: &[f64]) -> f64 {
        let constant = self.constants.get(action)[usize::from(upper)];
        self.row(edges).fold(constant, |sum, (to, p)| sum + p * x[to as usize])
    }

    /// Returns whether a value is clearly better than another one.
    pub(super) fn is_better(&self, q: f64, than: f64) -> bool {
        match self.sense {
            Sense::Max => q > than * (1.0 + BETTER),
            Sense::Min => q < than * (1.0 - BETTER),
        }
    }

    /// Returns an upper bound of c + Σ p · x of an action, which has the given edges.
    fn above(&self, action: usize, edges: Range<usize>, x: &[f64]) -> f64 {
        let add = |(sum, most): (f64, f64), (to, p): (u32, f64)| {
            let x = x[to as usize];
            (sum + p * x, most.max(x))
        };
        let &[_, constant, exit, _] = self.constants.get(action);
        let (sum, most) = self.row(edges).fold((constant, exit), add);
        (sum * (1.0 + self.error) + TINY).min(most)
    }

    /// Returns a lower or upper bound of the optimum of a group, and the action that attains it.
    pub(super) fn best(&self, group: usize, upper: bool, x: &[f64]) -> (f64, usize) {
        let mut best = self.worst(group);
        for (action, edges) in self.actions(group) {
            let q = if upper { self.above(action, edges, x) } else { self.sum(action, edges, false, x) };
            self.choose(&mut best, (q, action));
        }
        if upper { best } else { (self.lowered(best.0), best.1) }
    }

    fn worst(&self, group: usize) -> (f64, usize) {
        let value = if self.sense == Sense::Max { 0.0 } else { f64::INFINITY };
        (value, self.first[group] as usize)
    }

    #[inline]
    fn choose(&self, best: &mut (f64, usize), other: (f64, usize)) {
        let better = match self.sense {
            Sense::Max => other.0 > best.0,
            Sense::Min => other.0 < best.0,
        };
        if better {
            *best = other;
        }
    }

    #[inline]
    fn lowered(&self, sum: f64) -> f64 {
        if sum < TINY { 0.0 } else { sum * (1.0 - self.error) }
    }

    /// Visits all groups in their order. `visit` gets the value of a group in `x`, and what
    /// [`Sparse::best`] returns for it; it may change the value, which the next groups see.
    ///
    /// # Errors
    /// The work is cancelled.
    pub(super) fn sweep(
        &self,
        upper: bool,
        x: &mut [f64],
        meter: &mut Meter<'_>,
        visit: impl FnMut(usize, &mut f64, (f64, usize)),
    ) -> Result<()> {
        match (self.probabilities.numbers(), upper) {
            (Narrow::Bytes(list), true) => self.visit::<_, true>(list, x, meter, visit),
            (Narrow::Bytes(list), false) => self.visit::<_, false>(list, x, meter, visit),
            (Narrow::Shorts(list), true) => self.visit::<_, true>(list, x, meter, visit),
            (Narrow::Shorts(list), false) => self.visit::<_, false>(list, x, meter, visit),
            (Narrow::Words(list), true) => self.visit::<_, true>(list, x, meter, visit),
            (Narrow::Words(list), false) => self.visit::<_, false>(list, x, meter, visit),
        }
    }

    /// Does the same for lists of numbers of probabilities of one width, which are read in a loop without
    /// branches.
    fn visit<D: Digits, const UPPER: bool>(
        &self,
        numbers: &[D],
        x: &mut [f64],
        meter: &mut Meter<'_>,
        mut visit: impl FnMut(usize, &mut f64, (f64, usize)),
    ) -> Result<()> {
        let distinct = self.probabilities.distinct();
        let mut rest = self.to.iter().zip(numbers);
        for group in 0..x.len() {
            meter.step()?;
            let mut best = self.worst(group);
            for action in self.first[group] as usize..self.first[group + 1] as usize {
                let &[low, high, exit, _] = self.constants.get(action);
                let (mut sum, mut most) = if UPPER { (high, exit) } else { (low, 0.0) };
                for (&to, number) in rest.by_ref().take(self.edges.get(action) as usize) {
                    let value = x[to as usize];
                    sum += distinct[number.position()][0] * value;
                    if UPPER {
                        most = if value > most { value } else { most };
                    }
                }
                let q = if UPPER { (sum * (1.0 + self.error) + TINY).min(most) } else { sum };
                self.choose(&mut best, (q, action));
            }
            let best = if UPPER { best } else { (self.lowered(best.0), best.1) };
            visit(group, &mut x[group], best);
        }
        Ok(())
    }
}
