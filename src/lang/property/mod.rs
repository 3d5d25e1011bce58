//! Properties: expressions over states, whose operators ask for probabilities and rewards.
//!
//! [`parse_property`] makes a syntax tree, which is checked against a program: [`Property::term`] returns
//! the expression over its states. One that is a single operator in the initial states is a [`Query`].

pub(crate) mod check;
pub(crate) mod formulas;
pub(crate) mod operators;
mod question;
mod refused;
mod shield;
mod simplify;
mod strategies;
pub mod term;

use std::sync::Arc;

use crate::ast::{Expr, Span};
use crate::parse::{Failed, Parsed, Parser};
use crate::token::Token;
use ahash::AHashMap;
use check::Checker;
use meliora_base::error::{Result, SourceFile};
use meliora_base::progress::NoProgress;
pub use meliora_model::Optimum;
use meliora_model::Program;
pub use meliora_model::property::{
    Bound, Inequality, Measure, Over, PropertyKind, Quantity, Rewards, Strategies,
};
pub(crate) use operators::Extreme;
use operators::NAMED;
pub use operators::Operator;
pub use question::Query;
pub use shield::ShieldExpression;
use simplify::simplified;
pub use term::Term;

/// A property as it is written: an expression over states.
#[derive(Debug, Clone, PartialEq)]
pub struct Property {
    pub(crate) expression: Expr,
}

/// Properties by their names, which others of the same text may refer to.
pub type Named = AHashMap<String, Property>;

/// Parses a property such as `P>=1 [ F "done" ]`, `Pmax=? [ a U b ]`, `1 - Pmin=? [ G !(F x=3) ]` or
/// `R{"cost"}min=? [ F P>=1 [ G "done" ] ]`.
///
/// `P` with a bound holds in a state if every strategy satisfies it (PRISM's meaning for MDPs).
/// `Pmin` and `Pmax` compare the minimum and the maximum probability (Storm's forms).
///
/// # Errors
/// A syntax error.
pub fn parse_property(source: &Arc<SourceFile>) -> Result<Property> {
    property_at(source, Span::new(0, source.text.len()))
}

/// Parses a part of a text that is one property.
///
/// # Errors
/// See [`parse_property`].
pub(crate) fn property_at(source: &Arc<SourceFile>, place: Span) -> Result<Property> {
    let mut parser = Parser::of_part(source, place, &NoProgress);
    parser.in_property = true;
    let parsed = parser.property();
    parser.finish_parsed(parsed)
}

impl Property {
    /// Checks the property against a program; `named` are the properties that it may refer to.
    ///
    /// # Errors
    /// Unknown names and wrong types. A reward structure does not exist, or the property of an `mdp` does
    /// not say which strategies it asks about. A property names players that the model does not have. A part is
    /// not supported.
    pub fn term(&self, program: &Program, source: &Arc<SourceFile>, named: &Named) -> Result<Term> {
        Checker::new(program, source, named).term(&self.expression).map(simplified)
    }
}

impl Parser<'_> {
    fn property(&mut self) -> Parsed<Property> {
        self.of_other_kind()?;
        let asks = self.peek_at(1) == Token::Eq && self.peek_at(2) == Token::Question;
        if asks && self.slip(&NAMED).is_some() {
            return Err(Failed);
        }
        let expression = self.tree(Self::expression)?;
        let ended = self.eat(Token::Semicolon);
        match self.peek() {
            Token::End => Ok(Property { expression }),
            _ if ended => Err(self.second()),
            _ => Err(self.behind()),
        }
    }
}
