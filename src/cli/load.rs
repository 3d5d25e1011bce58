//! Reads files and arguments into programs and preferences.

use std::io;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use meliora::{Model, Task};
use meliora_base::error::{Error, SourceFile};
use meliora_dump::manifest;
use meliora_engine::NoProgress;
use meliora_formats::Document;
use meliora_lang::Given;
use meliora_model::Program;
use meliora_model::predicate::Predicate;
use meliora_question::warnings::overlap;

use super::model_files::ModelFiles;
use super::options::{ModelArgs, PreferenceArgs};
use super::progress::TerminalSink;
use super::ranges;

/// True once standard input has been read.
static INPUT_READ: AtomicBool = AtomicBool::new(false);

/// The name of standard input in messages.
const STANDARD_INPUT: &str = "standard input";

/// Reads a text file; `-` is standard input.
///
/// # Errors
/// The file cannot be read, is too large or is not UTF-8.
pub(super) fn read(path: &Path) -> Result<Arc<SourceFile>, Error> {
    if path != Path::new("-") {
        return SourceFile::open(path);
    }
    SourceFile::read(STANDARD_INPUT, standard_input()?)
}

/// Reads a model; `-` is standard input.
///
/// # Errors
/// See [`Document::open`]; two files are not the two halves of a planning problem.
pub(super) fn document(files: &ModelFiles) -> Result<Document, Error> {
    match Vec::from_iter(files.paths())[..] {
        [one, other] => halves([one, other]),
        [path] if path != Path::new("-") => Document::open(path),
        _ => Document::read(STANDARD_INPUT, standard_input()?),
    }
}

/// Reads the two files of a planning problem, which stand in any order.
fn halves(paths: [&Path; 2]) -> Result<Document, Error> {
    if paths == [Path::new("-"); 2] {
        return Err(Error::Usage("standard input is one file; give the other one a path".to_owned()));
    }
    Document::of_parts([read(paths[0])?, read(paths[1])?])
}

fn standard_input() -> Result<io::Stdin, Error> {
    if INPUT_READ.swap(true, Ordering::Relaxed) {
        return Err(Error::Usage("`-` is standard input, which can be read only once".to_owned()));
    }
    Ok(io::stdin())
}

/// Reads the model of a command.
///
/// # Errors
/// A file, the constants, the bounds or the players are wrong.
pub(super) fn parsed(args: &ModelArgs, sink: &TerminalSink) -> Result<Model, Error> {
    parsed_for(args, false, sink)
}

/// Does the same as [`parsed`]; only the goals of a planning problem may be asked about.
pub(super) fn parsed_for(args: &ModelArgs, for_goals: bool, sink: &TerminalSink) -> Result<Model, Error> {
    if let Some(range) = ranges::parse(&args.constants())?.iter().find(|range| range.varies) {
        let message =
            format!("`{}` has several values; only `check`, `reach` and `compare` accept ranges", range.name);
        return Err(Error::Usage(message));
    }
    let given = given("--const", args.constants(), args.bounds());
    model(&args.model, args.coalition.as_deref(), &given, for_goals, sink)
}

/// Returns the values of constants and the bounds of variables; `name` is what errors call the constants.
pub(super) fn given(name: &str, constants: impl Into<String>, bounds: impl Into<String>) -> Given {
    Given { constants: SourceFile::new(name, constants), bounds: SourceFile::new("--bounds", bounds) }
}

/// Reads a model, and lets us be the players of `coalition`, if it is given.
///
/// # Errors
/// A file, the constants, the bounds or the players are wrong.
pub(super) fn model(
    files: &ModelFiles,
    coalition: Option<&str>,
    given: &Given,
    for_goals: bool,
    sink: &TerminalSink,
) -> Result<Model, Error> {
    let document = document(files)?;
    let document = if for_goals { document.for_goals() } else { document };
    let model = Model::loaded(&document, given, sink)?;
    sink.warn_at(model.warnings());
    played_by(coalition, model)
}

fn played_by(coalition: Option<&str>, model: Model) -> Result<Model, Error> {
    match coalition {
        Some(names) => model.played_by(&SourceFile::new("--coalition", names)),
        None => Ok(model),
    }
}

/// Checks what the instances of a sweep share, such as their properties, before the first one runs; `ends`
/// are the constants of the first and of the last instance. An error that both of them have is taken for
/// that of all. Other errors are those of their instances.
///
/// # Errors
/// The error of the first instance.
pub(super) fn check_each(
    args: &ModelArgs,
    ends: [&str; 2],
    check: impl Fn(Model) -> Result<(), Error>,
) -> Result<(), Error> {
    let wrong = |constants: &str| {
        let given = given("--const", constants, args.bounds());
        let model = Model::loaded(&document(&args.model).ok()?, &given, &NoProgress).ok()?;
        played_by(args.coalition.as_deref(), model).and_then(&check).err()
    };
    match wrong(ends[0]) {
        Some(error) if ends[0] == ends[1] || wrong(ends[1]).is_some() => Err(error),
        _ => Ok(()),
    }
}

/// Reads the model for a command. Returns it with its [`overlap`].
///
/// # Errors
/// A file, the constants, the bounds or an expression is wrong.
pub(super) fn program(
    args: &ModelArgs,
    sink: &TerminalSink,
) -> Result<(Arc<Program>, Option<Predicate>), Error> {
    let program = parsed(args, sink)?.into_program();
    let overlap = overlap(&program);
    Ok((Arc::new(program), overlap))
}

/// Reads the model and the preferences for a command.
///
/// # Errors
/// A file, the constants or the bounds are wrong.
pub(super) fn task(model: &ModelArgs, args: &PreferenceArgs, sink: &TerminalSink) -> Result<Task, Error> {
    preferring(parsed(model, sink)?, &args.preferences, sink)
}

/// Adds the preferences of a file to a model.
///
/// # Errors
/// The file cannot be read, or is wrong.
pub(super) fn preferring(model: Model, preferences: &Path, sink: &TerminalSink) -> Result<Task, Error> {
    let task = model.task(&read(preferences)?)?;
    task.warnings().into_iter().for_each(|warning| sink.tell(warning));
    Ok(task)
}

/// Notes that probabilities of a planning problem are assumed, for commands that compute numbers.
pub(super) fn note_assumed(program: &Program, sink: &TerminalSink) {
    if program.planning.as_ref().is_some_and(|planning| planning.assumes_uniform) {
        sink.warn(
            "the outcomes of `oneof` have no probabilities: equal ones are assumed; answers that only tell sure, \
             possible and impossible do not depend on them",
        );
    }
}

/// Checks that a directory contains a dump, so that errors name the directory and not a missing
/// file.
///
/// # Errors
/// The directory does not exist, or contains no dump.
pub(super) fn dump(directory: &Path) -> Result<&Path, Error> {
    let wrong =
        |message: &str| Error::Io { path: directory.display().to_string(), message: message.to_owned() };
    match std::fs::metadata(directory) {
        Err(e) => Err(Error::reading(directory, &e)),
        Ok(found) if !found.is_dir() => {
            Err(wrong("this is not a directory; a dump is a directory that `meliora export` writes"))
        }
        Ok(_) if !directory.join(manifest::FILE).exists() => {
            Err(wrong("this directory contains no dump; `meliora export` writes one"))
        }
        Ok(_) => Ok(directory),
    }
}
