//! Properties that a model names.

use super::property::Term;
use super::refusal::Refusal;

/// A property of a model.
#[derive(Debug, Clone)]
pub struct Property {
    /// Name.
    pub name: String,
    /// The property, or the reason why it cannot be answered.
    pub term: Result<Term, Refusal>,
}
