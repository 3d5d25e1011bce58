//! Tolerance for rounded probabilities, such as three times 0.333333.

use super::value::Value;
use super::{Command, CommandId, Program};

/// Largest deviation from 1 that is accepted silently as an error of floating-point arithmetic.
const SILENT: f64 = 1e-9;
/// Largest deviation from 1 that is accepted with a warning: one millionth, plus the margin with
/// which three times 0.333333 is within it.
const TOLERATED: f64 = 1.000_001e-6;

/// The judgement on a sum of probabilities.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Sum {
    /// The sum is 1, up to floating-point errors.
    One,
    /// The sum is near 1 and is accepted with a warning.
    Rounded,
    /// The sum is too far from 1.
    Wrong,
}

impl Sum {
    /// Judges a sum of probabilities.
    pub(crate) fn of(sum: f64) -> Self {
        match (sum - 1.0).abs() {
            off if off <= SILENT => Sum::One,
            off if off <= TOLERATED => Sum::Rounded,
            _ => Sum::Wrong,
        }
    }
}

impl Program {
    /// Returns the first enabled command whose probabilities in this state sum to 1 only after
    /// rounding, with their sum.
    pub fn rounded_in(&self, state: &[i64]) -> Option<(CommandId, f64)> {
        let value = |e| self.pool.eval(e, state).ok();
        let sum = |command: &Command| {
            let enabled = value(command.guard) == Some(Value::Bool(true));
            let each = command.branches.iter().map(|b| Some(value(b.probability)?.to_f64()));
            each.sum::<Option<f64>>().filter(|&sum| enabled && Sum::of(sum) == Sum::Rounded)
        };
        (0..).zip(&self.commands).find_map(|(index, command)| Some((CommandId(index), sum(command)?)))
    }
}

#[cfg(test)]
mod tests {
    use super::Sum;

    #[test]
    fn sums_are_one_or_nearly_or_not() {
        for (sum, expected) in [
            (1.0, Sum::One),
            (0.1 + 0.2 + 0.7, Sum::One),
            (0.333333 + 0.333333 + 0.333333, Sum::Rounded),
            (1.000_001, Sum::Rounded),
            (0.99999, Sum::Wrong),
            (f64::NAN, Sum::Wrong),
        ] {
            assert_eq!(Sum::of(sum), expected, "{sum}");
        }
    }
}
