//! Qualitative properties, such as `P>=1 [ ψ ]`: their answer is a set of states, found without
//! numbers.

use std::sync::Arc;

use super::ast::{BinaryOp, Span};
use super::ltl::Formula;
use super::parse::{Failed, Parsed, Parser};
use super::token::Token;
use crate::error::{Result, SourceFile};
use crate::progress::NoProgress;

/// Quantifier over strategies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Strategies {
    /// Every strategy, as `P` means it for MDPs.
    All,
    /// Some strategy.
    Some,
}

/// Condition on the probability.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bound {
    /// 1
    One,
    /// More than 0
    Positive,
    /// Less than 1
    BelowOne,
    /// 0
    Zero,
}

/// A qualitative property.
#[derive(Debug, Clone, PartialEq)]
pub struct Property {
    /// Quantifier over strategies.
    pub strategies: Strategies,
    /// Bound on the probability of the formula under these strategies.
    pub bound: Bound,
    /// Formula on paths.
    pub formula: Formula,
}

/// Minimum or maximum probability, as an operator names it.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(in crate::lang) enum Extreme {
    Unnamed,
    Min,
    Max,
}

/// Returns the qualitative meaning of a comparison of a probability with a number. It is `None` if
/// the answer needs numbers, or is always the same. Without a name, the bound must hold for every
/// strategy.
pub(in crate::lang) fn meaning(
    extreme: Extreme,
    comparison: BinaryOp,
    value: f64,
) -> Option<(Strategies, Bound)> {
    let bound = match (comparison, value) {
        (BinaryOp::Ge, 1.0) => Bound::One,
        (BinaryOp::Gt, 0.0) => Bound::Positive,
        (BinaryOp::Lt, 1.0) => Bound::BelowOne,
        (BinaryOp::Le, 0.0) => Bound::Zero,
        _ => return None,
    };
    // The minimum is at least b if the probability of every strategy is; the maximum, if that of
    // some strategy is.
    let from_below = matches!(bound, Bound::One | Bound::Positive);
    let strategies = match extreme {
        Extreme::Max if from_below => Strategies::Some,
        Extreme::Min if !from_below => Strategies::Some,
        _ => Strategies::All,
    };
    Some((strategies, bound))
}

/// Parses a property such as `P>=1 [ F "done" ]`, `P<1 [ G !(F x=3) ]` or `Pmax>0 [ a U b ]`.
///
/// `P` with a bound holds in a state if every strategy satisfies it (PRISM's meaning for MDPs).
/// `Pmin` and `Pmax` compare the minimum and the maximum probability (Storm's forms).
///
/// # Errors
/// A syntax error, or a property whose answer needs numbers, with the reason.
pub fn parse_property(source: &Arc<SourceFile>) -> Result<Property> {
    property_at(source, Span::new(0, source.text.len()))
}

/// Parses a part of a text that is one property.
///
/// # Errors
/// See [`parse_property`].
pub(in crate::lang) fn property_at(source: &Arc<SourceFile>, place: Span) -> Result<Property> {
    let mut parser = Parser::of_part(source, place, &NoProgress);
    let parsed = parser.property();
    parser.finish_parsed(parsed)
}

impl Parser<'_> {
    fn property(&mut self) -> Parsed<Property> {
        let start = self.here();
        let extreme = self.operator()?;
        let (comparison, value) = self.bound(start)?;
        let (strategies, bound) = self.meaning(extreme, comparison, value, start)?;
        if self.peek() != Token::LeftBracket {
            let diagnostic = self.wrong(self.here(), "the formula of a property is written in brackets");
            self.report(diagnostic.label("expected `[`").help("write `P>=1 [ F condition ]`"));
            return Err(Failed);
        }
        self.advance();
        let formula = self.temporal_formula()?;
        self.expect(Token::RightBracket)?;
        self.eat(Token::Semicolon);
        self.expect(Token::End)?;
        Ok(Property { strategies, bound, formula })
    }

    fn operator(&mut self) -> Parsed<Extreme> {
        let span = self.here();
        match self.text(span) {
            "Pmin" => {
                self.advance();
                Ok(Extreme::Min)
            }
            "Pmax" => {
                self.advance();
                Ok(Extreme::Max)
            }
            "P" => {
                self.advance();
                Ok(match () {
                    () if self.eat_word("min") => Extreme::Min,
                    () if self.eat_word("max") => Extreme::Max,
                    () => Extreme::Unnamed,
                })
            }
            word @ ("R" | "Rmin" | "Rmax" | "S" | "E" | "A" | "filter" | "multi") => {
                let help = "supported are `P>=1 [ F … ]`, `P>0`, `P<1`, `P<=0`, `Pmin…` and `Pmax…`";
                let message = format!("properties with `{word}` are not supported");
                self.report(self.unsupported(span, message).help(help));
                Err(Failed)
            }
            "" => Err(self.expected("a property such as `P>=1 [ F … ]`")),
            _ => {
                let message = "a property needs a bound on the probability of its formula";
                let help = "write `P>=1 [ … ]` for surely, `P>0 [ … ]` for possibly";
                self.report(self.wrong(span, message).label("expected `P>=1 [` or another bound").help(help));
                Err(Failed)
            }
        }
    }

    /// Parses a bound such as `>=1` or `>0`.
    fn bound(&mut self, start: Span) -> Parsed<(BinaryOp, f64)> {
        let comparison = match self.peek() {
            Token::Ge => BinaryOp::Ge,
            Token::Gt => BinaryOp::Gt,
            Token::Le => BinaryOp::Le,
            Token::Lt => BinaryOp::Lt,
            Token::Eq => {
                self.advance();
                if !self.eat(Token::Question) {
                    let span = start.to(self.before());
                    let diagnostic = self.wrong(span, "a probability is compared by `>=`, `>`, `<=` or `<`");
                    let help = "`P>=1 […]` says that it is 1, `P<=0 […]` that it is 0";
                    self.report(diagnostic.label("not by `=`").help(help));
                    return Err(Failed);
                }
                let message = "questions for the value of a probability are not supported";
                let reason =
                    "only comparisons with the probabilities 0 and 1 are decided; no values are computed";
                let help =
                    "ask `P>=1 […]` (certainly), `P>0 […]` (possibly), or `Pmax>=1 […]` (some strategy)";
                self.report(self.unsupported(start.to(self.before()), message).note(reason).help(help));
                return Err(Failed);
            }
            _ => return Err(self.expected("`>=`, `>`, `<=` or `<`")),
        };
        self.advance();
        let span = self.here();
        match (self.peek(), self.text(span).parse::<f64>()) {
            (Token::Int | Token::Real, Ok(value)) => {
                self.advance();
                Ok((comparison, value))
            }
            _ => Err(self.expected("0 or 1")),
        }
    }

    /// Same as [`meaning`]; reports a comparison without a qualitative meaning.
    fn meaning(
        &mut self,
        extreme: Extreme,
        comparison: BinaryOp,
        value: f64,
        start: Span,
    ) -> Parsed<(Strategies, Bound)> {
        meaning(extreme, comparison, value).ok_or_else(|| {
            let message = "the answer to this bound needs numbers, or is always the same";
            let help = "the bounds `>=1`, `>0`, `<1` and `<=0` are supported";
            self.report(self.unsupported(start.to(self.before()), message).help(help));
            Failed
        })
    }
}
