//! Probabilities of steps: doubles, or exact fractions.

use num_traits::One;

use super::{Branch, Command, CommandId, Program, VarId};
use meliora_base::exact::{Exact, Ratio, Real};
use meliora_base::number::Weight;
use meliora_base::rounding::{Sum, judged};
use meliora_base::value::EvalError;

/// The reasons why a step has no meaning in a state.
#[derive(Debug, Clone, PartialEq)]
pub enum StepError {
    /// The expression of a guard, a probability or an update has no value.
    Eval(CommandId, EvalError),
    /// The sum of a command's probabilities, or one of them, is this invalid number.
    Probability(CommandId, Real),
    /// An update assigns this value, which is outside the variable's range.
    OutOfRange(CommandId, VarId, i64),
    /// There are more choices or successors than [`MOST_WAYS`](super::step::MOST_WAYS).
    TooMany,
}

/// The smallest positive double.
const LEAST: f64 = f64::from_bits(1);

/// A positive probability. Its double is positive too: a branch is not lost by rounding.
pub(super) trait Probability: Weight {
    /// Returns 1/n.
    fn share(n: usize) -> Self;
    /// Returns the product with another probability.
    fn scaled(&self, other: &Self) -> Self;
    /// Returns the branches of positive probability of an enabled command.
    fn branches<'p>(
        program: &'p Program,
        id: CommandId,
        state: &[i64],
    ) -> Result<Vec<(&'p Branch, Self)>, StepError>;
}

impl Probability for f64 {
    fn share(n: usize) -> Self {
        1.0 / n as f64
    }

    fn scaled(&self, other: &Self) -> Self {
        (self * other).max(LEAST)
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

impl Probability for Ratio {
    fn share(n: usize) -> Self {
        Ratio::new(1.into(), n.into())
    }

    fn scaled(&self, other: &Self) -> Self {
        if self.is_one() { other.clone() } else { self * other }
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

impl Program {
    /// Judges the probabilities of a command in a state; see [`judged`].
    pub(super) fn judged(&self, command: &Command, state: &[i64]) -> Result<(Sum, Real), EvalError> {
        judged(command.branches.iter().map(|b| Ok(self.pool.exact(b.probability, state)?.into_real())))
    }

    /// Returns the first enabled command whose probabilities in this state sum to 1 only after
    /// rounding, with the double nearest to their sum.
    pub fn rounded_in(&self, state: &[i64]) -> Option<(CommandId, f64)> {
        let sum = |command: &Command| {
            let enabled = self.pool.exact(command.guard, state) == Ok(Exact::Bool(true));
            match self.judged(command, state).ok().filter(|_| enabled)? {
                (Sum::Rounded, sum) => Some(sum.to_f64()),
                _ => None,
            }
        };
        (0..).zip(&self.commands).find_map(|(index, command)| Some((CommandId(index), sum(command)?)))
    }
}
