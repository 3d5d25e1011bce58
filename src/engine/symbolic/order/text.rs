//! Orders as text, one name of a variable or bit after the other.

use std::ops::Range;
use std::sync::Arc;

use ahash::AHashSet;

use super::Bit;
use super::{beside_monitors, by_variables, declared};
use meliora_base::error::{Diagnostic, Error, Result, SourceFile};
use meliora_model::Program;

/// Maximum number of errors that are reported.
const MOST_ERRORS: usize = 20;

/// Reads an order from text: names of variables or of bits (`x.2`), separated by white space or
/// commas, with `//` comments as in models. Every variable of the model must occur exactly once.
///
/// # Errors
/// Unknown, repeated and missing names, each with its position.
pub fn parse(program: &Program, source: &Arc<SourceFile>) -> Result<Vec<Bit>> {
    let mut order: Vec<Bit> = Vec::new();
    let mut seen: AHashSet<Bit> = AHashSet::new();
    let mut errors = Vec::new();
    for (span, name) in words(&source.text) {
        if errors.len() == MOST_ERRORS {
            break;
        }
        match named(program, name) {
            None => {
                errors.push(wrong(source, span, format!("`{name}` is not a variable or bit of the model")))
            }
            Some(bits) => {
                for bit in bits {
                    if seen.insert(bit) {
                        order.push(bit);
                    } else {
                        errors.push(wrong(
                            source,
                            span.clone(),
                            format!("`{name}` occurs twice in the order"),
                        ));
                        break;
                    }
                }
            }
        }
    }
    // An order for a model need not name its monitors.
    order = beside_monitors(program, order);
    seen.extend(&order);
    let missing: Vec<Bit> = declared(program).into_iter().filter(|b| !seen.contains(b)).collect();
    if let (Some(first), true) = (missing.first(), errors.is_empty()) {
        let name = &program.variables[first.variable.index()].name;
        let end = source.text.len();
        errors.push(wrong(source, end..end, format!("bit {} of `{name}` is not in the order", first.index)));
    }
    if errors.is_empty() { Ok(order) } else { Err(Error::Input(errors)) }
}

/// Returns the bits that a word names: all bits of a variable, or one.
fn named(program: &Program, name: &str) -> Option<Vec<Bit>> {
    if let Some(variable) = program.variable(name) {
        return Some(by_variables(program, &[variable]));
    }
    let (variable, index) = name.rsplit_once('.')?;
    let (variable, index) = (program.variable(variable)?, index.parse().ok()?);
    (index < program.variables[variable.index()].bits()).then(|| vec![Bit { variable, index }])
}

fn words(text: &str) -> Vec<(Range<usize>, &str)> {
    let mut words = Vec::new();
    let mut offset = 0;
    for line in text.split_inclusive('\n') {
        let code = line.split("//").next().unwrap_or_default();
        let separator = |c: char| c.is_whitespace() || c == ',';
        for word in code.split(separator).filter(|w| !w.is_empty()) {
            let start = offset + (word.as_ptr() as usize - line.as_ptr() as usize);
            words.push((start..start + word.len(), word));
        }
        offset += line.len();
    }
    words
}

fn wrong(source: &Arc<SourceFile>, span: Range<usize>, message: String) -> Diagnostic {
    let help = "`meliora info MODEL` prints an order in this format".to_owned();
    Diagnostic { help: Some(help), ..Diagnostic::new(source, span, message) }
}
