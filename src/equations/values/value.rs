//! Values of states.

use meliora_base::error::Result;
use meliora_base::interval::{Bounds, Interval};

/// A value of a state.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// A number.
    Finite(Bounds),
    /// Infinity: the target is not reached almost surely.
    Infinite,
}

impl Value {
    /// Returns the bounds, which may be infinite.
    pub fn interval(&self) -> Interval {
        match self {
            Value::Finite(bounds) => bounds.interval,
            Value::Infinite => Interval::point(f64::INFINITY),
        }
    }

    /// Replaces a probability by 1 minus it.
    pub fn complement(&mut self) {
        if let Value::Finite(bounds) = self {
            *bounds = bounds.clone().complement();
        }
    }
}

/// The values of some states.
#[derive(Debug)]
pub struct Answer {
    /// The values, in the order of the states.
    pub values: Vec<Value>,
    /// An error if a limit was reached. The bounds hold then too, but may be wide.
    pub end: Result<()>,
}

impl Answer {
    /// Returns the bounds of the values, which may be infinite.
    ///
    /// # Errors
    /// A limit was reached.
    pub fn bounds(self) -> Result<Vec<Interval>> {
        self.end.map(|()| self.values.iter().map(Value::interval).collect())
    }

    /// Returns the values at some positions.
    #[must_use]
    pub fn selected(self, positions: &[usize]) -> Self {
        Answer { values: positions.iter().map(|&at| self.values[at].clone()).collect(), end: self.end }
    }
}
