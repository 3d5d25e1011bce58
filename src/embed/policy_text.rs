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

/// Returns the strategy that was asked for in the form. If it does not have this form, a list of rules is written as
/// rules, and other strategies as JSON. `None` if there is none.
///
/// # Errors
/// A command has no meaning in some state.
pub fn policy_text(
    (property, found): (&str, &Strategies),
    program: &Program,
    form: PolicyForm,
) -> Result<Option<String>> {
    match found {
        Strategies { policy: Some(found), .. } => match form {
            PolicyForm::Json => Ok(Some(policy::json(found, program)? + "\n")),
            PolicyForm::Rules | PolicyForm::Csv | PolicyForm::Dot => policy::text(found, program).map(Some),
        },
        Strategies { mix: Some(found), .. } if !found.strategies.is_empty() => {
            Ok(Some(mix::json(property, found, program)? + "\n"))
        }
        Strategies { optimal: Some(found), .. } => optimal(property, found, program, form).map(Some),
        _ => Ok(None),
    }
}

/// Returns the strategy of the opponent, as [`policy_text`] does.
///
/// # Errors
/// See [`policy_text`].
pub fn opponent_text(
    (property, found): (&str, &Strategies),
    program: &Program,
    form: PolicyForm,
) -> Result<Option<String>> {
    found.opponent.as_ref().map(|found| optimal(property, found, program, form)).transpose()
}

fn optimal(property: &str, found: &PropertyPolicy, program: &Program, form: PolicyForm) -> Result<String> {
    match form {
        PolicyForm::Csv => property_policy::csv(found, program),
        PolicyForm::Dot => property_policy::dot(found, program),
        PolicyForm::Json | PolicyForm::Rules => property_policy::json(property, found, program),
    }
}
