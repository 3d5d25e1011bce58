//! Entry point: turns a text of either language into a checked, flat program.

use std::sync::Arc;

use super::check::{Checked, check};
use super::jani;
use super::names::displayed;
use super::parse::outline;
use super::valuation::{Given, parse_constants};
use meliora_base::error::{Diagnostic, Error, Result, SourceFile};
use meliora_base::progress::{NoProgress, ProgressSink};

/// Parses a model in PRISM's language or in JANI, and flattens it. `constants` has the form
/// `K=4,N=3` and may be empty.
///
/// # Errors
/// Returns as many errors as can be distinguished: syntax errors, or else errors of meaning.
pub fn load(source: &Arc<SourceFile>, constants: &Arc<SourceFile>) -> Result<Checked> {
    load_given(source, &Given::constants_only(constants), &NoProgress)
}

/// Same as [`load`], with bounds for unbounded integers, and a progress sink that can cancel the work.
///
/// # Errors
/// See [`load`]; also a limit.
pub fn load_given(source: &Arc<SourceFile>, given: &Given, sink: &dyn ProgressSink) -> Result<Checked> {
    read(source, given, sink).map(displayed)
}

fn read(source: &Arc<SourceFile>, given: &Given, sink: &dyn ProgressSink) -> Result<Checked> {
    if jani::is_jani(source) {
        return jani::load(source, given, sink);
    }
    let model = outline(source, sink);
    let bindings = parse_constants(&given.constants)?;
    let checked = check(&model?, source, &given.constants, &bindings, sink)?;
    if given.bounds.text.trim().is_empty() {
        return Ok(checked);
    }
    let message = "bounds can be given only to the unbounded integers of a JANI model";
    Err(Error::from(Diagnostic::new(&given.bounds, 0..given.bounds.text.len(), message)))
}
