//! Bounds of the optimal values of a component by policy iteration with doubles, and one step that
//! confirms them.
//!
//! A policy is evaluated by elimination of states with doubles, without a claim. It is changed only where another
//! action is clearly better, so an action that is merely as good never forms a cycle. Then bounds near its values x
//! are tested by one step that is rounded outwards:
//!
//! - If B(U) ≤ U for a finite U ≥ 0, the least solution is not above U.
//! - If L ≤ B(L) for the actions of a policy that leaves the component almost surely, its values are not
//!   below L: the difference would stay in the component. For least costs, L ≤ B(L) must hold for every
//!   action; a policy that never leaves costs infinitely much.
//!
//! On the side of the policy, the bound is x ∓ m t, where t is its expected number of steps and m some
//! multiple of the rounding error: in one step, this gains m. On the other side, other actions count. Let
//! `gap(a)` be the amount by which an action is worse. A bound x ± g has a margin of m for every action if
//! g ≥ m - gap(a) + P_a g, so g is found by policy iteration, too; it is m t if no action is nearly as good
//! and takes more steps.
//!
//! The width is some 1e-14 times the greatest number of steps. Where components are left so rarely that this
//! is wide, fractions are needed; see [`crate::solvers::component`].

use crate::equations::graph::NONE;
use crate::equations::meter::{Meter, Stop, Turn};
use crate::equations::system::Sense;
use crate::solvers::eliminate::{self, Row};
use crate::solvers::sparse::{Constant, Found, Sparse, TINY};
use meliora_base::error::Result;

/// Sweeps of value iteration between two evaluations of policies, and over the equations of the last policy.
const SWEEPS: usize = 8;
/// Changes of a policy after which it is not expected to settle, and sweeps that are worth one change.
pub(crate) const ROUNDS: usize = 64;
/// The margin of a step, in rounding errors, that is tried first, and the factor for the next attempts.
const MARGIN: f64 = 4.0;

/// The values of a policy in a group, for the lower and the upper bounds of the constants, and its
/// expected number of steps.
#[derive(Debug, Clone, Copy)]
struct Values {
    low: f64,
    high: f64,
    steps: f64,
}

/// An action of each group.
type Policy = Vec<usize>;

/// Policy iteration, which continues in each turn with the policy of the last one.
pub(crate) struct Elimination<'s> {
    sparse: &'s Sparse,
    policy: Option<Policy>,
    /// The evaluation of this policy, if it has begun.
    begun: Option<eliminate::Elimination<f64, [f64; 3]>>,
    /// The work that may be done in this turn.
    left: usize,
}

impl<'s> Elimination<'s> {
    pub(crate) fn new(sparse: &'s Sparse) -> Self {
        Elimination { sparse, policy: None, begun: None, left: 0 }
    }

    /// Looks for bounds of the groups, which may be wide. `seen` is a policy that looked good in value iteration, with
    /// [`NONE`] for some groups.
    ///
    /// # Errors
    /// None are found; the work takes more than `budget`; a limit is reached.
    pub(crate) fn turn(&mut self, seen: &[u32], budget: usize, meter: &mut Meter<'_>) -> Turn<Found> {
        if self.sparse.least < TINY {
            return Err(Stop::Never);
        }
        self.left = budget;
        let mut policy = match self.policy.take() {
            Some(policy) => policy,
            None => self.first(seen, meter)?,
        };
        for _ in 0..ROUNDS {
            self.policy = Some(policy.clone());
            let x = self.values(&policy, meter)?;
            let better = self.greedy(policy.clone(), self.side(&x), meter)?;
            if better == policy {
                return self.confirmed(&policy, x, meter);
            }
            policy = better;
        }
        Err(Stop::Never)
    }

    /// Returns the choices of the best policy so far; an empty list if there is none.
    pub(crate) fn picks(&self) -> Vec<u32> {
        self.policy.iter().flatten().map(|&action| self.sparse.choices[action]).collect()
    }

    /// Returns a policy that leaves the component.
    fn first(&self, seen: &[u32], meter: &mut Meter<'_>) -> Turn<Policy> {
        let leaving = self.sparse.leaving_policy(meter)?.ok_or(Stop::Never)?;
        let is_known = self.sparse.sense == Sense::Max && seen.iter().all(|&action| action != NONE);
        let first = if is_known { seen } else { &leaving };
        let policy: Policy = first.iter().map(|&action| action as usize).collect();
        match self.sparse.sense {
            Sense::Max => Ok(self.greedy(policy, vec![0.0; seen.len()], meter)?),
            Sense::Min => Ok(policy),
        }
    }

    /// Returns bounds near the values of a policy.
    fn confirmed(&self, policy: &Policy, mut x: Vec<Values>, meter: &mut Meter<'_>) -> Turn<Found> {
        self.smooth(policy, &mut x, meter)?;
        let most = x.iter().fold(0.0, |most: f64, x| most.max(x.high));
        let mut margin = MARGIN * (self.sparse.error * most + TINY);
        loop {
            let found = self.bounds(policy, &x, margin, meter)?;
            if self.holds(policy, &found, meter)? {
                return Ok(found);
            }
            if !self.sparse.is_narrow(&found.low, &found.high) {
                return Err(Stop::Never);
            }
            margin *= MARGIN;
        }
    }

    /// Replaces a policy by the one that looks best after some sweeps of value iteration: from 0 for the
    /// greatest values, from those of the policy for the least ones. So it keeps leaving the component.
    fn greedy(&self, mut policy: Policy, mut x: Vec<f64>, meter: &mut Meter<'_>) -> Result<Policy> {
        let upper = self.sparse.sense == Sense::Max;
        for _ in 0..SWEEPS {
            let mut settled = true;
            self.sparse.sweep(upper, &mut x, meter, |group, x, (q, action)| {
                if self.sparse.is_better(q, *x) {
                    (*x, policy[group], settled) = (q, action, false);
                }
            })?;
            if settled {
                break;
            }
        }
        Ok(policy)
    }

    /// Returns the values of a policy. If its evaluation has begun before, it continues.
    fn values(&mut self, policy: &Policy, meter: &mut Meter<'_>) -> Turn<Vec<Values>> {
        let mut work = match self.begun.take() {
            Some(work) => work,
            None => {
                let constants = |_, action| {
                    let Constant { low, high, .. } = *self.sparse.constant(action);
                    [low, high, 1.0]
                };
                eliminate::Elimination::new(self.rows(policy, constants), meter)?
            }
        };
        match work.run(&mut self.left, meter) {
            Ok(found) => {
                meter.release(work.bytes());
                let values = |[low, high, steps]: [f64; 3]| Values { low, high, steps };
                finite(found).map(|found| found.into_iter().map(values).collect())
            }
            Err(Stop::Later) => {
                self.begun = Some(work);
                Err(Stop::Later)
            }
            Err(end) => {
                meter.release(work.bytes());
                Err(end)
            }
        }
    }

    /// Returns the rows of a policy with the given constants of its actions.
    fn rows<const K: usize>(
        &self,
        policy: &Policy,
        constants: impl Fn(usize, usize) -> [f64; K],
    ) -> Vec<Row<f64, [f64; K]>> {
        let row = |(group, &action): (usize, &usize)| Row {
            edges: self.sparse.row(action).collect(),
            escape: self.sparse.constant(action).escape,
            constant: constants(group, action),
        };
        policy.iter().enumerate().map(row).collect()
    }

    /// Replaces the values of a policy by those that its equations yield. Along the elimination, errors of rounding
    /// add up; what counts is only by how much each equation is missed.
    fn smooth(&self, policy: &Policy, x: &mut [Values], meter: &mut Meter<'_>) -> Result<()> {
        for _ in 0..SWEEPS {
            for (group, &action) in policy.iter().enumerate() {
                meter.step()?;
                let Constant { mut low, mut high, .. } = *self.sparse.constant(action);
                for (to, p) in self.sparse.row(action) {
                    low += p * x[to as usize].low;
                    high += p * x[to as usize].high;
                }
                (x[group].low, x[group].high) = (low, high);
            }
        }
        Ok(())
    }

    /// Returns the values on the side where every action counts.
    fn side(&self, x: &[Values]) -> Vec<f64> {
        let side = |x: &Values| if self.sparse.sense == Sense::Max { x.high } else { x.low };
        x.iter().map(side).collect()
    }

    /// Returns candidates for bounds, with a margin per step.
    fn bounds(&self, policy: &Policy, x: &[Values], margin: f64, meter: &mut Meter<'_>) -> Turn<Found> {
        let own = |x: &Values| margin * x.steps;
        let others = self.slack(policy, x, margin, meter)?;
        let (low, high): (Vec<f64>, Vec<f64>) = match self.sparse.sense {
            Sense::Max => x.iter().zip(&others).map(|(x, g)| (x.low - own(x), x.high + g)).unzip(),
            Sense::Min => x.iter().zip(&others).map(|(x, g)| (x.low - g, x.high + own(x))).unzip(),
        };
        // 0 is a lower bound in any case, also as a part of others.
        let low: Vec<f64> = low.into_iter().map(|x| x.max(0.0)).collect();
        let picks = policy.iter().map(|&action| self.sparse.choices[action]).collect();
        Ok(Found { low, high, picks })
    }

    /// Returns whether one step confirms bounds.
    fn holds(&self, policy: &Policy, Found { low, high, .. }: &Found, meter: &mut Meter<'_>) -> Result<bool> {
        for (group, &action) in policy.iter().enumerate() {
            meter.step()?;
            let lower = match self.sparse.sense {
                Sense::Max => self.sparse.below(action, low),
                Sense::Min => self.sparse.best(group, false, low).0,
            };
            if lower < low[group] || self.sparse.best(group, true, high).0 > high[group] {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Returns g with g ≥ margin - gap(a) + P_a g for every action, nearly. Each round takes about as much work as the
    /// evaluation of the policy took.
    fn slack(&self, policy: &Policy, x: &[Values], margin: f64, meter: &mut Meter<'_>) -> Turn<Vec<f64>> {
        let side = self.side(x);
        let gap = |group: usize, action: usize| {
            let q = self.sparse.sum(action, self.sparse.sense == Sense::Max, &side);
            let gap = if self.sparse.sense == Sense::Max { side[group] - q } else { q - side[group] };
            if action == policy[group] { 0.0 } else { gap }
        };
        let (mut longest, mut g) = (policy.clone(), x.iter().map(|x| margin * x.steps).collect::<Vec<_>>());
        for _ in 0..ROUNDS {
            let mut settled = true;
            for group in 0..g.len() {
                meter.step()?;
                // A part of the margin is enough.
                let mut most = g[group] + margin / 4.0;
                for action in self.sparse.actions(group) {
                    let next: f64 = self.sparse.row(action).map(|(to, p)| p * g[to as usize]).sum();
                    // Most actions are much worse.
                    if margin + next <= most {
                        continue;
                    }
                    let gain = margin - gap(group, action) + next;
                    if gain > most {
                        (most, longest[group], settled) = (gain, action, false);
                    }
                }
            }
            if settled {
                return Ok(g);
            }
            let rows = self.rows(&longest, |group, action| [margin - gap(group, action)]);
            let mut left = usize::MAX;
            let found = finite(eliminate::solve(rows, &mut left, meter)?)?;
            g = found.into_iter().map(|[g]| g.max(0.0)).collect();
        }
        Err(Stop::Never)
    }
}

/// Returns values if all are finite.
fn finite<const K: usize>(values: Vec<[f64; K]>) -> Turn<Vec<[f64; K]>> {
    if values.iter().flatten().all(|x| x.is_finite()) { Ok(values) } else { Err(Stop::Never) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use meliora_engine::NoProgress;

    /// An action: its edges, and an exit with its value and probability.
    type Made = (Vec<(u32, f64)>, Option<(f64, f64)>);

    fn sparse(sense: Sense, groups: &[Vec<Made>]) -> Sparse {
        let mut sparse = Sparse::empty(sense);
        (sparse.error, sparse.least) = (16.0 * f64::EPSILON, 0.5);
        for (group, actions) in (0..).zip(groups) {
            sparse.begin(group);
            for (edges, exit) in actions {
                let (most, escape) = exit.unwrap_or_default();
                let (low, high) = (most * escape, most * escape);
                sparse.push(group, edges.iter().copied(), Constant { low, high, most, escape });
            }
        }
        sparse.begin(groups.len() as u32);
        sparse
    }

    fn solve(sparse: &Sparse) -> Option<Found> {
        let seen = vec![NONE; sparse.groups()];
        Elimination::new(sparse).turn(&seen, usize::MAX, &mut Meter::unlimited(&NoProgress)).ok()
    }

    /// A fair game: it ends with 1 to the right of the last group and with 0 to the left of the first one.
    /// Far from the ends, a step of 2 is as good as one of 1.
    fn fair(n: u32) -> Vec<Vec<Made>> {
        let step = |i: u32, by: u32| (vec![(i - by, 0.5), (i + by, 0.5)], None);
        let group = |i: u32| match i {
            0 => vec![(vec![(1, 0.5)], Some((0.0, 0.5)))],
            i if i == n - 1 => vec![(vec![(i - 1, 0.5)], Some((1.0, 0.5)))],
            i if i == 1 || i == n - 2 => vec![step(i, 1)],
            i => vec![step(i, 2), step(i, 1)],
        };
        (0..n).map(group).collect()
    }

    #[test]
    fn bounds_are_narrow_where_all_actions_are_equally_good() {
        for sense in [Sense::Max, Sense::Min] {
            let fair = sparse(sense, &fair(300));
            let found = solve(&fair).unwrap();
            for (i, (low, high)) in found.low.iter().zip(&found.high).enumerate() {
                let value = (i + 1) as f64 / 301.0;
                assert!(*low <= value && value <= *high, "{i}: {low} {high}");
                assert!(low < high && high - low < 1e-8, "{i}: {low} {high}");
            }
        }
    }

    #[test]
    fn a_component_that_is_hardly_left_has_no_narrow_bounds() {
        let rare = 2.0f64.powi(-40);
        let group = |i: u32| vec![(vec![((i + 1) % 50, 1.0 - rare)], Some((0.5, rare)))];
        let ring = sparse(Sense::Max, &(0..50).map(group).collect::<Vec<_>>());
        assert!(solve(&ring).is_none_or(|found| !ring.is_narrow(&found.low, &found.high)));
    }
}
