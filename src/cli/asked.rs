//! The questions of `meliora reach`, as they are read: a target, properties of the command line or of a file, or those
//! that the model names.

use std::sync::Arc;

use meliora_base::error::{Diagnostic, Error, Severity, SourceFile};
use meliora_engine::NoProgress;
use meliora_lang::named::Property;
use meliora_lang::property::{Named, Term};
use meliora_lang::refusal::Refusal;
use meliora_lang::{Given, parse_property};
use meliora_model::Program;
use meliora_model::predicate::Predicate;
use meliora_question::plan::{Plan, Planner};
use meliora_question::{Asking, Required, Stopping};
use meliora_report::properties::PropertyAnswer;

use super::load::{Loaded, document, overlap, parsed, parsed_for, required};
use super::options::ModelArgs;
use super::progress::TerminalSink;

/// The question of a planning problem: whether a strong cyclic plan exists.
const GOAL: &str = "Pmax>=1 [ F \"goal\" ]";

/// The refusal of a question that means the goal of a problem without one.
pub(super) const NO_GOAL: &str = "this problem has preferences and no goal that must hold: `--target EXPR` gives one, and `check` judges the preferences";

/// A model with questions about it.
pub(super) struct Asked {
    /// The model.
    pub(super) program: Arc<Program>,
    /// The questions, and the requests that they need.
    pub(super) plan: Plan,
    /// The requirements.
    pub(super) required: Vec<Required>,
    /// True if a question without an answer leaves the others: those of a file, or of the model.
    pub(super) is_list: bool,
    /// See [`Loaded::overlap`].
    pub(super) overlap: Option<Predicate>,
}

/// The questions of the command line as texts.
pub(super) struct Texts<'a> {
    pub(super) target: Option<&'a str>,
    pub(super) properties: &'a [String],
    pub(super) require: &'a [String],
    /// The regions are written.
    pub(super) regions: bool,
}

impl Asked {
    /// Combines a model with questions about it.
    pub(super) fn new(
        mut program: Program,
        plan: Plan,
        required: Vec<Required>,
        is_list: bool,
        overlap: Option<Predicate>,
    ) -> Self {
        note_inexact(&mut program, plan.requests.iter().flat_map(|request| request.asking.goal.predicates()));
        Asked { program: Arc::new(program), plan, required, is_list, overlap }
    }

    /// Reads the model, and the target or the properties.
    ///
    /// # Errors
    /// A file, the constants, the bounds or an expression is wrong.
    pub(super) fn read(args: &ModelArgs, texts: &Texts<'_>, sink: &TerminalSink) -> Result<Self, Error> {
        let for_goals = texts.target.is_none() && texts.properties.is_empty() && texts.require.is_empty();
        let loaded = parsed_for(args, for_goals, sink)?;
        let required = required(texts.require)?;
        let plan = planned(&loaded, texts, &required)?;
        Ok(Asked::new(loaded.program, plan, required, false, loaded.overlap))
    }

    /// Reads the model, and a target or a property whose paths stop where it is decided.
    ///
    /// # Errors
    /// A file, the constants, the bounds or an expression is wrong; no state decides the property.
    pub(super) fn stopping(args: &ModelArgs, texts: &Texts<'_>, sink: &TerminalSink) -> Result<Self, Error> {
        let Loaded { program, named, .. } = parsed(args, sink)?;
        let (text, Stopping { program, asking }) = match texts.target {
            Some(text) => (text, Stopping::target(&program, &SourceFile::new("--target", text))?),
            None => {
                let text = properties(&program, &named, texts)?[0];
                let (source, term) = stated(&program, &named, text)?;
                let Some(query) = term.query(&program) else {
                    let message = "paths stop where the probability or the reward of one formula is decided, and this \
                                   property asks for more";
                    let range = if named.iter().any(|p| p.name == text) { 0..0 } else { term.span.range() };
                    let wrong = Diagnostic::new(&source, range, message).severity(Severity::Unsupported);
                    return Err(wrong.help("leave out `--stop-at-target`").into());
                };
                (text, Stopping::query(&program, &source, &query)?)
            }
        };
        let overlap = overlap(&program);
        Ok(Asked::new(program, Plan::of(asking, text), Vec::new(), false, overlap))
    }

    /// Reads the model and all properties that it names. Those that cannot be answered have a reason in the report.
    ///
    /// # Errors
    /// A file, the constants or the bounds are wrong; the model names no property.
    pub(super) fn named(
        args: &ModelArgs,
        texts: &Texts<'_>,
        sink: &TerminalSink,
    ) -> Result<(Self, Vec<PropertyAnswer>), Error> {
        let Loaded { program, named, overlap } = parsed(args, sink)?;
        if named.is_empty() {
            return Err(without_question(&named));
        }
        let source = &program.source;
        let all = named.into_iter().map(|Property { name, term }| Listed {
            name: None,
            text: name,
            source: Arc::clone(source),
            term,
        });
        let required = required(texts.require)?;
        let (plan, entries) = list(&program, &required, texts.regions, all)?;
        Ok((Asked::new(program, plan, required, true, overlap), entries))
    }
}

/// A property of a list, or the reason why it cannot be answered.
pub(super) struct Listed {
    pub(super) name: Option<String>,
    pub(super) text: String,
    pub(super) source: Arc<SourceFile>,
    pub(super) term: Result<Term, Refusal>,
}

/// Plans the properties of a list. Returns the entries of all in the report. An error in the text of a property is the
/// reason against this one alone.
///
/// # Errors
/// An error in another text, such as a requirement; a limit.
pub(super) fn list(
    program: &Program,
    required: &[Required],
    regions: bool,
    all: impl Iterator<Item = Listed>,
) -> Result<(Plan, Vec<PropertyAnswer>), Error> {
    let (mut planner, mut entries) = (Planner::new(program, required, regions)?, Vec::new());
    for (position, Listed { name, text, source, term }) in all.enumerate() {
        let added = term.map(|term| planner.add(position, &text, &source, term));
        let refusal = match added {
            Err(refusal) => Some(refusal),
            Ok(Ok(())) => None,
            Ok(Err(Error::Input(all))) if all.iter().all(|d| Arc::ptr_eq(&d.source, &source)) => {
                Some(Refusal::of(&Error::Input(all)))
            }
            Ok(Err(error)) => return Err(error),
        };
        let (reason, place) = refusal.map(|refusal| (refusal.reason, refusal.place)).unzip();
        entries.push(PropertyAnswer::open(name, text, reason).at(place.flatten()));
    }
    Ok((planner.finish(), entries))
}

/// Plans the target or the properties of the command line; see [`properties`].
///
/// # Errors
/// Neither a target nor a property is given, or one is wrong.
pub(super) fn planned(loaded: &Loaded, texts: &Texts<'_>, required: &[Required]) -> Result<Plan, Error> {
    let program = &loaded.program;
    if let Some(text) = texts.target {
        let asking = Asking::target(program, &SourceFile::new("--target", text), required)?;
        return Ok(Plan::of(asking, text));
    }
    let mut planner = Planner::new(program, required, texts.regions)?;
    for (position, text) in properties(program, &loaded.named, texts)?.into_iter().enumerate() {
        let (source, term) = stated(program, &loaded.named, text)?;
        planner.add(position, text, &source, term)?;
    }
    Ok(planner.finish())
}

/// Returns the properties of the command line, at least one. Without any, a planning problem is asked for its goal.
///
/// # Errors
/// There is none, and the model has no goal that must hold.
fn properties<'t>(program: &Program, named: &[Property], texts: &Texts<'t>) -> Result<Vec<&'t str>, Error> {
    match (texts.properties, &program.planning) {
        ([], Some(planning)) if planning.has_goal() => Ok(vec![GOAL]),
        ([], Some(_)) => Err(Error::Usage(NO_GOAL.to_owned())),
        ([], None) => Err(without_question(named)),
        (properties, _) => Ok(properties.iter().map(String::as_str).collect()),
    }
}

/// Reads a property, or finds the one with this name in the model.
fn stated(program: &Program, named: &[Property], text: &str) -> Result<(Arc<SourceFile>, Term), Error> {
    if let Some(named) = named.iter().find(|property| property.name == text) {
        let term = named.term.clone().map_err(|refusal| not_answered(text, &refusal.reason))?;
        return Ok((Arc::clone(&program.source), term));
    }
    let source = SourceFile::new("--property", text);
    let term = parse_property(&source)?.term(program, &source, &Named::default())?;
    Ok((source, term))
}

/// Returns the names of the properties that a model names, if its constants have these values.
///
/// # Errors
/// A file or a value is wrong.
pub(super) fn names(args: &ModelArgs, constants: &str) -> Result<Vec<String>, Error> {
    let given = Given {
        constants: SourceFile::new("--const", constants),
        bounds: SourceFile::new("--bounds", args.bounds()),
    };
    let checked = document(&args.model)?.load(&given, &NoProgress)?;
    Ok(checked.properties.into_iter().map(|property| property.name).collect())
}

/// Lets reports name an expression of the conditions that is not exact, if all of the model are.
pub(super) fn note_inexact<'p>(program: &mut Program, mut conditions: impl Iterator<Item = &'p Predicate>) {
    if program.inexact.is_none() {
        program.inexact = conditions.find_map(Predicate::inexact).cloned();
    }
}

/// Returns the error for `reach` without a question: it lists what the model can be asked.
fn without_question(named: &[Property]) -> Error {
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

/// Returns the error for a property of the model without an answer.
fn not_answered(name: &str, reason: &str) -> Error {
    let source = SourceFile::new("--property", name);
    let message = format!("the property \"{name}\" of the model cannot be answered: {reason}");
    Diagnostic::new(&source, 0..name.len(), message).severity(Severity::Unsupported).into()
}
