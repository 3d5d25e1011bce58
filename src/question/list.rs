//! Texts of properties and requirements, and lists of properties of which some may not be answered.

use std::sync::Arc;

use crate::answers::PropertyAnswer;
use crate::goal::Required;
use crate::plan::{Plan, Planner};
use meliora_base::error::{Diagnostic, Error, Result, Severity, SourceFile};
use meliora_lang::named::Property;
use meliora_lang::property::{Named, Term};
use meliora_lang::property_file::Stated;
use meliora_lang::refusal::Refusal;
use meliora_lang::{ltl, parse_property};
use meliora_model::Program;

/// A property of a list, or the reason why it cannot be answered.
pub struct Listed {
    /// Its name in the list.
    pub name: Option<String>,
    /// The text.
    pub text: String,
    /// The text that it points into.
    pub source: Arc<SourceFile>,
    /// The property.
    pub term: std::result::Result<Term, Refusal>,
}

impl From<Stated> for Listed {
    fn from(Stated { name, text, term, source }: Stated) -> Self {
        Listed { name, text, source, term }
    }
}

/// Returns the properties that a model names, as a list.
pub fn named(program: &Program, all: &[Property]) -> Vec<Listed> {
    let listed = |property: &Property| Listed {
        name: None,
        text: property.name.clone(),
        source: Arc::clone(&program.source),
        term: property.term.clone(),
    };
    all.iter().map(listed).collect()
}

/// Returns properties, each a text or a name of the model's, as a list.
pub fn each((program, named): (&Program, &[Property]), (name, texts): (&str, &[&str])) -> Vec<Listed> {
    let listed = |text: &&str| {
        let stated = stated(program, named, (name, text));
        let source =
            stated.as_ref().map_or_else(|_| SourceFile::new(name, *text), |(own, _)| Arc::clone(own));
        let term = stated.map(|(_, term)| term).map_err(|error| Refusal::new(&error));
        Listed { name: None, text: (*text).to_owned(), source, term }
    };
    texts.iter().map(listed).collect()
}

/// Plans the properties of a list. Returns the entries of all in the report. An error in the text of a property is the
/// reason against this one alone.
///
/// # Errors
/// An error in another text, such as a requirement; a limit.
pub fn list(
    program: &Program,
    required: &[Required],
    regions: bool,
    all: impl Iterator<Item = Listed>,
) -> Result<(Plan, Vec<PropertyAnswer>)> {
    let (mut planner, mut entries) = (Planner::new(program, required, regions)?, Vec::new());
    for (position, Listed { name, text, source, term }) in all.enumerate() {
        let added = term.map(|term| planner.add(position, &text, &source, term));
        let refusal = match added {
            Err(refusal) => Some(refusal),
            Ok(Ok(())) => None,
            Ok(Err(Error::Input(all))) if all.iter().all(|d| Arc::ptr_eq(&d.source, &source)) => {
                Some(Refusal::new(&Error::Input(all)))
            }
            Ok(Err(error)) => return Err(error),
        };
        let (reason, place) = refusal.map(|refusal| (refusal.reason, refusal.place)).unzip();
        entries.push(PropertyAnswer::open(name, text, reason).at(place.flatten()));
    }
    Ok((planner.finish(), entries))
}

/// The refusal of a question that means the goal of a problem without one.
pub const NO_GOAL: &str = "this problem has no goal that must hold: `--target EXPR` gives one; `check` judges preferences, and `--property` asks about rewards";

/// Returns the question of a planning problem: whether a strong cyclic plan exists; `None` without a goal that must hold.
pub fn of_goal(program: &Program) -> Option<&'static str> {
    let planning = program.planning.as_ref()?;
    planning.has_goal().then_some("Pmax>=1 [ F \"goal\" ]")
}

/// Returns the error for a name that no property of a file has.
pub fn no_property(source: &SourceFile, name: &str) -> Error {
    Error::Usage(format!("{} has no property with the name `{name}`", source.name))
}

/// Reads a property, or finds the one with this name among those that the model names. Messages call the text `name`.
///
/// # Errors
/// The text is wrong, or the property of the model cannot be answered; the error has its place.
pub fn stated(
    program: &Program,
    named: &[Property],
    (name, text): (&str, &str),
) -> Result<(Arc<SourceFile>, Term)> {
    let source = SourceFile::new(name, text);
    if let Some(named) = named.iter().find(|property| property.name == text) {
        let wrong = |refusal: Refusal| {
            let reason = refusal.reason;
            let message = format!("the property \"{text}\" of the model cannot be answered: {reason}");
            Diagnostic::new(&source, 0..text.len(), message).severity(Severity::Unsupported)
        };
        let term = named.term.clone().map_err(wrong)?;
        return Ok((Arc::clone(&program.source), term));
    }
    let term = parse_property(&source)?.term(program, &source, &Named::default())?;
    Ok((source, term))
}

/// Plans properties, each a text or a name of the model's; see [`stated`].
///
/// # Errors
/// A property or a requirement is wrong, or not supported.
pub fn planned<'t>(
    (program, named): (&Program, &[Property]),
    (name, texts): (&str, impl IntoIterator<Item = &'t str>),
    required: &[Required],
    regions: bool,
) -> Result<Plan> {
    let mut planner = Planner::new(program, required, regions)?;
    for (position, text) in texts.into_iter().enumerate() {
        let (source, term) = stated(program, named, (name, text))?;
        planner.add(position, text, &source, term)?;
    }
    Ok(planner.finish())
}

/// Reads requirements. Messages call each text `name`.
///
/// # Errors
/// The syntax of a formula is wrong, or it is about one state only.
pub fn required<'t>(name: &str, texts: impl IntoIterator<Item = &'t str>) -> Result<Vec<Required>> {
    let each = |text: &str| {
        let source = SourceFile::new(name, text);
        let formula = ltl::parse_formula(&source)?;
        if formula.is_state_formula() { Err(over_one_state(&source)) } else { Ok((source, formula)) }
    };
    texts.into_iter().map(each).collect()
}

/// Returns the error for a requirement without a temporal operator, which would be about the initial
/// states only.
fn over_one_state(source: &Arc<SourceFile>) -> Error {
    let message = "a requirement is a formula over paths, not over one state";
    let diagnostic = Diagnostic::new(source, 0..source.text.len(), message).label("expected `G`, …");
    diagnostic.help(format!("write `G ({})`, or another safe formula", source.text)).into()
}
