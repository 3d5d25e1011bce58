//! Properties that a model names.

use super::property::Question;
use crate::model::expr::ExprId;

/// A property of a model.
#[derive(Debug, Clone)]
pub struct Property {
    /// Name.
    pub name: String,
    /// The question, or the reason why the property is not about reaching a set of states.
    pub asks: Result<Asked, String>,
}

/// A property about reaching a set of states.
#[derive(Debug, Clone)]
pub struct Asked {
    /// Target set, as an expression in the pool of the program.
    pub target: ExprId,
    /// The question about it.
    pub question: Question,
}
