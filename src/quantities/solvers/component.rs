//! The optimal values of one strongly connected component as fractions, by policy iteration.
//!
//! End components in which nothing can be gained or paid are collapsed to one node, a *group*, so
//! that every policy for probabilities leaves the component. A policy is evaluated by elimination
//! ([`crate::solvers::eliminate`]). It is changed only where another action is better, so policies never get worse, never cycle,
//! and keep leaving the component: an action that is merely as good is never taken, so ties cannot form a cycle. The
//! last policy is optimal.

use crate::equations::meter::{Meter, Stop, Turn};
use crate::equations::number::Weight;
use crate::equations::system::Sense;
use crate::solvers::eliminate::{self, Row};
use meliora_base::error::Result;
use meliora_base::exact::Ratio;

/// An action of a group: a choice of one of its nodes that may leave the group.
#[derive(Debug, Clone)]
pub(crate) struct Action {
    /// The choice, by its number in the graph.
    choice: u32,
    /// The edges to other groups, and the probability to leave the component. Edges back to the
    /// group are left out.
    row: Row<Ratio>,
    /// The upper bound of the constant; that of `row` is the lower one.
    high: Ratio,
    /// The probability to leave the group.
    leaving: Ratio,
}

impl Action {
    /// Creates an action.
    pub(crate) fn new(choice: u32, row: Row<Ratio>, high: Ratio) -> Self {
        let leaving = row.leaving();
        Action { choice, row, high, leaving }
    }

    /// Returns whether the action leaves its group with positive probability.
    pub(crate) fn leaves(&self) -> bool {
        !Weight::is_zero(&self.leaving)
    }

    fn constant(&self, upper: bool) -> &Ratio {
        if upper { &self.high } else { &self.row.constant }
    }

    /// Returns the value of the action if the groups have the values `x`.
    fn value(&self, x: &[Ratio], upper: bool) -> Ratio {
        let sum = |sum: Ratio, (to, p): &(u32, Ratio)| sum + p * &x[*to as usize];
        self.row.edges.iter().fold(self.constant(upper).clone(), sum) / &self.leaving
    }
}

/// A component: the actions of each group.
#[derive(Debug)]
pub(crate) struct Component {
    pub(crate) sense: Sense,
    pub(crate) actions: Vec<Vec<Action>>,
}

/// The values of the groups for the lower and the upper bounds of the constants, and the choice that each takes.
#[derive(Debug)]
pub(crate) struct Optimum {
    pub(crate) low: Vec<Ratio>,
    pub(crate) high: Vec<Ratio>,
    pub(crate) picks: Vec<u32>,
}

impl Component {
    /// Solves the component. `seen` has a choice for each group that is probably the best. `left` is the work that may be
    /// done.
    ///
    /// # Errors
    /// Some group cannot leave the component, or gains without an end; more work is needed; a limit is reached.
    pub(crate) fn solve(&self, seen: &[u32], left: &mut usize, meter: &mut Meter<'_>) -> Turn<Optimum> {
        let leaving = self.leaving_policy().ok_or(Stop::Never)?;
        let first =
            |(actions, &choice): (&Vec<Action>, &u32)| actions.iter().position(|a| a.choice == choice);
        let seen: Option<Vec<usize>> = self.actions.iter().zip(seen).map(first).collect();
        let mut policy = seen.filter(|seen| seen.len() == leaving.len()).unwrap_or_else(|| leaving.clone());
        // No policy is beyond the values on the side of the optimum.
        let upper = self.sense == Sense::Max;
        let x = match self.improve(&mut policy, upper, left, meter) {
            Err(Stop::Never) if policy != leaving => {
                policy = leaving;
                self.improve(&mut policy, upper, left, meter)?
            }
            other => other?,
        };
        let is_exact = self.actions.iter().flatten().all(|action| action.high == action.row.constant);
        let own = if is_exact { x.clone() } else { self.evaluate(&policy, !upper, left, meter)? };
        let picks =
            self.actions.iter().zip(&policy).map(|(actions, &number)| actions[number].choice).collect();
        let (low, high) = if upper { (own, x) } else { (x, own) };
        Ok(Optimum { low, high, picks })
    }

    /// Returns an estimate of the bytes of the actions.
    pub(crate) fn bytes(&self) -> usize {
        let actions = self.actions.iter().flatten();
        actions.map(|action| (action.row.edges.len() + 4) * (Ratio::BYTES + size_of::<u32>())).sum()
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
                if policy[group as usize] == usize::MAX && !Weight::is_zero(&action.row.escape) {
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

    /// Returns the values of a policy.
    fn evaluate(
        &self,
        policy: &[usize],
        upper: bool,
        left: &mut usize,
        meter: &mut Meter<'_>,
    ) -> Turn<Vec<Ratio>> {
        let row = |(actions, &number): (&Vec<Action>, &usize)| {
            let action = &actions[number];
            Row { constant: action.constant(upper).clone(), ..action.row.clone() }
        };
        eliminate::solve(self.actions.iter().zip(policy).map(row).collect(), left, meter)
    }

    /// Improves a policy until no action is better; returns its values.
    fn improve(
        &self,
        policy: &mut [usize],
        upper: bool,
        left: &mut usize,
        meter: &mut Meter<'_>,
    ) -> Turn<Vec<Ratio>> {
        loop {
            let x = self.evaluate(policy, upper, left, meter)?;
            if !self.change(policy, &x, upper, meter)? {
                return Ok(x);
            }
        }
    }

    /// Replaces the actions of a policy with the values `x` by better ones; returns whether there are any.
    fn change(&self, policy: &mut [usize], x: &[Ratio], upper: bool, meter: &mut Meter<'_>) -> Result<bool> {
        let mut changed = false;
        for (group, actions) in self.actions.iter().enumerate() {
            let mut best = x[group].clone();
            for (number, action) in actions.iter().enumerate().filter(|_| actions.len() > 1) {
                meter.step()?;
                let q = action.value(x, upper);
                let better = if self.sense == Sense::Max { q > best } else { q < best };
                if better {
                    (best, policy[group], changed) = (q, number, true);
                }
            }
        }
        Ok(changed)
    }
}
