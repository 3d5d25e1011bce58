//! A recursive-descent parser over tokens. It reports several errors per run, never recurses deeper
//! than a maximum, grows the stack as it needs, and reads every token a bounded number of times.
//! Tokens are made on demand.

mod expr;
mod item;
mod module;
mod parser;
mod system;

use std::sync::Arc;

pub(crate) use expr::operator;
pub(crate) use parser::{Failed, MAX_TREE_NESTING, Parsed, Parser};

use super::ast::{Command, Expr, Item, Model, Span};
use super::token::Token;
use meliora_base::error::{Result, SourceFile};
use meliora_base::progress::{NoProgress, ProgressSink};

/// Parses a model file.
///
/// # Errors
/// Returns all syntax errors that can be distinguished, and unsupported constructs.
pub fn parse_model(source: &Arc<SourceFile>) -> Result<Model> {
    outline(source, &NoProgress)
}

/// Same as [`parse_model`], with a progress sink that can cancel the work.
///
/// # Errors
/// See [`parse_model`]; also a limit.
pub(crate) fn outline(source: &Arc<SourceFile>, sink: &dyn ProgressSink) -> Result<Model> {
    super::mistaken::no_model(source)?;
    let whole = Span::new(0, source.text.len());
    let mut parser = Parser::of_part(source, whole, sink).places();
    let model = parser.model();
    parser.finish(model)
}

/// Returns the parts of a model in a part of a text.
///
/// # Errors
/// See [`parse_model`].
pub(crate) fn items_at(source: &Arc<SourceFile>, place: Span) -> Result<Vec<Item>> {
    let mut parser = Parser::of_part(source, place, &NoProgress).places();
    let model = parser.model();
    parser.finish(model.items)
}

/// Parses an expression of a model again.
///
/// # Errors
/// A syntax error; a limit.
pub(crate) fn expression_at(source: &Arc<SourceFile>, place: Span, sink: &dyn ProgressSink) -> Result<Expr> {
    let mut parser = Parser::of_part(source, place, sink);
    let parsed = parser.tree(Parser::expression);
    parser.finish_parsed(parsed)
}

/// Parses a command of a model again.
///
/// # Errors
/// A syntax error; a limit.
pub(crate) fn command_at(source: &Arc<SourceFile>, place: Span, sink: &dyn ProgressSink) -> Result<Command> {
    let mut parser = Parser::of_part(source, place, sink);
    let parsed = parser.command();
    parser.finish_parsed(parsed)
}

/// Parses a text that is one expression, as after `--target` or `--where`. Names in quotes are
/// labels.
///
/// # Errors
/// A syntax error.
pub fn parse_expression(source: &Arc<SourceFile>) -> Result<Expr> {
    let mut parser = Parser::new(source);
    let parsed = parser.tree(Parser::expression).and_then(|e| parser.expect(Token::End).map(|_| e));
    parser.finish_parsed(parsed)
}
