//! Properties that a model names.

use super::property::{Bound, Strategies};
use crate::model::expr::ExprId;

/// A property of a model.
#[derive(Debug, Clone)]
pub struct Property {
    /// Its name.
    pub name: String,
    /// What it asks, or why that is no reachability of a set of states.
    pub asks: Result<Asked, String>,
}

/// A property that asks for the probability to reach a set of states.
#[derive(Debug, Clone)]
pub struct Asked {
    /// The set, in the pool of the program.
    pub target: ExprId,
    /// What the probability is compared with, where it is compared with 0 or 1.
    pub compared: Option<(Strategies, Bound)>,
}
