//! Properties that a model names.

use super::property::{Bound, Strategies};
use crate::model::expr::ExprId;

/// A property of a model.
#[derive(Debug, Clone)]
pub struct Property {
    /// Name.
    pub name: String,
    /// The question, or the reason why the property is not a reachability of a set of states.
    pub asks: Result<Asked, String>,
}

/// A property that asks for the probability to reach a set of states.
#[derive(Debug, Clone)]
pub struct Asked {
    /// Target set, as an expression in the pool of the program.
    pub target: ExprId,
    /// Comparison of the probability with 0 or 1, if there is one.
    pub compared: Option<(Strategies, Bound)>,
}
