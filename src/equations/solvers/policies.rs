//! Policy iteration: the only solver of a component that needs no bounds to start from.
//!
//! A policy is evaluated component by component ([`crate::solvers::chain`]). It is changed only where another action
//! is better, so policies never get worse, never cycle, and keep leaving the component: an action that is merely as good
//! is never taken. With fractions, the last policy is optimal, and its values are those of the component.
//!
//! In a game, the side that does not lead answers: its policy is improved until it is a best answer to that of the leading
//! side, which is changed only then. A. Hoffman and R. Karp, "On nonterminating stochastic games" (1966). Since the leading
//! side changes its policy only where that is better, it never gives the other side a way to stay in the component that is
//! bad for it.
//!
//! With doubles, the values x of the last policy are near those of the component, without a claim. So the same equations
//! are solved with a margin m that each step gains or pays, some multiple of the rounding error, and one step that is
//! rounded outwards confirms the solution. For the last policy, that is x ± m · t, where t is the expected number of steps.
//! Some sweeps widen these bounds where another action is better by less than the slack; if that takes too many, the policy
//! is improved with the margin:
//!
//! - If B(U) ≤ U for a finite U ≥ 0, the least solution is not above U.
//! - If L ≤ B(L) for the actions of a policy of the leading side with which no path stays in the component forever without
//!   a gain, and for all actions of the other side, the values are not below L. For costs until a target,
//!   minimisers lead: the same holds for upper bounds, and L ≤ B(L) must hold for every action, since a policy that
//!   never leaves costs infinitely much.
//!
//! The width is some 1e-14 times the greatest number of steps, and some 1e-12 times where sweeps widen it by the slack. Where
//! components are left so rarely that this is wide, fractions are needed.

use std::ops::Range;

use crate::graphs::meter::{Meter, Stop, Turn, spend};
use crate::solvers::chain::{self, Chain};
use crate::solvers::groups::{Entry, greatest, slack};
use crate::solvers::rows::{Constant, GroupBounds, Rows, TINY};
use meliora_base::error::Result;
use meliora_base::exact::Ratio;
use meliora_base::number::{Number, Weight};
use meliora_model::Optimum;

/// Changes of a policy of doubles after which it is not expected to settle, and sweeps that are worth one change.
pub(crate) const ROUNDS: usize = 64;

/// Sweeps that are worth less than an evaluation of a policy, or an upper bound of a candidate of iteration.
pub(crate) const SWEEPS: usize = 8;

/// The margin of a step, in rounding errors, that is tried first, and the factor for the next attempts.
pub(crate) const MARGIN: f64 = 4.0;

/// Values of the groups, first on the side of the leading optimum.
type Both = (Vec<f64>, Vec<f64>);

/// Policy iteration, which continues in each turn with the policy of the last one.
pub(crate) struct Policies<'r, N> {
    rows: &'r Rows<N>,
    /// An action of each group, if the iteration has begun.
    pub(crate) policy: Vec<usize>,
    /// The work that may be done in this turn.
    left: usize,
}

impl<'r, N: Entry> Policies<'r, N> {
    pub(crate) fn new(rows: &'r Rows<N>) -> Self {
        Policies { rows, policy: Vec::new(), left: usize::MAX }
    }

    /// Returns the choices of the best policy so far; an empty list if there is none.
    pub(crate) fn picks(&self) -> Vec<u32> {
        self.policy.iter().map(|&action| self.rows.choices[action]).collect()
    }

    /// Starts a turn with some work. The first one begins with the policy `seen`, if it has a choice for each group, else
    /// with any that leaves the component.
    pub(crate) fn begin(&mut self, seen: &[u32], budget: usize, meter: &mut Meter<'_>) -> Turn<()> {
        self.left = budget;
        if !self.policy.is_empty() {
            return Ok(());
        }
        let action = |(group, choice): (usize, &u32)| {
            self.rows.actions(group).find(|&action| self.rows.choices[action] == *choice)
        };
        let known: Option<Vec<usize>> = seen.iter().enumerate().map(action).collect();
        let leaving = self.rows.leaving_policy(meter)?.ok_or(Stop::Never)?;
        self.policy = match known.filter(|known| known.len() == leaving.len()) {
            Some(known) if self.rows.proceeds(&known, meter)? => known,
            _ => leaving,
        };
        Ok(())
    }

    /// Improves the policy until no action is better by more than `slack` of the values; returns its values. `constant`
    /// returns the constant of an action.
    ///
    /// # Errors
    /// Some group cannot leave the component, or the policy does not settle; more work is needed than is left; a limit is
    /// reached.
    pub(crate) fn improve(
        &mut self,
        constant: impl Fn(usize) -> N,
        slack: impl Fn(&[N]) -> N,
        meter: &mut Meter<'_>,
    ) -> Turn<Vec<N>> {
        self.improve_sides(&[false, true], &constant, slack, meter)
    }

    /// Does the same for some sides: the leading one (true) is changed where the other one (false) is not.
    fn improve_sides(
        &mut self,
        sides: &[bool],
        constant: &impl Fn(usize) -> N,
        slack: impl Fn(&[N]) -> N,
        meter: &mut Meter<'_>,
    ) -> Turn<Vec<N>> {
        for _ in 0..rounds::<N>() {
            let own = self.policy.iter().map(|&action| constant(action)).collect();
            let mut x = match self.evaluate(own, meter) {
                Err(Stop::Never) => {
                    self.policy = self.other_leaving(meter)?.ok_or(Stop::Never)?;
                    continue;
                }
                end => end?,
            };
            if x.iter().filter_map(N::double).any(|x| !x.is_finite()) {
                return Err(Stop::Never);
            }
            let (slack, mut changed) = (slack(&x), false);
            for &leads in sides {
                changed = changed || self.change(leads, constant, &mut x, &slack, meter)?;
            }
            if !changed {
                return Ok(x);
            }
        }
        Err(Stop::Never)
    }

    /// Returns another policy that leaves the component, if there is one: with the same actions of the leading side, if
    /// possible.
    fn other_leaving(&self, meter: &mut Meter<'_>) -> Result<Option<Vec<usize>>> {
        let same = self.rows.leaving_with(&self.policy, meter)?.filter(|other| *other != self.policy);
        match same {
            Some(other) => Ok(Some(other)),
            None => Ok(self.rows.leaving_policy(meter)?.filter(|other| *other != self.policy)),
        }
    }

    /// Replaces the actions of a side of the policy with the values `x` by better ones, in some sweeps of value iteration;
    /// returns whether there are any: else no value has changed.
    ///
    /// # Errors
    /// More work is needed than is left; a limit is reached.
    fn change(
        &mut self,
        leads: bool,
        constant: &impl Fn(usize) -> N,
        x: &mut [N],
        slack: &N,
        meter: &mut Meter<'_>,
    ) -> Turn<bool> {
        let (rows, mut changed) = (self.rows, false);
        for _ in 0..sweeps::<N>() {
            let mut settled = true;
            for group in (0..x.len()).filter(|&group| rows.leads(group) == leads) {
                for action in rows.actions(group).filter(|_| rows.actions(group).len() > 1 || !N::Read::EXACT)
                {
                    meter.step()?;
                    let q = rows.value(action, constant(action), x);
                    spend(&mut self.left, (rows.row(action).len() + 1).saturating_mul(q.work()))?;
                    let is_better = match rows.optima[group] {
                        Optimum::Max => q > x[group].plus(slack),
                        Optimum::Min => x[group] > q.plus(slack),
                    };
                    if is_better {
                        (x[group], self.policy[group], settled) = (q, action, false);
                    }
                }
            }
            if settled {
                break;
            }
            changed = true;
        }
        Ok(changed)
    }

    /// Returns the values of the policy of the leading side against the best answers, for other constants of the actions.
    fn answered(
        &mut self,
        constant: impl Fn(usize) -> N,
        slack: impl Fn(&[N]) -> N,
        meter: &mut Meter<'_>,
    ) -> Turn<Vec<N>> {
        let policy = self.policy.clone();
        let found = self.improve_sides(&[false], &constant, slack, meter);
        match self
            .policy
            .iter()
            .enumerate()
            .any(|(group, &own)| self.rows.leads(group) && own != policy[group])
        {
            // The policy did not leave the component.
            true => Err(Stop::Never),
            false => found,
        }
    }

    /// Returns the values of the policy for the constants of its actions: one or several of each.
    ///
    /// # Errors
    /// Some group cannot leave the component; more work is needed than is left; a limit is reached.
    pub(crate) fn evaluate(&mut self, own: Vec<N>, meter: &mut Meter<'_>) -> Turn<Vec<N>> {
        let policy = Policy { rows: self.rows, actions: &self.policy };
        chain::solve(&policy, own, &mut self.left, meter)
    }
}

/// The chain of the groups under a policy.
pub(crate) struct Policy<'r, N> {
    pub(crate) rows: &'r Rows<N>,
    /// The action of each group.
    pub(crate) actions: &'r [usize],
}

impl<N: Entry> Chain<N> for Policy<'_, N> {
    fn nodes(&self) -> usize {
        self.actions.len()
    }

    fn positions(&self, group: u32) -> Range<u32> {
        self.rows.positions(self.actions[group as usize])
    }

    fn edge(&self, position: u32) -> (u32, &N) {
        self.rows.edge(position)
    }

    fn escape(&self, group: u32) -> &N {
        &self.rows.constant(self.actions[group as usize]).escape
    }
}

impl Policies<'_, Ratio> {
    /// Solves the component, if that takes no more work than `budget`; see [`Policies::begin`] for `seen`.
    ///
    /// # Errors
    /// Some group cannot leave the component, or gains without an end; more work is needed; a limit is reached.
    pub(crate) fn exact(
        &mut self,
        seen: &[u32],
        budget: usize,
        meter: &mut Meter<'_>,
    ) -> Turn<GroupBounds<Ratio>> {
        self.begin(seen, budget, meter)?;
        // No policy of the leading side is beyond the values on the side of its optimum.
        let (rows, upper) = (self.rows, self.rows.leads_up());
        let x = self.improve(|action| rows.bound(action, upper).clone(), |_| Ratio::zero(), meter)?;
        if !self.rows.proceeds(&self.policy, meter)? {
            return Err(Stop::Never);
        }
        let own = match rows.has_points() {
            true => x.clone(),
            false => self.answered(|action| rows.bound(action, !upper).clone(), |_| Ratio::zero(), meter)?,
        };
        let (low, high) = if upper { (own, x) } else { (x, own) };
        Ok(GroupBounds { low, high, picks: self.picks() })
    }
}

impl<'r> Policies<'r, f64> {
    /// Looks for bounds of the groups, which may be wide; see [`Policies::begin`] for `seen`.
    ///
    /// # Errors
    /// Policies are not found; the work takes more than `budget`; a limit is reached.
    pub(crate) fn bounds(&mut self, seen: &[u32], budget: usize, meter: &mut Meter<'_>) -> Turn<GroupBounds> {
        if self.rows.least < TINY {
            return Err(Stop::Never);
        }
        self.begin(seen, budget, meter)?;
        if self.rows.choices.len() > self.rows.groups() {
            let (rows, upper) = (self.rows, self.rows.leads_up());
            self.improve(|action| *rows.bound(action, upper), slack, meter)?;
        }
        let (mut margin, mut found) = self.moved(meter)?;
        while !self.confirm(&mut found, meter)? {
            if !self.rows.is_narrow(&found.low, &found.high) {
                return Err(Stop::Never);
            }
            let sides = self.improved_by(margin, meter)?;
            found = self.smoothed(sides, margin, meter)?;
            margin *= MARGIN;
        }
        Ok(found)
    }

    /// Returns a margin of some rounding errors, and the values of the policy where each step gains or pays it: they are moved
    /// by the margin times the expected number of steps.
    fn moved(&mut self, meter: &mut Meter<'_>) -> Turn<(f64, GroupBounds)> {
        let upper = self.rows.leads_up();
        let own = |&action: &usize| {
            let &Constant { low, high, .. } = self.rows.constant(action);
            if upper { [high, low, 1.0] } else { [low, high, 1.0] }
        };
        let found = self.evaluate(self.policy.iter().flat_map(own).collect(), meter)?;
        if !found.iter().all(|x| x.is_finite()) {
            return Err(Stop::Never);
        }
        let values = found.as_chunks::<3>().0;
        let margin = MARGIN * (self.rows.error * greatest(values.iter().map(|[best, ..]| best)) + TINY);
        let by = if upper { margin } else { -margin };
        let sides = values.iter().map(|[best, other, steps]| (best + by * steps, other - by * steps));
        Ok((margin, self.as_bounds(sides.unzip())))
    }

    /// Improves the policy where each step gains or pays a margin; returns its values, and those of the leading side against
    /// the best answers for a margin of the other sign.
    fn improved_by(&mut self, margin: f64, meter: &mut Meter<'_>) -> Turn<Both> {
        let upper = self.rows.leads_up();
        let best = self.improve(self.with_margin(upper, margin), |_| margin / MARGIN, meter)?;
        let other = self.answered(self.with_margin(!upper, margin), |_| margin / MARGIN, meter)?;
        match other.iter().all(|x| x.is_finite()) {
            true => Ok((best, other)),
            false => Err(Stop::Never),
        }
    }

    /// Returns the values on both sides as bounds, after some sweeps with the margin of a step.
    fn smoothed(
        &self,
        (mut best, mut other): Both,
        margin: f64,
        meter: &mut Meter<'_>,
    ) -> Result<GroupBounds> {
        let upper = self.rows.leads_up();
        self.smooth(self.with_margin(upper, margin), &mut best, meter)?;
        self.smooth(self.with_margin(!upper, margin), &mut other, meter)?;
        Ok(self.as_bounds((best, other)))
    }

    /// Returns values on both sides as bounds, with the choices of the policy.
    fn as_bounds(&self, (best, other): Both) -> GroupBounds {
        let (low, high) = if self.rows.leads_up() { (other, best) } else { (best, other) };
        // 0 is a lower bound in any case, also as a part of others.
        let low = low.into_iter().map(|x| x.max(0.0)).collect();
        GroupBounds { low, high, picks: self.picks() }
    }

    /// Returns the bound of the constant of each action, moved outwards by a margin. In a component of both sides, the upper
    /// bound of an action with one successor needs none: where both can stay, each step would have to be better than the one
    /// before.
    fn with_margin(&self, upper: bool, margin: f64) -> impl Fn(usize) -> f64 + use<'r> {
        let (rows, by) = (self.rows, if upper { margin } else { -margin });
        let spares_copies = upper && rows.is_mixed();
        move |action| match spares_copies && rows.copies(action) {
            true => *rows.bound(action, upper),
            false => rows.bound(action, upper) + by,
        }
    }

    /// Replaces the values of the policy by those that its equations yield. Along the elimination, errors of rounding
    /// add up; what counts is only by how much each equation is missed.
    fn smooth(&self, constant: impl Fn(usize) -> f64, x: &mut [f64], meter: &mut Meter<'_>) -> Result<()> {
        for _ in 0..SWEEPS {
            for (group, &action) in self.policy.iter().enumerate() {
                meter.step()?;
                x[group] = self.rows.value(action, constant(action), x);
            }
        }
        Ok(())
    }

    /// Widens bounds until one step confirms them; returns false if that takes more than some sweeps.
    fn confirm(&self, bounds: &mut GroupBounds, meter: &mut Meter<'_>) -> Result<bool> {
        let GroupBounds { low, high, .. } = bounds;
        for _ in 0..SWEEPS {
            let mut holds = true;
            for group in 0..low.len() {
                meter.step()?;
                let (lower, upper) = self.after_step(group, low, high);
                holds &= low[group] <= lower && upper <= high[group];
                (low[group], high[group]) = (low[group].min(lower), high[group].max(upper));
            }
            if holds {
                return self.rows.proceeds(&self.policy, meter);
            }
        }
        Ok(false)
    }

    /// Returns the bounds of a group after one step from others. The leading side guarantees one of them by its policy.
    fn after_step(&self, group: usize, low: &[f64], high: &[f64]) -> (f64, f64) {
        let (rows, action) = (self.rows, self.policy[group]);
        let own = |upper: bool| rows.leads(group) && upper != rows.leads_up();
        let lower = if own(false) { rows.below(action, low) } else { rows.best(group, false, low).0 };
        let upper = if own(true) { rows.above(action, high) } else { rows.best(group, true, high).0 };
        (lower, upper)
    }
}

/// Returns the number of changes of a policy after which it is not expected to settle: fractions always do.
pub(crate) fn rounds<N: Entry>() -> usize {
    if N::Read::EXACT { usize::MAX } else { ROUNDS }
}

/// Returns the number of sweeps of value iteration between two evaluations of policies: fractions would become long.
pub(crate) fn sweeps<N: Entry>() -> usize {
    if N::Read::EXACT { 1 } else { SWEEPS }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solvers::rows;
    use meliora_engine::NoProgress;

    /// An action: its edges, and an exit with its value and probability.
    type Made = (Vec<(u32, f64)>, Option<(f64, f64)>);

    fn sparse(optimum: Optimum, groups: &[Vec<Made>]) -> Rows<f64> {
        let mut sparse = Rows::empty(optimum, vec![optimum; groups.len()]);
        (sparse.error, sparse.least) = (16.0 * f64::EPSILON, 0.5);
        for (group, actions) in (0..).zip(groups) {
            sparse.begin(group);
            for (edges, exit) in actions {
                let (most, escape) = exit.unwrap_or_default();
                let (low, high) = (most * escape, most * escape);
                sparse.push(group, edges.iter().copied(), rows::Constant { low, high, most, escape });
            }
        }
        sparse.begin(groups.len() as u32);
        sparse
    }

    fn solve(sparse: &Rows<f64>) -> Option<GroupBounds> {
        let seen = Vec::new();
        Policies::new(sparse).bounds(&seen, usize::MAX, &mut Meter::unlimited(&NoProgress)).ok()
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
        for optimum in [Optimum::Max, Optimum::Min] {
            let fair = sparse(optimum, &fair(300));
            let found = solve(&fair).unwrap();
            for (i, (low, high)) in found.low.iter().zip(&found.high).enumerate() {
                let value = (i + 1) as f64 / 301.0;
                assert!(*low <= value && value <= *high, "{i}: {low} {high}");
                assert!(low < high && high - low < 1e-8, "{i}: {low} {high}");
            }
        }
    }

    #[test]
    fn bounds_contain_gains_below_the_slack() {
        for (optimum, other) in [(Optimum::Min, 1.0 - 1e-13), (Optimum::Max, 1.0 + 1e-13)] {
            let exit = |value| (Vec::new(), Some((value, 1.0)));
            let GroupBounds { low, high, .. } =
                solve(&sparse(optimum, &[vec![exit(1.0), exit(other)]])).unwrap();
            assert!(low[0] <= other && other <= high[0] && high[0] - low[0] < 2e-13, "{low:?} {high:?}");
        }
    }

    #[test]
    fn a_component_that_is_hardly_left_has_no_narrow_bounds() {
        let rare = 2.0f64.powi(-40);
        let group = |i: u32| vec![(vec![((i + 1) % 50, 1.0 - rare)], Some((0.5, rare)))];
        let ring = sparse(Optimum::Max, &(0..50).map(group).collect::<Vec<_>>());
        let found = solve(&ring).unwrap();
        assert!(!ring.is_narrow(&found.low, &found.high));
        assert!(found.low.iter().zip(&found.high).all(|(low, high)| (0.3..0.5).contains(low) && *high > 0.5));
    }
}
