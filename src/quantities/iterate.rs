//! Bounds of the optimal values of a large component, by optimistic value iteration.
//!
//! Let B be the operator of the optimality equations of a component whose end components without
//! gain or cost are collapsed. Two facts make every number here a bound:
//!
//! - B is monotone, so what iteration from 0 reaches is never above the least solution.
//! - If B(U) ≤ U for a finite U ≥ 0, the least solution is not above U. (D. Park's induction; for
//!   costs: the policy that attains B(U) costs at most U, and a policy that never leaves costs
//!   infinitely much.)
//!
//! So the lower bounds are iterated from 0, and rounded down. When they hardly change, they are
//! raised by a small relative amount to a candidate U, which is iterated, and rounded up, until one
//! sweep raises no value: then it is an upper bound. If this takes too long, the lower bounds are
//! iterated further and a smaller amount is tried. Probabilities have the upper bound 1 to start with;
//! if no candidate is found, it is iterated downwards (interval iteration).
//!
//! A sweep visits the groups in postorder and uses new values at once (Gauss and Seidel), so values
//! travel through most of a component in one sweep. The result of a row with m edges is computed to
//! the nearest and then moved outwards by (m + 8) · 2^-52 of it: all terms are at least 0, so this
//! covers the rounding of probabilities, products and sums.
//!
//! A. Hartmanns and B. Kaminski, "Optimistic value iteration" (CAV 2020); S. Haddad and B. Monmege,
//! "Interval iteration algorithm for MDPs and IMDPs" (TCS 2018).

use super::component::Sense;
use super::graph::Edge;
use super::groups::Groups;
use super::meter::Meter;
use super::number::{Interval, Number};
use super::solve::{End, Margin, NONE, Solution, System};
use crate::error::Result;

/// The relative width that is tried first, and the factor for the next attempts.
const WIDTH: f64 = 1e-9;
const NARROWER: f64 = 1e-2;
/// The change of a sweep, as a part of the width, at which lower bounds are raised to a candidate.
const STILL: f64 = 1e-3;
/// The width of bounds, absolute below 1, for which another attempt is made; twice the width of the
/// bounds at the exits is added.
const WIDE: f64 = 1e-8;
/// Attempts with a smaller width.
const ATTEMPTS: usize = 3;
/// The number of sweeps after which an iteration may be given up because it would take longer.
const PATIENCE: usize = 50;
/// The greatest expected number of sweeps of a component that elimination can solve, and of others.
/// Measured on random walks in the plane, which are left slowly: elimination is as fast as some
/// hundred sweeps.
const FEW_SWEEPS: f64 = 500.0;
const MOST_SWEEPS: f64 = 20_000.0;
/// The number of groups that elimination solves in less than a minute on such walks.
const ELIMINABLE: usize = 50_000;
/// Changes of smaller values are compared with this.
const FLOOR: f64 = 1e-6;
/// Results below this may have lost digits.
const TINY: f64 = 1e-280;

/// A component in compressed rows.
pub(super) struct Sparse {
    sense: Sense,
    /// The actions of group g are `first[g]..first[g+1]`.
    first: Vec<u32>,
    /// The edges of action a are `start[a]..start[a+1]`.
    start: Vec<u32>,
    edges: Vec<(u32, f64)>,
    /// The bounds of the constant of each action.
    constants: Vec<(f64, f64)>,
    /// The choice of each action, and the node that has it.
    choices: Vec<(u32, u32)>,
    /// The relative error of a row.
    error: f64,
    /// The width of the bounds at the exits.
    inherited: f64,
    /// The smallest probability.
    least: f64,
}

/// The bounds of the groups.
pub(super) struct Found {
    pub(super) low: Vec<f64>,
    pub(super) high: Vec<Option<f64>>,
    pub(super) picks: Vec<(u32, u32)>,
}

impl Sparse {
    /// Copies the rows of a component, divided by the probabilities to leave the groups.
    ///
    /// # Errors
    /// A limit is reached.
    pub(super) fn new<N: Number>(
        system: &System<'_, N>,
        groups: &Groups<'_>,
        solution: &Solution<N>,
        meter: &mut Meter<'_>,
    ) -> Result<Self> {
        let mut sparse = Sparse {
            sense: system.sense(),
            first: vec![0],
            start: vec![0],
            edges: Vec::new(),
            constants: Vec::new(),
            choices: Vec::new(),
            error: 0.0,
            inherited: 0.0,
            least: 1.0,
        };
        groups.visit(system, meter, |group, node, choice, _| {
            while sparse.first.len() <= group as usize {
                sparse.first.push(sparse.choices.len() as u32);
            }
            sparse.add(system, groups, solution, (group, node, choice));
            Ok(())
        })?;
        while sparse.first.len() <= groups.count() {
            sparse.first.push(sparse.choices.len() as u32);
        }
        Ok(sparse)
    }

    fn add<N: Number>(
        &mut self,
        system: &System<'_, N>,
        groups: &Groups<'_>,
        solution: &Solution<N>,
        (own, node, choice): (u32, u32, u32),
    ) {
        let fraction = |position: u32| system.fractions[position as usize].bounds();
        let mut constant = system.cost(choice).map_or(Interval::ZERO, fraction);
        let (mut whole, mut leaving, before) = (true, Interval::ZERO, self.edges.len());
        let mut add = |edge: &Edge| {
            let p = fraction(edge.probability());
            if system.bonus(edge) {
                constant = constant.plus(&p);
            }
            match system.end(edge, solution) {
                End::Known(value) => {
                    self.inherited = self.inherited.max(value.bounds().width());
                    constant = constant.plus(&p.times(&value.bounds()));
                }
                End::Open(to) => match groups.group_of(to) {
                    Some(to) if to == own => {
                        whole = false;
                        return;
                    }
                    Some(to) => self.edges.push((to, p.lower)),
                    None => {}
                },
            }
            self.least = self.least.min(p.lower);
            leaving = leaving.plus(&p);
        };
        system.graph.edges(choice).iter().for_each(&mut add);
        if Number::is_zero(&leaving) {
            self.edges.truncate(before);
            return;
        }
        match system.margin {
            Some(Margin::Loss(size)) => {
                leaving = leaving.times(&Interval::ONE.plus(&Interval::point(size)));
                whole = false;
            }
            Some(Margin::Gain(size, bounds)) => {
                let gain = Interval::point(size * bounds.values[node as usize].upper);
                constant = constant.plus(&gain.times(&leaving));
            }
            None => {}
        }
        let mut error = (self.edges.len() - before + 8) as f64 * f64::EPSILON;
        if !whole {
            constant = constant.over(&leaving);
            // The quotients are within the width of the divisor.
            error += 4.0 * (leaving.upper / leaving.lower - 1.0);
            self.edges[before..].iter_mut().for_each(|edge| edge.1 /= leaving.lower);
        }
        self.error = self.error.max(error);
        self.start.push(self.edges.len() as u32);
        self.constants.push((constant.lower, constant.upper));
        self.choices.push((choice, node));
    }

    /// Returns the bytes of the rows.
    pub(super) fn bytes(&self) -> usize {
        4 * (self.first.len() + self.start.len())
            + 16 * self.edges.len()
            + 24 * self.constants.len()
            + 32 * self.first.len()
    }

    fn groups(&self) -> usize {
        self.first.len() - 1
    }

    fn sum(&self, action: usize, constant: f64, x: &[f64]) -> f64 {
        let edges = &self.edges[self.start[action] as usize..self.start[action + 1] as usize];
        edges.iter().fold(constant, |sum, &(to, p)| sum + p * x[to as usize])
    }

    /// Returns a lower or upper bound of the optimum of a group, and the action that attains it.
    fn best(&self, group: usize, upper: bool, x: &[f64]) -> (f64, usize) {
        let actions = self.first[group] as usize..self.first[group + 1] as usize;
        let value = |action: usize| {
            let (low, high) = self.constants[action];
            self.sum(action, if upper { high } else { low }, x)
        };
        let mut best = match self.sense {
            Sense::Max => (0.0, actions.start),
            Sense::Min => (f64::INFINITY, actions.start),
        };
        for action in actions {
            let q = value(action);
            let better = match self.sense {
                Sense::Max => q > best.0,
                Sense::Min => q < best.0,
            };
            if better {
                best = (q, action);
            }
        }
        let rounded = match upper {
            true => best.0 * (1.0 + self.error) + TINY,
            false if best.0 < TINY => 0.0,
            false => best.0 * (1.0 - self.error),
        };
        (rounded, best.1)
    }
}

/// Computes bounds of the groups, which are at most `top` if it is given. The result is true if they
/// are narrow, false if iteration would take too long, or an error if a limit is reached; the bounds
/// hold in any case.
pub(super) fn solve(sparse: &Sparse, top: Option<f64>, meter: &mut Meter<'_>) -> (Found, Result<bool>) {
    let n = sparse.groups();
    let high = top.map(|top| vec![top; n]);
    let mut work = Iteration { sparse, low: vec![0.0; n], high, policy: vec![usize::MAX; n] };
    let end = work.run(meter);
    (work.found(), end)
}

struct Iteration<'s> {
    sparse: &'s Sparse,
    low: Vec<f64>,
    /// Upper bounds, if some are known.
    high: Option<Vec<f64>>,
    /// For the greatest values: the action that raised the lower bound last. A policy of such actions
    /// leaves the component: where it stayed for ever, the first group to get the greatest value of
    /// all would have had to get it from a smaller one. For the least values: the action that
    /// attains the upper bound.
    policy: Vec<usize>,
}

impl Iteration<'_> {
    fn run(&mut self, meter: &mut Meter<'_>) -> Result<bool> {
        // The errors of smaller numbers are not relative.
        if self.sparse.least < TINY {
            return Ok(false);
        }
        let mut width = WIDTH;
        for _ in 0..ATTEMPTS {
            if !self.raise(width * STILL, meter)? {
                return Ok(false);
            }
            if self.enclose(width, meter)? && self.is_narrow() {
                return Ok(true);
            }
            width *= NARROWER;
        }
        self.sink(meter)
    }

    /// Iterates upper bounds downwards; returns whether they become narrow.
    fn sink(&mut self, meter: &mut Meter<'_>) -> Result<bool> {
        let mut pace = Pace::new(WIDTH * STILL, self.sparse.groups());
        while !self.is_narrow() {
            let Some(high) = self.high.as_mut().filter(|_| self.sparse.sense == Sense::Max) else {
                return Ok(false);
            };
            let mut change = 0.0f64;
            for group in 0..high.len() {
                meter.step()?;
                let (q, _) = self.sparse.best(group, true, high);
                if q < high[group] {
                    change = change.max((high[group] - q) / high[group].max(FLOOR));
                    high[group] = q;
                }
            }
            meter.progress(&|| format!("upper bounds of {} states, change {change:.1e}", high.len()));
            if pace.after(change).is_some() {
                return Ok(self.is_narrow());
            }
        }
        Ok(true)
    }

    /// Iterates the lower bounds until a sweep changes them by less than `still`, relatively; returns
    /// false if that would take too long.
    fn raise(&mut self, still: f64, meter: &mut Meter<'_>) -> Result<bool> {
        let mut pace = Pace::new(still, self.sparse.groups());
        loop {
            let mut change = 0.0f64;
            for group in 0..self.sparse.groups() {
                meter.step()?;
                let (q, action) = self.sparse.best(group, false, &self.low);
                let x = self.low[group];
                if q > x {
                    change = change.max(if x == 0.0 { 1.0 } else { (q - x) / q.max(FLOOR) });
                    self.low[group] = q;
                    if self.sparse.sense == Sense::Max {
                        self.policy[group] = action;
                    }
                }
            }
            meter.progress(&|| format!("lower bounds of {} states, change {change:.1e}", self.low.len()));
            if let Some(done) = pace.after(change) {
                return Ok(done);
            }
        }
    }

    /// Looks for upper bounds near the lower ones; returns whether they were found.
    fn enclose(&mut self, width: f64, meter: &mut Meter<'_>) -> Result<bool> {
        let mut x = self.low.clone();
        if self.sparse.constants.iter().any(|(low, high)| low != high)
            && !self.follow(&mut x, width, meter)?
        {
            return Ok(false);
        }
        x.iter_mut().for_each(|x| *x += width * x.max(FLOOR));
        let (mut last, mut policy) = (f64::INFINITY, self.policy.clone());
        for sweep in 0.. {
            let mut raised = 0.0f64;
            for group in 0..x.len() {
                meter.step()?;
                let (q, action) = self.sparse.best(group, true, &x);
                raised = raised.max((q - x[group]) / q.max(FLOOR));
                x[group] = q;
                if self.sparse.sense == Sense::Min {
                    policy[group] = action;
                }
            }
            if raised <= 0.0 {
                self.policy = policy;
                // Both are upper bounds.
                let known = self.high.take().unwrap_or_else(|| vec![f64::INFINITY; x.len()]);
                self.high = Some(x.into_iter().zip(known).map(|(x, known)| x.min(known)).collect());
                return Ok(true);
            }
            if sweep % (4 * PATIENCE) == 4 * PATIENCE - 1 {
                // The values settle without being an upper bound, or hardly anything changes.
                if raised > 0.5 * last || !raised.is_finite() {
                    return Ok(false);
                }
                last = raised;
            }
        }
        Ok(false)
    }

    fn is_narrow(&self) -> bool {
        let Some(high) = &self.high else { return false };
        let narrow =
            |(low, high): (&f64, &f64)| high - low <= WIDE * low.max(1.0) + 2.0 * self.sparse.inherited;
        self.low.iter().zip(high).all(narrow)
    }

    /// Iterates towards the solution with the upper bounds of the constants.
    fn follow(&self, x: &mut [f64], width: f64, meter: &mut Meter<'_>) -> Result<bool> {
        let mut pace = Pace::new(width * STILL, x.len());
        loop {
            let mut change = 0.0f64;
            for group in 0..x.len() {
                meter.step()?;
                let (q, _) = self.sparse.best(group, true, x);
                change = change.max((q - x[group]) / q.max(FLOOR));
                x[group] = q.max(x[group]);
            }
            if let Some(done) = pace.after(change) {
                return Ok(done);
            }
        }
    }

    fn found(self) -> Found {
        let pick = |(group, &action): (usize, &usize)| {
            let known = action != usize::MAX && (self.sparse.sense == Sense::Max || self.high.is_some());
            if known { self.sparse.choices[action] } else { (NONE, group as u32) }
        };
        let picks = self.policy.iter().enumerate().map(pick).collect();
        let high = match self.high {
            Some(high) => high.into_iter().map(Some).collect(),
            None => vec![None; self.low.len()],
        };
        Found { low: self.low, high, picks }
    }
}

/// Decides when an iteration ends: when it is still, or when it would take too long.
struct Pace {
    still: f64,
    /// The greatest number of sweeps to expect.
    most: f64,
    sweeps: usize,
    last: f64,
}

impl Pace {
    fn new(still: f64, groups: usize) -> Self {
        let most = if groups <= ELIMINABLE { FEW_SWEEPS } else { MOST_SWEEPS };
        Pace { still: still.max(1e-15), most, sweeps: 0, last: f64::INFINITY }
    }

    /// Returns whether the end is reached (true) or too far away (false); `None` to continue.
    fn after(&mut self, change: f64) -> Option<bool> {
        self.sweeps += 1;
        if change <= self.still {
            return Some(true);
        }
        if self.sweeps.is_multiple_of(PATIENCE) {
            let left = PATIENCE as f64 * (self.still / change).ln() / (change / self.last).ln();
            // While values arrive for the first time, the change says nothing.
            if change < 0.5 && (left < 0.0 || left > self.most) {
                return Some(false);
            }
            self.last = change;
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::NoProgress;

    fn ring(n: u32, leaving: f64) -> Sparse {
        // Each group goes on to the next one, or leaves with the value 1/2.
        let stay = 1.0 - leaving;
        Sparse {
            sense: Sense::Max,
            first: (0..=n).collect(),
            start: (0..=n).collect(),
            edges: (0..n).map(|i| ((i + 1) % n, stay)).collect(),
            constants: vec![(leaving / 2.0, leaving / 2.0); n as usize],
            choices: (0..n).map(|i| (i, i)).collect(),
            error: 16.0 * f64::EPSILON,
            inherited: 0.0,
            least: leaving,
        }
    }

    #[test]
    fn bounds_contain_the_value_and_are_narrow() {
        let mut meter = Meter::unlimited(&NoProgress);
        let (found, end) = solve(&ring(50, 0.25), None, &mut meter);
        assert!(end.unwrap());
        for (low, high) in found.low.iter().zip(&found.high) {
            let high = high.unwrap();
            assert!(*low <= 0.5 && 0.5 <= high && high - low < 1e-8, "{low} {high}");
        }
    }

    #[test]
    fn a_component_that_is_hardly_left_is_given_up_with_true_bounds() {
        let mut meter = Meter::unlimited(&NoProgress);
        let (found, end) = solve(&ring(50, 2.0f64.powi(-45)), None, &mut meter);
        assert!(!end.unwrap());
        assert!(found.low.iter().all(|low| *low <= 0.5) && found.high.iter().all(Option::is_none));
    }
}
