//! Probabilities of steps: doubles, or exact fractions.
//!
//! This file and `step` import each other: steps multiply weights, and the faults found while the
//! branches of a command are weighed are those of steps.

use num_traits::{One, Zero};

use super::exact::{Ratio, Real};
use super::step::StepError;
use super::{Branch, CommandId, Program};

/// The smallest positive double.
const LEAST: f64 = f64::from_bits(1);

/// A positive probability. Its double is positive too: a branch is not lost by rounding.
pub(super) trait Weight: Clone {
    /// Returns 1.
    fn one() -> Self;
    /// Returns 1/n.
    fn share(n: usize) -> Self;
    /// Returns the product.
    fn times(&self, other: &Self) -> Self;
    /// Adds another probability.
    fn add(&mut self, other: &Self);
    /// Returns the branches of positive probability of an enabled command.
    fn branches<'p>(
        program: &'p Program,
        id: CommandId,
        state: &[i64],
    ) -> Result<Vec<(&'p Branch, Self)>, StepError>;
}

impl Weight for f64 {
    fn one() -> Self {
        1.0
    }

    fn share(n: usize) -> Self {
        1.0 / n as f64
    }

    fn times(&self, other: &Self) -> Self {
        (self * other).max(LEAST)
    }

    fn add(&mut self, other: &Self) {
        *self += other;
    }

    fn branches<'p>(
        program: &'p Program,
        id: CommandId,
        state: &[i64],
    ) -> Result<Vec<(&'p Branch, Self)>, StepError> {
        let branches = positive(program, id, state)?;
        Ok(branches.into_iter().map(|(branch, p)| (branch, Real::Finite(p).to_f64().max(LEAST))).collect())
    }
}

impl Weight for Ratio {
    fn one() -> Self {
        One::one()
    }

    fn share(n: usize) -> Self {
        Ratio::new(1.into(), n.into())
    }

    fn times(&self, other: &Self) -> Self {
        if self.is_one() { other.clone() } else { self * other }
    }

    fn add(&mut self, other: &Self) {
        *self += other;
    }

    fn branches<'p>(
        program: &'p Program,
        id: CommandId,
        state: &[i64],
    ) -> Result<Vec<(&'p Branch, Self)>, StepError> {
        let mut branches = positive(program, id, state)?;
        let sum: Ratio = branches.iter().map(|(_, p)| p).sum();
        if !sum.is_one() && !sum.is_zero() {
            branches.iter_mut().for_each(|(_, p)| *p /= &sum);
        }
        Ok(branches)
    }
}

/// Returns the branches of an enabled command whose exact probability is positive.
fn positive<'p>(
    program: &'p Program,
    id: CommandId,
    state: &[i64],
) -> Result<Vec<(&'p Branch, Ratio)>, StepError> {
    let mut branches = Vec::new();
    for branch in &program.commands[id.index()].branches {
        let p = program.pool.eval_exact(branch.probability, state).map_err(|e| StepError::Eval(id, e))?;
        if !p.is_zero() {
            branches.push((branch, p));
        }
    }
    Ok(branches)
}
