//! The questions of `meliora reach`, as they are read: a target, properties of the command line or of a file, or those
//! that the model names.

use meliora_base::error::{Error, SourceFile};
use meliora_engine::NoProgress;
use meliora_lang::Given;
use meliora_lang::named::Property;
use meliora_model::Program;
use meliora_question::answers::PropertyAnswer;
use meliora_question::plan::Plan;
use meliora_question::{Asking, Questions, Required, Stopping, list};

use super::load::{document, parsed, parsed_for, required};
use super::options::ModelArgs;
use super::progress::TerminalSink;

/// The questions of the command line as texts.
pub(super) struct Texts<'a> {
    pub(super) target: Option<&'a str>,
    pub(super) properties: &'a [String],
    pub(super) require: &'a [String],
    /// The regions are written.
    pub(super) regions: bool,
}

/// Reads the model, and the target or the properties.
///
/// # Errors
/// A file, the constants, the bounds or an expression is wrong.
pub(super) fn read(args: &ModelArgs, texts: &Texts<'_>, sink: &TerminalSink) -> Result<Questions, Error> {
    let for_goals = texts.target.is_none() && texts.properties.is_empty() && texts.require.is_empty();
    let (program, named) = parsed_for(args, for_goals, sink)?.into_parts();
    let required = required(texts.require)?;
    let plan = planned((&program, &named), texts, &required)?;
    Ok(Questions::new(program, plan, required, false))
}

/// Reads the model, and a target or a property whose paths stop where it is decided.
///
/// # Errors
/// A file, the constants, the bounds or an expression is wrong; no state decides the property.
pub(super) fn stopping(args: &ModelArgs, texts: &Texts<'_>, sink: &TerminalSink) -> Result<Questions, Error> {
    let (program, named) = parsed(args, sink)?.into_parts();
    let (text, Stopping { program, asking }) = match texts.target {
        Some(text) => (text, Stopping::target(&program, &SourceFile::new("--target", text))?),
        None => {
            let text = properties(&program, &named, texts)?[0];
            (text, Stopping::property((&program, &named), ("--property", text))?)
        }
    };
    Ok(Questions::new(program, Plan::of(asking, text), Vec::new(), false))
}

/// Reads the model and all properties that it names. Those that cannot be answered have a reason in the report.
///
/// # Errors
/// A file, the constants or the bounds are wrong; the model names no property.
pub(super) fn named(
    args: &ModelArgs,
    texts: &Texts<'_>,
    sink: &TerminalSink,
) -> Result<(Questions, Vec<PropertyAnswer>), Error> {
    let (program, named) = parsed(args, sink)?.into_parts();
    if named.is_empty() {
        return Err(without_question(&named));
    }
    let all = list::named(&program, &named).into_iter();
    let required = required(texts.require)?;
    let (plan, entries) = list::list(&program, &required, texts.regions, all)?;
    Ok((Questions::new(program, plan, required, true), entries))
}

/// Plans the target or the properties of the command line; see [`properties`].
///
/// # Errors
/// Neither a target nor a property is given, or one is wrong.
pub(super) fn planned(
    (program, named): (&Program, &[Property]),
    texts: &Texts<'_>,
    required: &[Required],
) -> Result<Plan, Error> {
    if let Some(text) = texts.target {
        let asking = Asking::target(program, &SourceFile::new("--target", text), required)?;
        return Ok(Plan::of(asking, text));
    }
    let all = properties(program, named, texts)?;
    list::planned((program, named), ("--property", all), required, texts.regions)
}

/// Returns the properties of the command line, at least one. Without any, a planning problem is asked for its goal.
///
/// # Errors
/// There is none, and the model has no goal that must hold.
fn properties<'t>(program: &Program, named: &[Property], texts: &Texts<'t>) -> Result<Vec<&'t str>, Error> {
    match (texts.properties, list::of_goal(program)) {
        ([], Some(goal)) => Ok(vec![goal]),
        ([], None) if program.planning.is_some() => Err(Error::Usage(list::NO_GOAL.to_owned())),
        ([], None) => Err(without_question(named)),
        (properties, _) => Ok(properties.iter().map(String::as_str).collect()),
    }
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
