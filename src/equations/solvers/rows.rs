//! The equations of a component in compressed rows: with doubles, rounded outwards, or with fractions.
//!
//! With doubles, the result of a row with m edges is computed to the nearest and then moved outwards by
//! (m + 8) · 2^-52 of it: all terms are at least 0, so this covers the rounding of probabilities,
//! products and sums.
//!
//! An upper bound has another limit. The result of a row in which nothing is gained or paid is a mean
//! of the values that it leads to, so it is at most the greatest of them, without any rounding. This
//! matters where many policies are equally good and some of them hardly leave the component: along
//! their cycles the rounding of each row adds up, and exceeds what the exits take away.

use std::ops::Range;

use ahash::AHashMap;

use crate::graphs::graph::NONE;
use crate::graphs::meter::Meter;
use crate::solvers::groups::{Entry, Equation, Groups};
use crate::solvers::solution::Solution;
use crate::solvers::system::System;
use meliora_base::error::Result;
use meliora_base::exact::Ratio;
use meliora_base::interval::Interval;
use meliora_base::number::{Number, Weight};
use meliora_model::Optimum;

/// The width of narrow bounds, absolute below 1; twice the width of the bounds at the exits is added.
const WIDE: f64 = 1e-7;

/// The greatest number of constants that are looked up: 4 MiB.
const MOST_KNOWN: usize = 1 << 16;

/// Results below this may have lost digits.
pub(crate) const TINY: f64 = 1e-280;

/// The bounds of the groups.
#[derive(Debug)]
pub(crate) struct GroupBounds<N = f64> {
    pub(crate) low: Vec<N>,
    /// The upper bounds; infinite if none are known.
    pub(crate) high: Vec<N>,
    /// The choice by which each group is left, or [`NONE`].
    pub(crate) picks: Vec<u32>,
}

impl GroupBounds {
    /// Returns the narrowest of these bounds and of others, with the choices of the others where they are known.
    pub(crate) fn and(self, others: Option<GroupBounds>) -> Self {
        let Some(mut narrow) = others else { return self };
        narrow.low.iter_mut().zip(&self.low).for_each(|(low, other)| *low = low.max(*other));
        narrow.high.iter_mut().zip(&self.high).for_each(|(high, other)| *high = high.min(*other));
        let open = narrow.picks.iter_mut().zip(&self.picks).filter(|(pick, _)| **pick == NONE);
        open.for_each(|(pick, other)| *pick = *other);
        narrow
    }
}

impl GroupBounds<Ratio> {
    /// Returns the fractions as doubles, rounded outwards.
    pub(crate) fn rounded(self) -> GroupBounds {
        let low = self.low.iter().map(|x| Interval::around(x).lower).collect();
        let high = self.high.iter().map(|x| Interval::around(x).upper).collect();
        GroupBounds { low, high, picks: self.picks }
    }
}

/// A component in compressed rows.
#[derive(Debug)]
pub(crate) struct Rows<N> {
    /// The extreme of the leading side; see [`crate::solvers::system::Quantity::leader`].
    pub(crate) leader: Optimum,
    /// The extreme that each group looks for.
    pub(crate) optima: Vec<Optimum>,
    /// True if both sides together can stay in the component forever without any cost.
    pub(crate) may_rest: bool,
    /// The actions of group g are `first[g]..first[g+1]`.
    first: Vec<u32>,
    /// The edges of action a are `start[a]..start[a+1]`.
    start: Vec<u32>,
    /// The group that each edge enters, and its probability.
    to: Vec<u32>,
    probabilities: Vec<N>,
    /// The number of what each action has besides its edges.
    constant_of: Vec<u32>,
    constants: Vec<Constant<N>>,
    /// The numbers of some constants of doubles, by their bits: most actions inside a component have the same.
    known: AHashMap<[u64; 4], u32>,
    /// The choice of each action.
    pub(crate) choices: Vec<u32>,
    /// The relative error of a row of doubles.
    pub(crate) error: f64,
    /// The width of the bounds at the exits.
    pub(crate) inherited: f64,
    /// The smallest probability.
    pub(crate) least: f64,
}

/// The parts of an action besides its edges.
#[derive(Debug, Clone)]
pub(crate) struct Constant<N = f64> {
    /// The bounds of its gain or payment, values at exits included.
    pub(crate) low: N,
    pub(crate) high: N,
    /// The greatest upper bound at an exit; infinite if more is gained or paid.
    pub(crate) most: f64,
    /// The probability to leave the component.
    pub(crate) escape: N,
}

impl<N: Entry> Rows<N> {
    /// Creates a component without groups.
    pub(crate) fn empty(leader: Optimum, optima: Vec<Optimum>) -> Self {
        Rows {
            leader,
            optima,
            may_rest: false,
            first: vec![0],
            start: vec![0],
            to: Vec::new(),
            probabilities: Vec::new(),
            constant_of: Vec::new(),
            constants: Vec::new(),
            known: AHashMap::new(),
            choices: Vec::new(),
            error: 0.0,
            inherited: 0.0,
            least: 1.0,
        }
    }

    /// Copies the rows of a component, divided by the probabilities to leave the groups.
    pub(crate) fn new<M: Number>(
        system: &System<'_, M>,
        groups: &Groups<'_>,
        solution: &Solution<M>,
        meter: &mut Meter<'_>,
    ) -> Result<Self> {
        let mut rows = Rows::empty(system.quantity.leader(), groups.optima(system));
        let mut equation = Equation::empty();
        rows.may_rest = groups.may_rest;
        groups.visit(system, meter, |group, choice| {
            rows.begin(group);
            groups.write::<M, N>(system, group, choice, solution, &mut equation);
            rows.add(choice, &equation);
        })?;
        rows.begin(groups.count() as u32);
        rows.known = AHashMap::new();
        Ok(rows)
    }

    /// Ends the groups before a group.
    pub(crate) fn begin(&mut self, group: u32) {
        self.first.resize(group as usize + 1, self.choices.len() as u32);
    }

    /// Adds an action to the last group.
    pub(crate) fn push(&mut self, choice: u32, edges: impl Iterator<Item = (u32, N)>, constant: Constant<N>) {
        for (to, p) in edges {
            self.to.push(to);
            self.probabilities.push(p);
        }
        self.start.push(self.to.len() as u32);
        let number = self.number(constant);
        self.constant_of.push(number);
        self.choices.push(choice);
    }

    /// Returns the number of a constant.
    fn number(&mut self, constant: Constant<N>) -> u32 {
        let Constant { low, high, most, escape } = &constant;
        let bits = || Some([low.double()?, high.double()?, *most, escape.double()?].map(f64::to_bits));
        let bits = bits();
        if let Some(&known) = bits.as_ref().and_then(|bits| self.known.get(bits)) {
            return known;
        }
        let new = self.constants.len() as u32;
        if let Some(bits) = bits.filter(|_| self.known.len() < MOST_KNOWN) {
            self.known.insert(bits, new);
        }
        self.constants.push(constant);
        new
    }

    /// Adds the equation of a choice to the last group, unless the choice never leaves its group.
    fn add(&mut self, choice: u32, equation: &Equation<N::Read>) {
        let Equation { row, low, high, whole, most, width } = equation;
        let leaving = if *whole { N::Read::one() } else { row.leaving() };
        self.inherited = self.inherited.max(*width);
        if leaving.is_zero() {
            return;
        }
        if !N::Read::EXACT {
            let parts = row.edges.iter().map(|edge| &edge.1).chain([&row.escape]);
            let parts = parts.filter(|p| !p.is_zero()).map(|p| p.bounds().lower);
            self.least = parts.fold(self.least, f64::min);
            // The quotients are within the width of the divisor.
            let Interval { lower, upper } = leaving.bounds();
            let error = (row.edges.len() + 8) as f64 * f64::EPSILON + 4.0 * (upper / lower - 1.0);
            self.error = self.error.max(error);
        }
        let divisor = N::of(&leaving.low());
        let edges = row.edges.iter().map(|(to, p)| (*to, N::of(p).over(&divisor)));
        let constant = Constant {
            low: N::of(&low.over(&leaving)),
            high: N::of(&high.over(&leaving).high()),
            most: *most,
            escape: N::of(&row.escape).over(&divisor),
        };
        self.push(choice, edges, constant);
    }

    /// Returns the bytes of the rows, and of the iteration over them.
    pub(crate) fn bytes(&self) -> usize {
        let action = 3 * size_of::<u32>();
        let constants = self.constants.len() * (3 * N::BYTES + size_of::<f64>());
        let edges = self.to.len() * (size_of::<u32>() + N::BYTES);
        edges + self.choices.len() * action + constants + 36 * self.first.len()
    }

    /// Returns the number of entries of all rows: the work of a sweep.
    pub(crate) fn entries(&self) -> usize {
        self.to.len() + self.choices.len()
    }

    pub(crate) fn groups(&self) -> usize {
        self.first.len() - 1
    }

    /// Returns whether a group looks for the greatest value.
    #[inline]
    pub(crate) fn is_max(&self, group: usize) -> bool {
        self.optima[group] == Optimum::Max
    }

    /// Returns whether groups look for different extremes.
    pub(crate) fn is_mixed(&self) -> bool {
        self.optima.iter().any(|optimum| *optimum != self.optima[0])
    }

    /// Returns whether the leading side looks for the greatest value.
    pub(crate) fn leads_up(&self) -> bool {
        self.leader == Optimum::Max
    }

    /// Returns whether a group is one of the leading side.
    #[inline]
    pub(crate) fn leads(&self, group: usize) -> bool {
        self.optima[group] == self.leader
    }

    /// Returns the actions of a group.
    pub(crate) fn actions(&self, group: usize) -> Range<usize> {
        self.first[group] as usize..self.first[group + 1] as usize
    }

    /// Returns what an action has besides its edges.
    #[inline]
    pub(crate) fn constant(&self, action: usize) -> &Constant<N> {
        &self.constants[self.constant_of[action] as usize]
    }

    /// Returns the lower or the upper bound of the constant of an action.
    #[inline]
    pub(crate) fn bound(&self, action: usize, upper: bool) -> &N {
        let Constant { low, high, .. } = self.constant(action);
        if upper { high } else { low }
    }

    /// Returns whether both bounds of each constant are the same.
    pub(crate) fn has_points(&self) -> bool {
        self.constants.iter().all(|own| own.low == own.high)
    }

    /// Returns the groups that the edges of an action enter, and their probabilities.
    #[inline]
    pub(crate) fn row(&self, action: usize) -> impl ExactSizeIterator<Item = (u32, &N)> {
        let edges = self.start[action] as usize..self.start[action + 1] as usize;
        self.to[edges.clone()].iter().copied().zip(&self.probabilities[edges])
    }

    /// Returns the positions of the edges of an action.
    pub(crate) fn positions(&self, action: usize) -> Range<u32> {
        self.start[action]..self.start[action + 1]
    }

    /// Returns the group that the edge at a position enters, and its probability.
    pub(crate) fn edge(&self, position: u32) -> (u32, &N) {
        (self.to[position as usize], &self.probabilities[position as usize])
    }

    /// Returns `constant` + Σ p · x of an action.
    #[inline]
    pub(crate) fn value(&self, action: usize, constant: N, x: &[N]) -> N {
        self.row(action).fold(constant, |sum, (to, p)| sum.plus(&p.times(&x[to as usize])))
    }

    /// Returns a policy with which each path leaves the component almost surely, and one of the leading side proceeds,
    /// whatever the other side does; see [`Rows::proceeds`]. `None` if there is none. Cost: some sweeps.
    ///
    /// # Errors
    /// The work is cancelled.
    pub(crate) fn leaving_policy(&self, meter: &mut Meter<'_>) -> Result<Option<Vec<usize>>> {
        match self.proceeding(None, meter)? {
            Some(policy) => self.leaving_with(&policy, meter),
            None => Ok(None),
        }
    }

    /// Completes a policy of the leading side to one with which the component is left almost surely.
    ///
    /// # Errors
    /// The work is cancelled.
    pub(crate) fn leaving_with(&self, policy: &[usize], meter: &mut Meter<'_>) -> Result<Option<Vec<usize>>> {
        self.attracted(meter, |group, reached| {
            let leaves = |&action: &usize| self.enters(action, reached);
            match self.leads(group) {
                true => Some(policy[group]).filter(leaves),
                false => self.actions(group).find(leaves),
            }
        })
    }

    /// Returns whether a policy of the leading side proceeds, whatever the other side does: no path stays in the component
    /// forever, except that it may then gain forever if the leading side wants the greatest value.
    ///
    /// # Errors
    /// The work is cancelled.
    pub(crate) fn proceeds(&self, policy: &[usize], meter: &mut Meter<'_>) -> Result<bool> {
        Ok(self.proceeding(Some(policy), meter)?.is_some())
    }

    /// Returns a policy that proceeds, by actions that are given if some are; see [`Rows::proceeds`].
    fn proceeding(&self, given: Option<&[usize]>, meter: &mut Meter<'_>) -> Result<Option<Vec<usize>>> {
        self.attracted(meter, |group, reached| {
            let proceeds = |&action: &usize| {
                let gains = self.leads_up() && !self.constant(action).low.is_zero();
                gains || self.enters(action, reached)
            };
            let mut actions = self.actions(group);
            match (self.leads(group), given) {
                (true, None) => actions.find(proceeds),
                (true, Some(given)) => Some(given[group]).filter(proceeds),
                (false, _) => actions.clone().next().filter(|_| actions.all(|action| proceeds(&action))),
            }
        })
    }

    /// Returns whether an action leaves the component, or enters a group with an action, with positive probability.
    fn enters(&self, action: usize, reached: &[usize]) -> bool {
        !self.constant(action).escape.is_zero()
            || self.row(action).any(|(to, _)| reached[to as usize] != usize::MAX)
    }

    /// Gives each group the action that `find` returns for the groups with actions so far; `None` if some get none. Sweeps
    /// go over the groups that are left, by turns in both directions.
    fn attracted(
        &self,
        meter: &mut Meter<'_>,
        find: impl Fn(usize, &[usize]) -> Option<usize>,
    ) -> Result<Option<Vec<usize>>> {
        let mut policy = vec![usize::MAX; self.groups()];
        let mut open: Vec<u32> = (0..self.groups() as u32).collect();
        while !open.is_empty() {
            let before = open.len();
            let mut end = Ok(());
            open.retain(|&group| {
                if end.is_ok() {
                    end = meter.step();
                }
                let found = find(group as usize, &policy);
                policy[group as usize] = found.unwrap_or(usize::MAX);
                found.is_none()
            });
            end?;
            if open.len() == before {
                return Ok(None);
            }
            open.reverse();
        }
        Ok(Some(policy))
    }
}

impl Rows<f64> {
    /// Returns whether bounds of the groups are as near to each other as those at the exits allow.
    pub(crate) fn is_narrow(&self, low: &[f64], high: &[f64]) -> bool {
        let most = |low: f64| WIDE * low.max(1.0) + 2.0 * self.inherited;
        low.iter().zip(high).all(|(low, high)| high - low <= most(*low))
    }

    /// Returns whether the value of an action is that of the one group that it enters, without any rounding.
    pub(crate) fn copies(&self, action: usize) -> bool {
        let &Constant { high, most, escape, .. } = self.constant(action);
        self.start[action + 1] - self.start[action] == 1 && [high, most, escape] == [0.0; 3]
    }

    /// Returns a lower bound of c + Σ p · x of an action.
    #[inline]
    pub(crate) fn below(&self, action: usize, x: &[f64]) -> f64 {
        self.lowered(self.value(action, self.constant(action).low, x))
    }

    /// Returns an upper bound of c + Σ p · x of an action.
    #[inline]
    pub(crate) fn above(&self, action: usize, x: &[f64]) -> f64 {
        self.raised(self.constant(action), self.row(action), x)
    }

    /// Returns an upper bound of c + Σ p · x for the edges of an action.
    #[inline]
    fn raised<'r>(
        &self,
        &Constant { high, most, .. }: &Constant,
        edges: impl Iterator<Item = (u32, &'r f64)>,
        x: &[f64],
    ) -> f64 {
        let (mut sum, mut greatest) = (high, most);
        for (to, p) in edges {
            let value = x[to as usize];
            sum += p * value;
            greatest = if value > greatest { value } else { greatest };
        }
        (sum * (1.0 + self.error) + TINY).min(greatest)
    }

    /// Returns a lower or upper bound of the optimum of a group, and the action that attains it.
    #[inline]
    pub(crate) fn best(&self, group: usize, upper: bool, x: &[f64]) -> (f64, usize) {
        let greatest = self.is_max(group);
        let actions = self.actions(group);
        let mut best = (if greatest { 0.0 } else { f64::INFINITY }, actions.start);
        // Slices of the group are checked once, not for each action: this is the innermost loop.
        let ends = self.start[actions.start..=actions.end].windows(2);
        let constants = &self.constant_of[actions.clone()];
        for ((number, ends), &own) in (actions.start..).zip(ends).zip(constants) {
            let own = &self.constants[own as usize];
            let edges = ends[0] as usize..ends[1] as usize;
            let edges = self.to[edges.clone()].iter().copied().zip(&self.probabilities[edges]);
            let q = match upper {
                true => self.raised(own, edges, x),
                false => edges.fold(own.low, |sum, (to, p)| sum + p * x[to as usize]),
            };
            if if greatest { q > best.0 } else { q < best.0 } {
                best = (q, number);
            }
        }
        if upper { best } else { (self.lowered(best.0), best.1) }
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
    pub(crate) fn sweep(
        &self,
        upper: bool,
        x: &mut [f64],
        meter: &mut Meter<'_>,
        mut visit: impl FnMut(usize, &mut f64, (f64, usize)),
    ) -> Result<()> {
        for group in 0..x.len() {
            meter.step()?;
            let best = self.best(group, upper, x);
            visit(group, &mut x[group], best);
        }
        Ok(())
    }
}
