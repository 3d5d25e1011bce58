//! Bounds of the optimal values of a component by policy iteration with doubles, and one step that
//! confirms them.
//!
//! [`super::component`] computes with intervals, which hold by themselves but are slow, and whose widths
//! add up along the elimination. Here a policy is evaluated by elimination with doubles, without a claim.
//! Then bounds near its values x are tested by one step that is rounded outwards:
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
//! is wide, intervals are narrower.

use super::component::Sense;
use super::eliminate::{self, Row};
use super::iterate::{Found, Sparse};
use super::meter::Meter;
use super::pace::Patience;
use super::solve::NONE;
use super::sparse::TINY;
use meliora_model::error::Result;

/// Sweeps of value iteration before policy iteration, and between two evaluations of policies.
const SWEEPS: usize = 32;
const BETWEEN: usize = 8;
/// The number of entries per row that elimination may touch if there is little patience, and that of all rows: they
/// take about two seconds.
const FILL: usize = 4096;
const MOST_FILL: usize = 1 << 29;
/// Changes of the policy.
const ROUNDS: usize = 64;
/// The margin of a step, in rounding errors, that is tried first; the factor for the next attempts, and
/// their number.
const MARGIN: f64 = 4.0;
const WIDER: f64 = 4.0;
const ATTEMPTS: usize = 6;
/// Sweeps over the equations of the last policy. Along the elimination, errors of rounding add up; what counts
/// is only by how much each equation is missed.
const SMOOTH: usize = 8;
/// The width of bounds, relative above 1, from which they are of no use.
const WIDE: f64 = 1e-7;

/// Returns narrow bounds of the groups; `None` if none were found, or, with little patience, if rows fill in.
///
/// # Errors
/// A limit is reached.
pub(super) fn solve(sparse: &Sparse, patience: Patience, meter: &mut Meter<'_>) -> Result<Option<Found>> {
    if sparse.least < TINY {
        return Ok(None);
    }
    let most = match patience {
        Patience::Little => MOST_FILL.min(FILL * sparse.groups()),
        Patience::Much => usize::MAX,
    };
    let work = Work { sparse, most };
    let Some(policy) = sparse.leaving_policy(meter)? else { return Ok(None) };
    let policy: Policy = policy.into_iter().map(|action| action as usize).collect();
    let start = match sparse.sense {
        Sense::Max => vec![0.0; policy.len()],
        Sense::Min => match work.values(&policy, meter)? {
            Some(x) => work.side(&x),
            None => return Ok(None),
        },
    };
    let policy = work.greedy(policy, start, SWEEPS, meter)?;
    let Some((policy, mut x)) = work.improve(policy, meter)? else { return Ok(None) };
    work.smooth(&policy, &mut x, meter)?;
    let most = x.iter().fold(0.0, |most: f64, x| most.max(x.high));
    let mut margin = MARGIN * (sparse.error * most + TINY);
    for _ in 0..ATTEMPTS {
        if let Some(found) = work.bounds(&policy, &x, margin, meter)? {
            return Ok(Some(found).filter(|found| is_narrow(found, sparse.inherited)));
        }
        margin *= WIDER;
    }
    Ok(None)
}

fn is_narrow(found: &Found, inherited: f64) -> bool {
    let narrow = |(low, high): (&f64, &Option<f64>)| {
        high.is_some_and(|high| high - low <= WIDE * low.max(1.0) + 2.0 * inherited)
    };
    found.low.iter().zip(&found.high).all(narrow)
}

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

struct Work<'s> {
    sparse: &'s Sparse,
    /// The greatest number of entries that an elimination may touch.
    most: usize,
}

impl Work<'_> {
    /// Replaces a policy by the one that looks best after some sweeps of value iteration: from 0 for the
    /// greatest values, from those of the policy for the least ones. So it keeps leaving the component.
    fn greedy(
        &self,
        mut policy: Policy,
        mut x: Vec<f64>,
        most: usize,
        meter: &mut Meter<'_>,
    ) -> Result<Policy> {
        let upper = self.sparse.sense == Sense::Max;
        for _ in 0..most {
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

    /// Returns the values of a policy; `None` if it does not leave the component.
    fn values(&self, policy: &Policy, meter: &mut Meter<'_>) -> Result<Option<Vec<Values>>> {
        let constants = |_, action| {
            let ([low, high], _) = self.sparse.constant(action);
            [low, high, 1.0]
        };
        let found = self.evaluate(policy, constants, meter)?;
        let values = |[low, high, steps]: [f64; 3]| Values { low, high, steps };
        Ok(found.map(|x| x.into_iter().map(values).collect()))
    }

    /// Returns the values of a policy for the given constants of its actions; `None` if it does not leave
    /// the component.
    fn evaluate<const K: usize>(
        &self,
        policy: &Policy,
        constants: impl Fn(usize, usize) -> [f64; K],
        meter: &mut Meter<'_>,
    ) -> Result<Option<Vec<[f64; K]>>> {
        let mut rows = Vec::with_capacity(policy.len());
        let mut bytes = 0;
        for (group, &action) in policy.iter().enumerate() {
            let edges = self.sparse.row(self.sparse.edges(group, action)).collect::<Vec<_>>();
            let (_, escape) = self.sparse.constant(action);
            bytes += edges.len() * size_of::<(u32, f64)>() + size_of::<Row<f64, [f64; K]>>();
            rows.push(Row { edges, escape, constant: constants(group, action) });
        }
        let found = meter.take(bytes).and_then(|()| eliminate::solve(rows, self.most, meter));
        meter.release(bytes);
        Ok(found?.filter(|x| x.iter().flatten().all(|x| x.is_finite())))
    }

    /// Improves a policy until no action is clearly better; returns it with its values. `None` if it does
    /// not settle. Between two evaluations, sweeps of value iteration carry changes on to other groups.
    fn improve(&self, mut policy: Policy, meter: &mut Meter<'_>) -> Result<Option<(Policy, Vec<Values>)>> {
        for _ in 0..ROUNDS {
            let Some(x) = self.values(&policy, meter)? else { return Ok(None) };
            let better = self.greedy(policy.clone(), self.side(&x), BETWEEN, meter)?;
            if better == policy {
                return Ok(Some((policy, x)));
            }
            policy = better;
        }
        Ok(None)
    }

    /// Replaces the values of a policy by those that its equations yield.
    fn smooth(&self, policy: &Policy, x: &mut [Values], meter: &mut Meter<'_>) -> Result<()> {
        for _ in 0..SMOOTH {
            for (group, &action) in policy.iter().enumerate() {
                meter.step()?;
                let ([mut low, mut high], _) = self.sparse.constant(action);
                for (to, p) in self.sparse.row(self.sparse.edges(group, action)) {
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

    /// Returns bounds with a margin per step; `None` if one step does not confirm them.
    fn bounds(
        &self,
        policy: &Policy,
        x: &[Values],
        margin: f64,
        meter: &mut Meter<'_>,
    ) -> Result<Option<Found>> {
        let own = |x: &Values| margin * x.steps;
        let Some(others) = self.slack(policy, x, margin, meter)? else { return Ok(None) };
        let (low, high): (Vec<f64>, Vec<f64>) = match self.sparse.sense {
            Sense::Max => x.iter().zip(&others).map(|(x, g)| (x.low - own(x), x.high + g)).unzip(),
            Sense::Min => x.iter().zip(&others).map(|(x, g)| (x.low - g, x.high + own(x))).unzip(),
        };
        // 0 is a lower bound in any case, also as a part of others.
        let low: Vec<f64> = low.into_iter().map(|x| x.max(0.0)).collect();
        for group in 0..x.len() {
            meter.step()?;
            let lower = match self.sparse.sense {
                Sense::Max => self.sparse.below(policy[group], self.sparse.edges(group, policy[group]), &low),
                Sense::Min => self.sparse.best(group, false, &low).0,
            };
            if lower < low[group] || self.sparse.best(group, true, &high).0 > high[group] {
                return Ok(None);
            }
        }
        let pick = |&action: &usize| self.sparse.choices.get(action).copied().unwrap_or(NONE);
        let picks = policy.iter().map(pick).collect();
        Ok(Some(Found { low, high: high.into_iter().map(Some).collect(), picks }))
    }

    /// Returns g with g ≥ margin - gap(a) + P_a g for every action, nearly; `None` if it is not found.
    fn slack(
        &self,
        policy: &Policy,
        x: &[Values],
        margin: f64,
        meter: &mut Meter<'_>,
    ) -> Result<Option<Vec<f64>>> {
        let side = self.side(x);
        let gap = |group: usize, action: usize, edges: std::ops::Range<usize>| {
            let q = self.sparse.sum(action, edges, self.sparse.sense == Sense::Max, &side);
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
                for (action, edges) in self.sparse.actions(group) {
                    let next: f64 = self.sparse.row(edges.clone()).map(|(to, p)| p * g[to as usize]).sum();
                    // Most actions are much worse.
                    if margin + next <= most {
                        continue;
                    }
                    let gain = margin - gap(group, action, edges) + next;
                    if gain > most {
                        (most, longest[group], settled) = (gain, action, false);
                    }
                }
            }
            if settled {
                return Ok(Some(g));
            }
            let constants =
                |group: usize, action| [margin - gap(group, action, self.sparse.edges(group, action))];
            let Some(found) = self.evaluate(&longest, constants, meter)? else { return Ok(None) };
            g = found.into_iter().map(|[g]| g.max(0.0)).collect();
        }
        Ok(None)
    }
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
                let (value, escape) = exit.unwrap_or_default();
                sparse.push(group, edges.iter().copied(), [value * escape, value * escape, value, escape]);
            }
        }
        sparse.begin(groups.len() as u32);
        sparse
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
            let found = solve(&fair, Patience::Much, &mut Meter::unlimited(&NoProgress)).unwrap().unwrap();
            for (i, (low, high)) in found.low.iter().zip(&found.high).enumerate() {
                let (value, high) = ((i + 1) as f64 / 301.0, high.unwrap());
                assert!(*low <= value && value <= high, "{i}: {low} {high}");
                assert!(low < &high && high - low < 1e-8, "{i}: {low} {high}");
            }
        }
    }

    #[test]
    fn a_component_that_is_hardly_left_has_no_narrow_bounds() {
        let rare = 2.0f64.powi(-40);
        let group = |i: u32| vec![(vec![((i + 1) % 50, 1.0 - rare)], Some((0.5, rare)))];
        let ring = sparse(Sense::Max, &(0..50).map(group).collect::<Vec<_>>());
        assert!(solve(&ring, Patience::Much, &mut Meter::unlimited(&NoProgress)).unwrap().is_none());
    }
}
