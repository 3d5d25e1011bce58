//! The check that a model has an initial state.

use std::ops::Range;

use meliora_base::error::{Diagnostic, Result};
use meliora_engine::Engine;
use meliora_lang::ast::Item;
use meliora_lang::parse_model;
use meliora_model::Program;

/// Checks that a model has an initial state. Without one, every property would hold, and every value
/// would be that of no state. Cost: no image.
///
/// # Errors
/// The condition `init … endinit` holds for no valuation of the variables; the error is at its place.
pub fn check_start<E: Engine>(engine: &E, program: &Program) -> Result<()> {
    if !engine.is_empty(&engine.initial_states())? {
        return Ok(());
    }
    let message = "the model has no initial state";
    let diagnostic = Diagnostic::new(&program.source, place(program), message);
    Err(diagnostic.label("no state satisfies this").help("let the condition hold in some state").into())
}

/// Returns the place of the condition of the initial states; the beginning of the text without one.
fn place(program: &Program) -> Range<usize> {
    let items = parse_model(&program.source).map(|model| model.items).unwrap_or_default();
    let condition = items.into_iter().find_map(|item| match item {
        Item::Init(condition) => Some(condition.range()),
        _ => None,
    });
    condition.unwrap_or(0..0)
}
