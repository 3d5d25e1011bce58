//! The strategies of a question as text, as `meliora reach --policy` writes them.

use std::path::Path;

use meliora_base::error::Result;
use meliora_model::Program;
use meliora_question::Strategies;
use meliora_question::evaluate::PropertyPolicy;
use meliora_report::{mix, policy, property_policy};

/// The form of a strategy as text.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum PolicyForm {
    /// For each state the facts and the action, as planners write them: of a target and of `Pmax>=1 [ F … ]` alone.
    Rules,
    /// JSON.
    #[default]
    Json,
    /// A table: of the strategy of a property alone.
    Csv,
    /// A drawing: of the strategy of a property alone.
    Dot,
}

impl PolicyForm {
    /// Returns the form that the ending of a file names; rules if it names none.
    pub fn by_ending(path: &Path) -> Self {
        match path.extension().and_then(|extension| extension.to_str()) {
            Some("json") => PolicyForm::Json,
            Some("csv") => PolicyForm::Csv,
            Some("dot") => PolicyForm::Dot,
            _ => PolicyForm::Rules,
        }
    }
}

/// Writes a piece of a text.
pub type Piece<'w> = dyn FnMut(&str) -> Result<()> + 'w;

/// Writes the strategy that was asked for in the form, piece by piece. If it does not have this form, a list of rules is
/// written as rules, and other strategies as JSON. Writes nothing if there is none.
///
/// # Errors
/// A command has no meaning in some state; the errors of `write`.
pub fn write_policy(
    (property, found): (&str, &Strategies),
    program: &Program,
    form: PolicyForm,
    write: &mut Piece<'_>,
) -> Result<()> {
    match found {
        Strategies { policy: Some(found), .. } => match form {
            PolicyForm::Json => write(&(policy::json(found, program)? + "\n")),
            PolicyForm::Rules | PolicyForm::Csv | PolicyForm::Dot => write(&policy::text(found, program)?),
        },
        Strategies { mix: Some(found), .. } if !found.strategies.is_empty() => {
            write(&(mix::json(property, found, program)? + "\n"))
        }
        Strategies { optimal: Some(found), .. } => optimal(property, found, program, form, write),
        _ => Ok(()),
    }
}

/// Writes the strategy of the opponent, as [`write_policy`] does.
///
/// # Errors
/// See [`write_policy`].
pub fn write_opponent(
    (property, found): (&str, &Strategies),
    program: &Program,
    form: PolicyForm,
    write: &mut Piece<'_>,
) -> Result<()> {
    match &found.opponent {
        Some(found) => optimal(property, found, program, form, write),
        None => Ok(()),
    }
}

/// Returns the pieces of a text as one; `None` if there are none.
///
/// # Errors
/// The errors of `writing`.
pub fn whole_text(writing: impl FnOnce(&mut Piece<'_>) -> Result<()>) -> Result<Option<String>> {
    let mut all: Option<String> = None;
    writing(&mut |piece| {
        all.get_or_insert_default().push_str(piece);
        Ok(())
    })?;
    Ok(all)
}

fn optimal(
    property: &str,
    found: &PropertyPolicy,
    program: &Program,
    form: PolicyForm,
    write: &mut Piece<'_>,
) -> Result<()> {
    match form {
        PolicyForm::Csv => write(&property_policy::csv(found, program)?),
        PolicyForm::Dot => write(&property_policy::dot(found, program)?),
        PolicyForm::Json | PolicyForm::Rules => property_policy::json(property, found, program, write),
    }
}
