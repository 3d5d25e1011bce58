//! The optimal values of one strongly connected component, by policy iteration.
//!
//! End components in which nothing can be gained or paid are collapsed to one node, a *group*, so
//! that every policy for probabilities leaves the component. A policy is evaluated by elimination
//! ([`super::eliminate`]); its values are bounds from one side. It is changed only where another
//! action is *certainly* better, so policies never get worse, never cycle, and keep leaving the
//! component: an action that is merely as good is never taken, so ties cannot form a cycle.
//!
//! The bound from the other side is a certificate. With exact numbers, the last policy is optimal.
//! With intervals, let x be its values, and e(a) the largest amount by which an action may still be
//! better. If g ≥ e(a) + P_a g for every action a, then x + g is above the optimal values (below
//! them: x - g for costs), since they are the least solution of the optimality equations.

use num_traits::FromPrimitive;

use super::eliminate::{self, Row};
use super::meter::Meter;
use super::number::{Interval, Number, Weight};
use meliora_model::error::Result;
use meliora_model::exact::Ratio;

/// Sweeps of value iteration before policy iteration.
const SWEEPS: usize = 64;
/// The width of bounds, relative above 1, from which they are computed again with fractions.
const WIDE: f64 = 1e-9;
/// Attempts to find a certificate.
const ROUNDS: usize = 8;

/// The optimum that is wanted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Sense {
    Max,
    Min,
}

/// An action of a group: a choice of one of its nodes that may leave the group.
#[derive(Debug, Clone)]
pub(super) struct Action<N> {
    /// The choice, by its number in the graph.
    pub(super) choice: u32,
    /// The edges to other groups, and the probability to leave the component. Edges back to the
    /// group are left out.
    pub(super) row: Row<N>,
    /// The upper bound of the constant; that of `row` is the lower one.
    pub(super) high: N,
    /// The probability to leave the group.
    leaving: N,
}

impl<N: Number> Action<N> {
    /// Creates an action. `whole` says that no edge back to the group was left out: then it leaves
    /// the group with probability 1.
    pub(super) fn new(choice: u32, (row, high): (Row<N>, N), whole: bool) -> Self {
        let leaving = if whole { N::one() } else { row.leaving() };
        Action { choice, row, high, leaving }
    }

    /// Returns whether the action leaves its group with positive probability.
    pub(super) fn leaves(&self) -> bool {
        !self.leaving.is_zero()
    }

    fn constant(&self, upper: bool) -> &N {
        if upper { &self.high } else { &self.row.constant }
    }

    /// Returns the value of the action if the groups have the values `x`.
    fn value(&self, x: &[N], upper: bool) -> N {
        let sum = |sum: N, (to, p): &(u32, N)| sum.plus(&p.times(&x[*to as usize]));
        self.row.edges.iter().fold(self.constant(upper).clone(), sum).over(&self.leaving)
    }
}

/// A component: the actions of each group.
#[derive(Debug)]
pub(super) struct Component<N> {
    pub(super) sense: Sense,
    pub(super) actions: Vec<Vec<Action<N>>>,
}

/// The values of the groups, and the choice that each takes.
pub(super) struct Optimum<N> {
    pub(super) low: Vec<N>,
    /// The upper bounds; `None` if none could be certified.
    pub(super) high: Vec<Option<N>>,
    /// The choice by which each group is left, or [`NONE`](super::solve::NONE).
    pub(super) picks: Vec<u32>,
}

impl<N: Number> Optimum<N> {
    /// Returns whether some bounds are further apart than rounding explains in most models.
    pub(super) fn is_wide(&self) -> bool {
        self.low.iter().zip(&self.high).any(|(low, high)| {
            let (low, high) = (low.bounds().lower, high.as_ref().map_or(f64::INFINITY, |x| x.bounds().upper));
            high - low > WIDE * low.max(1.0)
        })
    }
}

impl<N: Number> Component<N> {
    /// Returns whether all constants are finite.
    pub(super) fn is_bounded(&self) -> bool {
        self.actions.iter().flatten().all(|action| action.high.bounds().upper.is_finite())
    }

    /// Solves the component; `None` if some group cannot leave it.
    pub(super) fn solve(&self, meter: &mut Meter<'_>) -> Result<Option<Optimum<N>>> {
        let Some(mut policy) = self.leaving_policy() else { return Ok(None) };
        if self.sense == Sense::Max {
            self.greedy(&mut policy, meter)?;
        }
        // The side of the certificate is that of the optimum: no policy is beyond it.
        let upper = self.sense == Sense::Max;
        let everything = |_: usize, _: usize| true;
        let Some(x) = self.improve(&mut policy, upper, &everything, meter)? else { return Ok(None) };
        let Some(own) = self.evaluate(&policy, !upper, meter)? else { return Ok(None) };
        let slack = self.certificate(&policy, &x, meter)?;
        let side = |(x, g): (&N, &Option<N>)| match (self.sense, g) {
            (Sense::Max, Some(g)) => Some(x.high().plus(g)),
            (Sense::Max, None) => None,
            (Sense::Min, Some(g)) => Some(x.less(g)),
            (Sense::Min, None) => Some(N::zero()),
        };
        let sides = x.iter().zip(&slack).map(side);
        let pick = |(actions, &number): (&Vec<Action<N>>, &usize)| actions[number].choice;
        let picks = self.actions.iter().zip(&policy).map(pick).collect();
        Ok(Some(match self.sense {
            Sense::Max => Optimum { low: own.iter().map(N::low).collect(), high: sides.collect(), picks },
            Sense::Min => {
                let high = own.iter().map(|x| Some(x.high())).collect();
                Optimum { low: sides.map(|x| x.unwrap_or_else(N::zero)).collect(), high, picks }
            }
        }))
    }

    /// Returns a policy that leaves the component from every group: each action has an edge to a
    /// group that leaves it in fewer steps.
    fn leaving_policy(&self) -> Option<Vec<usize>> {
        let n = self.actions.len();
        let mut policy = vec![usize::MAX; n];
        let mut into: Vec<Vec<(u32, usize)>> = vec![Vec::new(); n];
        let mut layer = Vec::new();
        for (group, actions) in (0u32..).zip(&self.actions) {
            for (number, action) in actions.iter().enumerate() {
                action.row.edges.iter().for_each(|&(to, _)| into[to as usize].push((group, number)));
                if policy[group as usize] == usize::MAX && !action.row.escape.is_zero() {
                    policy[group as usize] = number;
                    layer.push(group);
                }
            }
        }
        while let Some(to) = layer.pop() {
            for &(group, number) in &into[to as usize] {
                if policy[group as usize] == usize::MAX {
                    policy[group as usize] = number;
                    layer.push(group);
                }
            }
        }
        policy.iter().all(|&number| number != usize::MAX).then_some(policy)
    }

    /// Replaces a policy by the one that looks best after some sweeps of value iteration. This
    /// saves rounds of policy iteration and needs no precision.
    fn greedy(&self, policy: &mut [usize], meter: &mut Meter<'_>) -> Result<()> {
        let mut x = vec![0.0; policy.len()];
        let value = |action: &Action<N>, x: &[f64]| {
            let sum: f64 = action.row.edges.iter().map(|(to, p)| p.bounds().lower * x[*to as usize]).sum();
            (action.high.bounds().lower + sum) / action.leaving.bounds().upper
        };
        for _ in 0..SWEEPS {
            for (group, actions) in self.actions.iter().enumerate() {
                meter.step()?;
                for (number, action) in actions.iter().enumerate() {
                    let q = value(action, &x);
                    if q > x[group] {
                        (x[group], policy[group]) = (q, number);
                    }
                }
            }
        }
        Ok(())
    }

    /// Returns the values of a policy.
    fn evaluate(&self, policy: &[usize], upper: bool, meter: &mut Meter<'_>) -> Result<Option<Vec<N>>> {
        let row = |(actions, &number): (&Vec<Action<N>>, &usize)| {
            let action = &actions[number];
            Row { constant: action.constant(upper).clone(), ..action.row.clone() }
        };
        eliminate::solve(self.actions.iter().zip(policy).map(row).collect(), usize::MAX, meter)
    }

    /// Improves a policy by the permitted actions until no action is certainly better; returns its
    /// values.
    fn improve(
        &self,
        policy: &mut [usize],
        upper: bool,
        permitted: &dyn Fn(usize, usize) -> bool,
        meter: &mut Meter<'_>,
    ) -> Result<Option<Vec<N>>> {
        loop {
            let Some(x) = self.evaluate(policy, upper, meter)? else { return Ok(None) };
            let mut changed = false;
            for (group, actions) in self.actions.iter().enumerate() {
                let mut best = x[group].clone();
                for (number, action) in actions.iter().enumerate() {
                    meter.step()?;
                    if number == policy[group] || !permitted(group, number) {
                        continue;
                    }
                    let q = action.value(&x, upper);
                    let better = match self.sense {
                        Sense::Max => q.exceeds(&best),
                        Sense::Min => best.exceeds(&q),
                    };
                    if better {
                        (best, policy[group], changed) = (q, number, true);
                    }
                }
            }
            if !changed {
                return Ok(Some(x));
            }
        }
    }

    /// Returns g with g ≥ e(a) + P_a g for every action, or `None` for each group if there is none.
    fn certificate(&self, policy: &[usize], x: &[N], meter: &mut Meter<'_>) -> Result<Vec<Option<N>>> {
        let upper = self.sense == Sense::Max;
        let mut open: Vec<Vec<Doubt>> = x.iter().map(|_| Vec::new()).collect();
        let mut most = 0.0f64;
        for (group, actions) in self.actions.iter().enumerate() {
            for (number, action) in actions.iter().enumerate() {
                meter.step()?;
                let q = action.value(x, upper);
                let excess = match self.sense {
                    Sense::Max => q.excess(&x[group]),
                    Sense::Min => x[group].excess(&q),
                };
                let e = if number == policy[group] { 0.0 } else { excess.bounds().upper };
                let gap = match self.sense {
                    Sense::Max => x[group].bounds().lower - q.bounds().upper,
                    Sense::Min => q.bounds().lower - x[group].bounds().upper,
                };
                most = most.max(e);
                let sure = if number == policy[group] { 0.0 } else { gap.next_down().max(0.0) };
                open[group].push(Doubt { excess: e, gap: sure, taken: e > 0.0 || number == policy[group] });
            }
        }
        if most == 0.0 {
            return Ok(vec![Some(N::zero()); x.len()]);
        }
        let g = self.rounded().slack(policy, open, most, meter)?;
        Ok(match g {
            Some(g) => g.into_iter().map(|g| Ratio::from_f64(g).map(|g| N::of(&g))).collect(),
            None => vec![None; x.len()],
        })
    }

    /// Returns the component with intervals and the constant 1 for every action: its values are
    /// numbers of steps.
    fn rounded(&self) -> Component<Interval> {
        let round = |action: &Action<N>| {
            let edges = action.row.edges.iter().map(|(to, p)| (*to, p.bounds())).collect();
            let row = Row { edges, escape: action.row.escape.bounds(), constant: Interval::ONE };
            let leaving = action.leaving.bounds();
            Action { choice: action.choice, row, high: Interval::ONE, leaving }
        };
        let actions = self.actions.iter().map(|actions| actions.iter().map(round).collect()).collect();
        Component { sense: Sense::Max, actions }
    }
}

/// The doubt about an action: it may be better by `excess`, or is certainly worse by `gap`.
struct Doubt {
    excess: f64,
    gap: f64,
    /// True if the expected number of steps counts this action.
    taken: bool,
}

impl Component<Interval> {
    /// Computes g as 2 · `most` times the largest expected number of steps by doubtful actions. An
    /// action that is certainly worse, but by less than g could gain, becomes doubtful too.
    fn slack(
        &self,
        policy: &[usize],
        mut doubts: Vec<Vec<Doubt>>,
        most: f64,
        meter: &mut Meter<'_>,
    ) -> Result<Option<Vec<f64>>> {
        for _ in 0..ROUNDS {
            let mut longest = policy.to_vec();
            let taken = |group: usize, number: usize| doubts[group][number].taken;
            let Some(steps) = self.improve(&mut longest, true, &taken, meter)? else { return Ok(None) };
            let g: Vec<f64> = steps.iter().map(|steps| 2.0 * most * steps.upper).collect();
            if g.iter().any(|g| !g.is_finite()) {
                return Ok(None);
            }
            let mut holds = true;
            for (group, actions) in self.actions.iter().enumerate() {
                for (action, doubt) in actions.iter().zip(&mut doubts[group]) {
                    if !action.is_covered(&g, g[group], doubt) {
                        if doubt.taken {
                            return Ok(None);
                        }
                        (doubt.taken, holds) = (true, false);
                    }
                }
            }
            if holds {
                return Ok(Some(g));
            }
        }
        Ok(None)
    }
}

impl Action<Interval> {
    /// Returns whether g ≥ e + P g holds for this action, where -gap stands for e if it is certain.
    fn is_covered(&self, g: &[f64], own: f64, doubt: &Doubt) -> bool {
        let sum =
            |sum: Interval, (to, p): &(u32, Interval)| sum.plus(&p.times(&Interval::point(g[*to as usize])));
        let reached = self.row.edges.iter().fold(Interval::ZERO, sum).over(&self.leaving).upper;
        (reached + doubt.excess).next_up() <= (own + doubt.gap).next_down()
    }
}
