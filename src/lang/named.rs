//! Properties that a model names.

use super::ltl::Formula;
use super::property::check::Checker;
use super::property::formulas::is_bounded;
use super::property::{self, Measure, Named, Over, Question, Term};
use super::refusal::Refusal;
use meliora_base::error::Result;
use meliora_model::Program;

/// A property of a model.
#[derive(Debug, Clone)]
pub struct Property {
    /// Name.
    pub name: String,
    /// The property, or the reason why it cannot be answered.
    pub asks: std::result::Result<Asks, Refusal>,
}

/// The meaning of a property of a model.
#[derive(Debug, Clone)]
pub enum Asks {
    /// A question about a single formula in the initial states.
    One(Asked),
    /// An expression over states.
    Expression(property::Property),
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

impl Asked {
    /// Returns the property as an expression over states, if it is a probability with bounds on the number of
    /// steps in all initial states; `None` for others.
    ///
    /// # Errors
    /// A bound on the number of steps is not a constant.
    pub fn bounded(&self, program: &Program) -> Result<Option<Term>> {
        let is_reward = matches!(&self.question, Question::Quantity(quantity) if quantity.measure != Measure::Probability);
        if self.over != Over::All || is_reward || !is_bounded(&self.formula) || program.players.is_some() {
            return Ok(None);
        }
        let named = Named::default();
        Checker::new(program, &program.source, &named).known_probability(&self.question, &self.formula)
    }
}
