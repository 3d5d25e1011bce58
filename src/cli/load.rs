//! Reads files and arguments into programs and preferences.

use std::io;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use meliora_base::error::{Error, SourceFile};
use meliora_dump::manifest;
use meliora_engine::NoProgress;
use meliora_formats::Document;
use meliora_lang::named::Property;
use meliora_lang::{self as lang, Checked, Given};
use meliora_model::Program;
use meliora_model::predicate::Predicate;
use meliora_model::preference::Preferences;
use meliora_question::warnings::overlap;
use meliora_question::{Required, list};

use super::model_files::ModelFiles;
use super::options::{ModelArgs, PreferenceArgs};
use super::progress::TerminalSink;
use super::ranges;

/// True once standard input has been read.
static INPUT_READ: AtomicBool = AtomicBool::new(false);

/// The name of standard input in messages.
const STANDARD_INPUT: &str = "standard input";

/// A model with preferences over it.
pub(super) struct Question {
    /// The model; for whole paths, its product with the monitors.
    pub(super) program: Arc<Program>,
    /// The preferences.
    pub(super) preferences: Arc<Preferences>,
    /// The text of the preferences.
    pub(super) source: Arc<SourceFile>,
    /// See [`overlap`].
    pub(super) overlap: Option<Predicate>,
}

/// A model with its properties.
pub(super) struct Loaded {
    pub(super) program: Program,
    /// The properties that the model names.
    pub(super) named: Vec<Property>,
}

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

pub(super) fn parsed(args: &ModelArgs, sink: &TerminalSink) -> Result<Loaded, Error> {
    parsed_for(args, false, sink)
}

/// Does the same as [`parsed`]; only the goals of a planning problem may be asked about.
pub(super) fn parsed_for(args: &ModelArgs, for_goals: bool, sink: &TerminalSink) -> Result<Loaded, Error> {
    if let Some(range) = ranges::parse(&args.constants())?.iter().find(|range| range.varies) {
        let message =
            format!("`{}` has several values; only `check`, `reach` and `compare` accept ranges", range.name);
        return Err(Error::Usage(message));
    }
    let given = Given {
        constants: SourceFile::new("--const", args.constants()),
        bounds: SourceFile::new("--bounds", args.bounds()),
    };
    let document = document(&args.model)?;
    let document = if for_goals { document.for_goals() } else { document };
    let mut loaded = loaded(&document, &given, sink)?;
    play_as(args.coalition.as_deref(), &mut loaded.program)?;
    Ok(loaded)
}

/// Lets us be the players of `--coalition`, if it is given.
fn play_as(coalition: Option<&str>, program: &mut Program) -> Result<(), Error> {
    let Some(names) = coalition else { return Ok(()) };
    let coalition = lang::parse_coalition(program, &SourceFile::new("--coalition", names))?;
    program.play_as(&coalition);
    Ok(())
}

fn loaded(document: &Document, given: &Given, sink: &TerminalSink) -> Result<Loaded, Error> {
    let checked = document.load(given, sink)?;
    sink.warn_at(&checked.warnings);
    Ok(Loaded::of(checked))
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
    check: impl Fn(Loaded) -> Result<(), Error>,
) -> Result<(), Error> {
    let wrong = |constants: &str| {
        let given = Given {
            constants: SourceFile::new("--const", constants),
            bounds: SourceFile::new("--bounds", args.bounds()),
        };
        let mut loaded = Loaded::of(document(&args.model).ok()?.load(&given, &NoProgress).ok()?);
        play_as(args.coalition.as_deref(), &mut loaded.program).and_then(|()| check(loaded)).err()
    };
    match wrong(ends[0]) {
        Some(error) if ends[0] == ends[1] || wrong(ends[1]).is_some() => Err(error),
        _ => Ok(()),
    }
}

impl Loaded {
    fn of(checked: Checked) -> Self {
        let Checked { program, properties: named, .. } = checked;
        Loaded { program, named }
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
    let program = parsed(args, sink)?.program;
    let overlap = overlap(&program);
    Ok((Arc::new(program), overlap))
}

/// Reads the model and the preferences for a command.
///
/// # Errors
/// A file, the constants or the bounds are wrong.
pub(super) fn question(
    model: &ModelArgs,
    args: &PreferenceArgs,
    sink: &TerminalSink,
) -> Result<Question, Error> {
    preferring(model, &args.preferences, sink)
}

/// Does the same as [`question`] for a preference file without options.
///
/// # Errors
/// A file, the constants or the bounds are wrong.
pub(super) fn preferring(
    model: &ModelArgs,
    preferences: &Path,
    sink: &TerminalSink,
) -> Result<Question, Error> {
    let mut question = preferred(parsed(model, sink)?, preferences, sink)?;
    // The preference file may name players, too.
    play_as(model.coalition.as_deref(), Arc::make_mut(&mut question.program))?;
    Ok(question)
}

fn preferred(loaded: Loaded, preferences: &Path, sink: &TerminalSink) -> Result<Question, Error> {
    let question = with_preferences(loaded, preferences)?;
    sink.warn_at(&Vec::from_iter(question.source.encoding_warning()));
    for warning in question.preferences.warnings() {
        sink.warn(&format!("{} {warning}", question.source.name));
    }
    Ok(question)
}

/// Adds the preferences to a model.
///
/// # Errors
/// The file cannot be read, or is wrong.
pub(super) fn with_preferences(loaded: Loaded, preferences: &Path) -> Result<Question, Error> {
    let program = loaded.program;
    let overlap = overlap(&program);
    let source = read(preferences)?;
    let lang::Question { mut program, preferences } = lang::load_preferences(&source, program)?;
    program.note_inexact(preferences.predicates());
    Ok(Question { program: Arc::new(program), preferences: Arc::new(preferences), source, overlap })
}

/// Reads the model that a dump names, with its constants, and the preferences.
///
/// # Errors
/// A file, the constants or the bounds are wrong.
pub(super) fn certified(
    model: &ModelFiles,
    coalition: Option<&str>,
    preferences: &Path,
    given: &Given,
    sink: &TerminalSink,
) -> Result<Question, Error> {
    let mut question = preferred(loaded(&document(model)?, given, sink)?, preferences, sink)?;
    play_as(coalition, Arc::make_mut(&mut question.program))?;
    Ok(question)
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

/// Reads `--require`.
///
/// # Errors
/// The syntax of a formula is wrong.
pub(super) fn required(texts: &[String]) -> Result<Vec<Required>, Error> {
    list::required("--require", texts.iter().map(String::as_str))
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
