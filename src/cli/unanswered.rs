//! Errors about the properties that a model names.

use meliora_base::error::{Diagnostic, Error, Severity, SourceFile};
use meliora_lang::named::{self, Property};

/// Returns the error for `reach` without a question: it lists what the model can be asked.
pub(super) fn without_question(named: &[Property]) -> Error {
    let names: Vec<String> = named.iter().map(|property| format!("`{}`", property.name)).collect();
    let message = match names.as_slice() {
        [] => {
            "a question is missing: `--target EXPR`, `--property PROPERTY` or `--properties FILE`; the model \
               itself names no properties"
                .to_owned()
        }
        names => format!(
            "a question is missing; the model names the properties {}: `--property NAME` answers one, \
             `--all-properties` answers all, and `--target EXPR` or `--properties FILE` ask others",
            names.join(", ")
        ),
    };
    Error::Usage(message)
}

/// Returns the question of a property that the model names.
///
/// # Errors
/// The property is not supported.
pub(super) fn of_model(property: &Property) -> Result<named::Asks, Error> {
    property.asks.clone().map_err(|refusal| not_answered(&property.name, &refusal.reason))
}

/// Returns the question of a property that is one about a single formula.
///
/// # Errors
/// The property is not supported, or is of another kind.
pub(super) fn single(property: &Property) -> Result<named::Asked, Error> {
    match of_model(property)? {
        named::Asks::One(asked) => Ok(asked),
        named::Asks::Expression(_) => {
            let reason =
                "paths stop where a probability or a reward of one formula is decided, and it asks for more";
            Err(not_answered(&property.name, reason))
        }
    }
}

/// Returns the error for a property of the model without an answer.
pub(super) fn not_answered(name: &str, reason: &str) -> Error {
    let source = SourceFile::new("--property", name);
    let message = format!("the property \"{name}\" of the model cannot be answered: {reason}");
    Diagnostic::new(&source, 0..name.len(), message).severity(Severity::Unsupported).into()
}
