//! Properties that a model names.

use super::ltl::Formula;
use super::property::{Over, Question};
use super::refusal::Refusal;

/// A property of a model.
#[derive(Debug, Clone)]
pub struct Property {
    /// Name.
    pub name: String,
    /// The question, or the reason why it cannot be answered.
    pub asks: Result<Asked, Refusal>,
}

/// A property that can be asked.
#[derive(Debug, Clone)]
pub struct Asked {
    /// Formula on paths, whose state formulas are expressions in the pool of the program.
    pub formula: Formula,
    /// The question about it.
    pub question: Question,
    /// The part of the initial states that it is about, from the filter of the property.
    pub over: Over,
}
