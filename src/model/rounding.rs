//! Probabilities that were rounded where they were written down, such as three times 0.333333.

use super::value::Value;
use super::{Command, CommandId, Program};

/// Sums that are off by no more come from arithmetic, and nobody hears of them.
const SILENT: f64 = 1e-9;
/// Sums that are off by no more are taken for 1, with a warning: a millionth, with the room that three
/// times 0.333333 needs to be within it.
const TOLERATED: f64 = 1.000_001e-6;

/// What probabilities with some sum are taken for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Sum {
    /// A distribution.
    One,
    /// A distribution that was rounded.
    Rounded,
    /// None.
    Wrong,
}

impl Sum {
    pub(crate) fn of(sum: f64) -> Self {
        match (sum - 1.0).abs() {
            off if off <= SILENT => Sum::One,
            off if off <= TOLERATED => Sum::Rounded,
            _ => Sum::Wrong,
        }
    }
}

impl Program {
    /// The first command that is enabled in a state with probabilities that were rounded, with their sum.
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
