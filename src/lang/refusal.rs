//! The reason why a property is not answered.

use meliora_base::error::{Diagnostic, Error};

/// The reason why a property cannot be answered.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Refusal {
    /// The reason, and what helps.
    pub reason: String,
    /// The line and the column of the mistake in the file; `None` if it has no place.
    pub place: Option<(usize, usize)>,
}

impl Refusal {
    /// Returns the refusal for an error in a property.
    pub fn new(error: &Error) -> Self {
        match error {
            Error::Input(diagnostics) if !diagnostics.is_empty() => Refusal::at(&diagnostics[0]),
            _ => Refusal::without_place(error.to_string()),
        }
    }

    /// Returns the refusal for a message with its place and advice.
    pub(crate) fn at(diagnostic: &Diagnostic) -> Self {
        let help = diagnostic.help.as_ref().map_or_else(String::new, |help| format!("; {help}"));
        let reason = format!("{}{help}", diagnostic.message);
        Refusal { reason, place: Some(diagnostic.position()) }
    }

    /// Returns a refusal that is not about a place.
    pub(crate) fn without_place(reason: impl Into<String>) -> Self {
        Refusal { reason: reason.into(), place: None }
    }
}
