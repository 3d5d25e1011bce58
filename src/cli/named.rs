//! The properties that a model names.

use std::sync::Arc;

use meliora_base::error::{Error, SourceFile};
use meliora_engine::NoProgress;
use meliora_lang::Given;
use meliora_lang::named::Property;
use meliora_lang::refusal::Refusal;

use super::asked::{Asked, Stated, StatedTerm};
use super::load::{Loaded, document, own, parsed, required};
use super::options::ModelArgs;
use super::progress::TerminalSink;
use super::unanswered::without_question;

/// A name of a property, and the reason if it cannot be answered.
pub(super) type NamedAnswer = (String, Option<Refusal>);

/// Reads the model and all properties that it names. The questions are those that can be answered.
///
/// # Errors
/// A file, the constants or the bounds are wrong; the model names no property.
pub(super) fn named(
    args: &ModelArgs,
    texts: &[String],
    regions: bool,
    sink: &TerminalSink,
) -> Result<(Asked, Vec<NamedAnswer>), Error> {
    let Loaded { program, named, overlap } = parsed(args, sink)?;
    if named.is_empty() {
        return Err(without_question(&named));
    }
    let required = required(texts)?;
    let (mut questions, mut terms, mut all) = (Vec::new(), Vec::new(), Vec::new());
    for (position, Property { name, asks }) in named.into_iter().enumerate() {
        let asking = match asks {
            Ok(asks) => alone(&program.source, own(&program, asks, &required, regions))?,
            Err(refusal) => Err(refusal),
        };
        all.push((name.clone(), asking.as_ref().err().cloned()));
        match asking {
            Ok(Ok(asking)) => questions.push(Stated { position, text: name, asking }),
            Ok(Err(term)) => {
                terms.push(StatedTerm { position, source: Arc::clone(&program.source), term });
            }
            Err(_) => {}
        }
    }
    Ok((Asked { terms, required, ..Asked::new(program, questions, true, overlap) }, all))
}

/// Makes an error in the text of a property the reason against this property alone.
///
/// # Errors
/// An error in another text, such as a requirement; a limit.
pub(super) fn alone<T>(
    source: &Arc<SourceFile>,
    read: Result<T, Error>,
) -> Result<Result<T, Refusal>, Error> {
    match read {
        Err(Error::Input(all)) if all.iter().all(|d| Arc::ptr_eq(&d.source, source)) => {
            Ok(Err(Refusal::of(&Error::Input(all))))
        }
        read => read.map(Ok),
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
