//! Bounds of the optimal values of a large component all of whose cycles pass through a few groups.
//!
//! Such groups are a feedback vertex set H: the charger of a robot whose battery decreases, the start of a round.
//! Other groups come after those that they lead to, so one sweep yields their values from those of H. For a policy
//! and the steps from a group until H is met again, let a be the expected gain or cost, values at exits included, e
//! the probability to leave the component, and w_j that to meet group j of H. A pass over the chain of the policy
//! yields each of these. Then x_i · (e_i + Σ_{j≠i} w_ij) = a_i + Σ_{j≠i} w_ij x_j for the groups i of H, which
//! elimination solves. The policy that is best for these values is the next one: policy iteration takes a few
//! rounds where value iteration takes as many sweeps as a cycle has to be repeated.
//!
//! All of this is computed with doubles, without a claim. Then values at H are moved by a margin, in proportion to
//! the expected number of times that H is met, or to the values: so one sweep moves them back. If it does when it is
//! rounded outwards, they are bounds. It satisfies the equations of the other groups in any case:
//!
//! - If B(U) ≤ U for a finite U ≥ 0, the least solution is not above U.
//! - If L ≤ B(L) for a finite L, it is not below L: a policy that attains B(L) leaves the component almost
//!   surely, or gains infinitely much. For least costs, the best policy leaves it.
//!
//! H is read off the order of the groups; [`super::order`] finds an order where H is small.

use super::component::Sense;
use super::eliminate::{self, Row};
use super::iterate::{Found, Sparse};
use super::meter::Meter;
use super::solve::NONE;
use super::sparse::TINY;
use meliora_model::error::Result;

/// The greatest number of groups in H.
pub(super) const MOST: usize = 8;
/// Changes of the policy.
const ROUNDS: usize = 64;
/// The relative change of the values at H that ends policy iteration: above the error of a sweep.
const SETTLED: f64 = 1e-11;
/// The relative margins that are tried.
const MARGINS: [f64; 3] = [1e-11, 1e-10, 1e-9];

/// Returns narrow bounds of the groups, which are at most `top` if it is given; `None` if H is too large, or
/// none were found. Time: a sweep over all actions and |H| + 1 passes over the chain of a policy per round.
///
/// # Errors
/// A limit is reached.
pub(super) fn solve(sparse: &Sparse, top: Option<f64>, meter: &mut Meter<'_>) -> Result<Option<Found>> {
    if sparse.least < TINY {
        return Ok(None);
    }
    let Some(hubs) = hubs(sparse, meter)? else { return Ok(None) };
    let work = Work { sparse, hubs, top: top.unwrap_or(f64::MAX) };
    let Some(mut policy) = sparse.leaving_policy(meter)? else { return Ok(None) };
    let Some(low) = work.settle(false, &mut policy, meter)? else { return Ok(None) };
    let high = match sparse.is_exact() {
        true => low.clone(),
        false => match work.settle(true, &mut policy, meter)? {
            Some(high) => high,
            None => return Ok(None),
        },
    };
    let Some(lower) = work.confirm(false, &low, meter)? else { return Ok(None) };
    let Some(upper) = work.confirm(true, &high, meter)? else { return Ok(None) };
    let policy = if sparse.sense == Sense::Max { lower.policy } else { upper.policy };
    let picks = policy.into_iter().map(|action| sparse.choices[action as usize]).collect();
    Ok(Some(Found { low: lower.x, high: upper.x.into_iter().map(Some).collect(), picks }))
}

/// Returns the groups that are entered from groups before or at them; `None` if they are more than [`MOST`].
fn hubs(sparse: &Sparse, meter: &mut Meter<'_>) -> Result<Option<Vec<usize>>> {
    let mut hubs = Vec::new();
    for group in 0..sparse.groups() {
        meter.step()?;
        for (to, _) in sparse.actions(group).flat_map(|(_, edges)| sparse.row(edges)) {
            let to = to as usize;
            if to >= group && !hubs.contains(&to) {
                hubs.push(to);
            }
        }
        if hubs.len() > MOST {
            return Ok(None);
        }
    }
    hubs.sort_unstable();
    Ok(Some(hubs))
}

/// The number of an action of each group.
type Policy = Vec<u32>;

/// A group of H: the value of a policy, and the expected number of times that H is met from there on, itself counted.
#[derive(Debug, Clone)]
struct Hub {
    value: f64,
    rounds: f64,
}

/// Bounds of all groups on one side, and the actions that attain them.
struct Side {
    x: Vec<f64>,
    policy: Policy,
}

struct Work<'s> {
    sparse: &'s Sparse,
    /// H, in the order of the groups.
    hubs: Vec<usize>,
    /// The greatest value.
    top: f64,
}

impl Work<'_> {
    /// Improves a policy until the values at H settle; returns these. `None` if they do not.
    fn settle(&self, upper: bool, policy: &mut Policy, meter: &mut Meter<'_>) -> Result<Option<Vec<Hub>>> {
        let mut x = vec![0.0; policy.len()];
        let Some(mut hubs) = self.evaluate(upper, policy, &mut x, meter)? else { return Ok(None) };
        for round in 0..ROUNDS {
            meter.progress(&|| format!("policy {} of {} states", round + 1, policy.len()));
            let changed = self.improve(upper, &hubs, policy, &mut x, meter)?;
            let Some(better) = self.evaluate(upper, policy, &mut x, meter)? else { return Ok(None) };
            let near = |(a, b): (&Hub, &Hub)| (a.value - b.value).abs() <= SETTLED * a.value.max(b.value);
            if !changed || hubs.iter().zip(&better).all(near) {
                return Ok(Some(better));
            }
            hubs = better;
        }
        Ok(None)
    }

    /// Replaces the actions of a policy by clearly better ones, given its values at H; returns whether there are any.
    /// An action that is merely as good may lead round and round. `x` is overwritten.
    fn improve(
        &self,
        upper: bool,
        hubs: &[Hub],
        policy: &mut Policy,
        x: &mut [f64],
        meter: &mut Meter<'_>,
    ) -> Result<bool> {
        self.hubs.iter().zip(hubs).for_each(|(&hub, of)| x[hub] = of.value);
        let mut changed = false;
        for (group, own) in policy.iter_mut().enumerate() {
            meter.step()?;
            let edges = self.sparse.edges(group, *own as usize);
            let mut best = self.sparse.sum(*own as usize, edges, upper, x);
            for (action, edges) in self.sparse.actions(group) {
                let q = self.sparse.sum(action, edges, upper, x);
                if self.sparse.is_better(q, best) {
                    (best, *own, changed) = (q, action as u32, true);
                }
            }
            if !self.hubs.contains(&group) {
                x[group] = best;
            }
        }
        Ok(changed)
    }

    /// Computes the values of all groups from those at H, with the actions that attain them; returns the values
    /// that the equations of H yield then.
    fn sweep(
        &self,
        upper: bool,
        values: &[f64],
        x: &mut [f64],
        policy: &mut Policy,
        meter: &mut Meter<'_>,
    ) -> Result<Vec<f64>> {
        self.hubs.iter().zip(values).for_each(|(&hub, &value)| x[hub] = value);
        let mut next = Vec::with_capacity(self.hubs.len());
        self.sparse.sweep(upper, x, meter, |group, x, (q, action)| {
            policy[group] = action as u32;
            match self.hubs.get(next.len()) == Some(&group) {
                true => next.push(q),
                false => *x = q,
            }
        })?;
        Ok(next)
    }

    /// Returns the values of a policy at H; `None` if it does not leave the component. `x` is overwritten.
    fn evaluate(
        &self,
        upper: bool,
        policy: &Policy,
        x: &mut [f64],
        meter: &mut Meter<'_>,
    ) -> Result<Option<Vec<Hub>>> {
        let constant = |action| self.sparse.constant(action).0[usize::from(upper)];
        let constants = self.pass(policy, constant, None, x, meter)?;
        let escapes = self.pass(policy, |action| self.sparse.constant(action).1, None, x, meter)?;
        let row = |(constant, escape)| Row { edges: Vec::new(), escape, constant: [constant, 1.0] };
        let mut rows: Vec<Row<f64, [f64; 2]>> = constants.into_iter().zip(escapes).map(row).collect();
        if self.hubs.len() > 1 {
            for (to, &hub) in (0..).zip(&self.hubs) {
                let met = self.pass(policy, |_| 0.0, Some(hub), x, meter)?;
                for ((from, row), p) in (0..).zip(&mut rows).zip(met) {
                    row.edges.extend((from != to && p > 0.0).then_some((to, p)));
                }
            }
        }
        let found = eliminate::solve(rows, usize::MAX, meter)?;
        let finite = found.filter(|found| found.iter().flatten().all(|x| x.is_finite()));
        Ok(finite.map(|found| found.into_iter().map(|[value, rounds]| Hub { value, rounds }).collect()))
    }

    /// Computes c + Σ p · x for the action of each group, with x = 1 at one group of H, and 0 at the others; returns
    /// the results for H.
    fn pass(
        &self,
        policy: &Policy,
        constant: impl Fn(usize) -> f64,
        one: Option<usize>,
        x: &mut [f64],
        meter: &mut Meter<'_>,
    ) -> Result<Vec<f64>> {
        self.hubs.iter().for_each(|&hub| x[hub] = f64::from(u8::from(one == Some(hub))));
        let mut at_hubs = Vec::with_capacity(self.hubs.len());
        for (group, &action) in policy.iter().enumerate() {
            meter.step()?;
            let row = self.sparse.row(self.sparse.edges(group, action as usize));
            let sum = row.fold(constant(action as usize), |sum, (to, p)| sum + p * x[to as usize]);
            match self.hubs.get(at_hubs.len()) == Some(&group) {
                true => at_hubs.push(sum),
                false => x[group] = sum,
            }
        }
        Ok(at_hubs)
    }

    /// Returns bounds on one side near values at H; `None` if no margin makes them bounds.
    fn confirm(&self, upper: bool, hubs: &[Hub], meter: &mut Meter<'_>) -> Result<Option<Side>> {
        let n = self.sparse.groups();
        let mut side = Side { x: vec![0.0; n], policy: vec![NONE; n] };
        let per_round = hubs.iter().map(|hub| hub.value / hub.rounds).fold(f64::INFINITY, f64::min);
        let by_rounds: Vec<f64> = hubs.iter().map(|hub| hub.rounds * per_round).collect();
        let by_values: Vec<f64> = hubs.iter().map(|hub| hub.value).collect();
        // Both are the same for one group.
        let ways = [by_rounds, by_values].into_iter().take(hubs.len());
        for (by, margin) in ways.flat_map(|by| MARGINS.map(|margin| (by.clone(), margin))) {
            let moved = hubs.iter().zip(&by).map(|(hub, by)| match upper {
                true => (hub.value + margin * by + TINY).min(self.top),
                false => (hub.value - margin * by).max(0.0),
            });
            let moved: Vec<f64> = moved.collect();
            let next = self.sweep(upper, &moved, &mut side.x, &mut side.policy, meter)?;
            let holds = |(next, moved): (&f64, &f64)| if upper { next <= moved } else { next >= moved };
            if next.iter().zip(&moved).all(holds) {
                return Ok(Some(side));
            }
        }
        Ok(None)
    }
}

#[cfg(test)]
mod tests {
    use super::super::iterate;
    use super::super::pace::Patience;
    use super::*;
    use meliora_engine::NoProgress;
    use meliora_model::random::Draw;

    /// The groups of the components that are drawn.
    const GROUPS: u32 = 300;

    /// Returns a random component with a number of hubs, its last groups; all other edges enter earlier groups. The
    /// constants of an exit with a width have it, too.
    fn random(draw: &mut Draw, sense: Sense, hubs: u32, width: f64) -> Sparse {
        let mut sparse = Sparse::empty(sense);
        (sparse.error, sparse.least, sparse.inherited) = (16.0 * f64::EPSILON, 1.0 / 64.0, width);
        for group in 0..GROUPS {
            sparse.begin(group);
            for number in 0..=draw.below(3) {
                let back = GROUPS - 1 - draw.below(hubs as usize) as u32;
                let earlier = group.checked_sub(1 + draw.below(9) as u32);
                // The first groups, which every policy meets, leave the component by all actions.
                let rare = if number > 0 && group > 9 { 0.0 } else { 1.0 / 64.0 };
                let mut edges = vec![(earlier.unwrap_or(back), 0.75), (back, 0.25 - rare)];
                edges.retain(|edge| edge.0 != group);
                let escape = 1.0 - edges.iter().map(|edge| edge.1).sum::<f64>();
                let value = [0.0, 0.25, 1.0][draw.below(3)];
                let gain = if sense == Sense::Min { [1.0, 2.0, 5.0][draw.below(3)] } else { 0.0 };
                let (low, high) = (gain + escape * value, gain + escape * (value + width));
                let most = if gain > 0.0 { f64::INFINITY } else { value + width };
                sparse.push(group, edges.into_iter(), [low, high, most, escape]);
            }
        }
        sparse.begin(GROUPS);
        sparse
    }

    #[test]
    fn bounds_are_narrow_and_meet_those_of_iteration() {
        let mut narrow = 0;
        for (seed, sense) in (0..40).flat_map(|seed| [(seed, Sense::Max), (seed, Sense::Min)]) {
            let draw = &mut Draw::new(seed);
            let width = [0.0, 1e-9][draw.below(2)];
            let sparse = random(draw, sense, 1 + seed as u32 % 8, width);
            let meter = &mut Meter::unlimited(&NoProgress);
            let top = (sense == Sense::Max).then_some(1.0);
            let found = solve(&sparse, top, meter).unwrap();
            let found =
                found.unwrap_or_else(|| panic!("seed {seed}, {sense:?}: all cycles pass through hubs"));
            let (other, end) = iterate::solve(&sparse, top, Patience::Much, meter);
            narrow += u32::from(end.unwrap());
            for group in 0..GROUPS as usize {
                let (low, high) = (found.low[group], found.high[group].unwrap());
                let (a, b) = (other.low[group], other.high[group].unwrap_or(f64::INFINITY));
                assert!(low <= b && a <= high, "seed {seed}, {sense:?}, {group}: {low} {high}, {a} {b}");
                let most = 1e-9 * high.max(1.0) + 100.0 * width;
                assert!(high - low <= most, "seed {seed}, {sense:?}, {group}: {low} {high}");
            }
        }
        assert!(narrow > 60, "{narrow} components by iteration");
    }

    #[test]
    fn more_hubs_are_left_to_other_methods() {
        let sparse = random(&mut Draw::new(1), Sense::Max, MOST as u32 + 1, 0.0);
        assert!(solve(&sparse, Some(1.0), &mut Meter::unlimited(&NoProgress)).unwrap().is_none());
    }
}
