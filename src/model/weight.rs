//! Probabilities of steps: doubles, or exact fractions.
//!
//! This file and `step` import each other: steps multiply weights, and the faults found while the
//! branches of a command are weighed are those of steps.

use num_traits::{One, Zero};

use super::exact::Ratio;
use super::step::StepError;
use super::{Branch, CommandId, Program};

/// A positive probability.
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
        self * other
    }

    fn add(&mut self, other: &Self) {
        *self += other;
    }

    fn branches<'p>(
        program: &'p Program,
        id: CommandId,
        state: &[i64],
    ) -> Result<Vec<(&'p Branch, Self)>, StepError> {
        let mut branches = Vec::new();
        for branch in &program.commands[id.index()].branches {
            let p = program.real(branch.probability, id, state)?;
            if p > 0.0 {
                branches.push((branch, p));
            }
        }
        Ok(branches)
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

    /// The engines keep a branch if its double is positive. Quantities and levels agree only if the
    /// exact value says the same.
    fn branches<'p>(
        program: &'p Program,
        id: CommandId,
        state: &[i64],
    ) -> Result<Vec<(&'p Branch, Self)>, StepError> {
        let (mut branches, mut sum) = (Vec::new(), Ratio::zero());
        for branch in &program.commands[id.index()].branches {
            let rounded = program.real(branch.probability, id, state)?;
            let eval = program.pool.eval_exact(branch.probability, state);
            let p = eval.map_err(|e| StepError::Eval(id, e))?;
            if (rounded > 0.0) != (p > Ratio::zero()) || (rounded == 0.0) != p.is_zero() {
                return Err(StepError::Support(id, rounded));
            }
            if !p.is_zero() {
                sum += &p;
                branches.push((branch, p));
            }
        }
        if !sum.is_one() && !sum.is_zero() {
            branches.iter_mut().for_each(|(_, p)| *p /= &sum);
        }
        Ok(branches)
    }
}
