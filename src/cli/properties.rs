//! The properties of a file, for `meliora reach --properties`.

use std::path::Path;

use meliora_base::error::{Error, SourceFile};
use meliora_lang::{open_constants, outline_properties, parse_properties, refuse_values, split_constants};
use meliora_model::Program;
use meliora_question::Questions;
use meliora_question::answers::PropertyAnswer;
use meliora_question::list::{Listed, list};

use super::load;
use super::options::ModelArgs;
use super::progress::TerminalSink;

/// The properties of a file that are asked for.
pub(super) struct Chosen<'a> {
    pub(super) file: &'a Path,
    pub(super) only: Option<&'a str>,
    pub(super) require: &'a [String],
    /// The regions of the properties are written.
    pub(super) regions: bool,
}

/// Returns the names of the properties of a file, or their texts where they have no name.
///
/// # Errors
/// The file cannot be read; it has no such property, or has the value of a given constant already.
pub(super) fn titles(file: &Path, only: Option<&str>, constants: &str) -> Result<Vec<String>, Error> {
    let source = load::read(file)?;
    refuse_values(&source, &SourceFile::new("--const", constants))?;
    let all = outline_properties(&source)?.into_iter();
    let chosen: Vec<_> =
        all.filter(|(name, _)| only.is_none_or(|only| name.as_deref() == Some(only))).collect();
    if let (Some(only), true) = (only, chosen.is_empty()) {
        return Err(no_property(&source, only));
    }
    Ok(chosen.into_iter().map(|(name, text)| name.unwrap_or(text)).collect())
}

/// Checks the definitions of a property file.
///
/// # Errors
/// The file cannot be read, or a definition is wrong.
pub(super) fn check(file: &Path, mut program: Program) -> Result<(), Error> {
    let none = SourceFile::new("--const", "");
    parse_properties(&load::read(file)?, &none, &mut program).map(drop)
}

fn no_property(source: &SourceFile, name: &str) -> Error {
    Error::Usage(format!("{} has no property with the name `{name}`", source.name))
}

/// Reads the model with the definitions of the file, and the properties: those that can be answered as questions,
/// and the entries of all in the report.
///
/// # Errors
/// A file, the constants or the requirements are wrong; there is no such property.
pub(super) fn read(
    chosen: &Chosen<'_>,
    model: &ModelArgs,
    sink: &TerminalSink,
) -> Result<(Questions, Vec<PropertyAnswer>), Error> {
    let source = load::read(chosen.file)?;
    sink.warn_at(&Vec::from_iter(source.encoding_warning()));
    let given = SourceFile::new("--const", model.constants());
    refuse_values(&source, &given)?;
    let mut open = open_constants(&source)?;
    if !open.is_empty() && !model.model.has_stdin() {
        // A constant that both declare is refused at its place in the file.
        let declared = load::document(&model.model)?.constants();
        open.retain(|name| !declared.contains(name));
    }
    let [theirs, others] = split_constants(&given, &open)?;
    let mut program = load::parsed(&model.with_constants(&others.text), sink)?.into_program();
    let mut stated = parse_properties(&source, &theirs, &mut program)?;
    let required = load::required(chosen.require)?;
    if let Some(only) = chosen.only {
        stated.retain(|s| s.name.as_deref() == Some(only));
        if stated.is_empty() {
            return Err(no_property(&source, only));
        }
    }
    let listed = stated.into_iter().map(Listed::from);
    let (plan, entries) = list(&program, &required, chosen.regions, listed)?;
    Ok((Questions::new(program, plan, required, true), entries))
}
