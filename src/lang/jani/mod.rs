//! JANI: models in the exchange format instead of PRISM's language.
//!
//! `mdp` and `dtmc` of version 1 become the same flat program as models in PRISM's language: text
//! -> JSON with places -> tree -> program. Constructs that the program cannot express are refused
//! by name.

mod json;
mod lower;
mod read;

use std::ops::Range;
use std::sync::Arc;

use super::check::Checked;
use super::valuation::{Given, parse_constants};
use meliora_base::error::{Diagnostic, Error, Result, SourceFile};
use meliora_base::progress::ProgressSink;

/// Returns true if a text is meant as a JANI model: it starts like a JSON object, or its name ends
/// with `.jani` and it does not start like a PRISM model. Comments before it are an error of JSON.
pub(crate) fn is_jani(source: &SourceFile) -> bool {
    let text = after_comments(source.text.trim_start_matches('\u{feff}').trim_start());
    let is_prism = text.starts_with(|c: char| c.is_ascii_alphabetic() || c == '/');
    text.starts_with('{') || (!is_prism && source.name.ends_with(".jani"))
}

/// Returns a text without the comments at its beginning.
fn after_comments(mut text: &str) -> &str {
    loop {
        let end = match text.get(..2) {
            Some("//") => text.find('\n'),
            Some("/*") => text.find("*/").map(|at| at + 2),
            _ => return text,
        };
        text = end.map_or("", |end| text[end..].trim_start());
    }
}

/// Parses a model and flattens it.
///
/// # Errors
/// Returns as many errors as can be distinguished: of JSON, of the shape of the document, of
/// meaning; a limit.
pub(super) fn load(source: &Arc<SourceFile>, given: &Given, sink: &dyn ProgressSink) -> Result<Checked> {
    let inputs = &lower::Inputs { source, constants: &given.constants, bounds: &given.bounds };
    let located = |error| match error {
        Error::Input(diagnostics) => {
            Error::Input(diagnostics.into_iter().map(|d| with_path(d, inputs.source)).collect())
        }
        other => other,
    };
    let model = read::model(inputs.source, sink).map_err(located)?;
    let bindings = parse_constants(inputs.constants)?;
    let bounds = bounds(inputs.bounds)?;
    lower::program(&model, inputs, &bindings, bounds, sink).map_err(located)
}

/// Adds the path in the document to a message.
fn with_path(diagnostic: Diagnostic, source: &Arc<SourceFile>) -> Diagnostic {
    if !Arc::ptr_eq(&diagnostic.source, source) {
        return diagnostic;
    }
    match json::path(&source.text, diagnostic.span.start) {
        Some(path) => diagnostic.note(format!("at {path}")),
        None => diagnostic,
    }
}

/// Returns the place of the first string of JSON with this value, quotes included.
pub(crate) fn string_at(text: &str, value: &str) -> Option<Range<usize>> {
    json::string_at(text, value)
}

/// Parses `x=0..7,y=-1..1`.
fn bounds(source: &Arc<SourceFile>) -> Result<Vec<(String, i64, i64)>> {
    let (mut all, mut wrong, mut at) = (Vec::new(), Vec::new(), 0);
    for part in source.text.split(',') {
        match bound(part) {
            Some(bound) => all.push(bound),
            None if source.text.trim().is_empty() => {}
            None => {
                let message = format!("`{}` gives no bounds", part.trim());
                let diagnostic = Diagnostic::new(source, at..at + part.len(), message);
                wrong.push(diagnostic.help("bounds have the form x=0..7"));
            }
        }
        at += part.len() + 1;
    }
    if wrong.is_empty() { Ok(all) } else { Err(Error::Input(wrong)) }
}

fn bound(part: &str) -> Option<(String, i64, i64)> {
    let (name, range) = part.split_once('=')?;
    let (low, high) = range.split_once("..")?;
    let name = name.trim();
    (!name.is_empty()).then_some(())?;
    Some((name.to_owned(), low.trim().parse().ok()?, high.trim().parse().ok()?))
}
