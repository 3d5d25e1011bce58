//! Steps that make a state smaller or greater, where a state is read as a number.

use serde::{Deserialize, Serialize};

use super::VarId;

/// A variable as a digit of the number of a state.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Digit {
    /// The variable.
    pub variable: VarId,
    /// True if greater values make the number smaller.
    pub reversed: bool,
    /// True if rising steps make this digit smaller, too.
    pub steady: bool,
    /// The values in an order of their own, from the smallest digit, as distances from the smallest value of
    /// the variable; empty for the natural order.
    pub values: Vec<u64>,
}

/// The effect of a step on the number of a state. Along steps of one trend no state comes twice, so
/// their paths end.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Trend {
    /// The number becomes smaller.
    Falling,
    /// The number becomes greater, where the steady digits are read in reverse.
    Rising,
}

impl Digit {
    /// Returns a variable as a digit that greater values make greater.
    pub fn natural(variable: VarId) -> Self {
        Digit { variable, reversed: false, steady: false, values: Vec::new() }
    }

    /// Returns true if steps of a trend make the value of the variable smaller, false if greater.
    pub fn lowers(&self, trend: Trend) -> bool {
        (trend == Trend::Falling || self.steady) != self.reversed
    }
}

impl Trend {
    /// Both trends.
    pub const ALL: [Trend; 2] = [Trend::Falling, Trend::Rising];

    /// Returns its name in manifests.
    pub fn name(self) -> &'static str {
        match self {
            Trend::Falling => "falling",
            Trend::Rising => "rising",
        }
    }
}
