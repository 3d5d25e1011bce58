//! Errors: invalid input (with its place), limits, files, usage.

use std::path::Path;
use std::time::Duration;
use std::{fmt, io};

pub use crate::diagnostic::{Diagnostic, Severity, SourceFile, render};

/// The result of every fallible operation of the library. A function whose documentation lists no
/// errors fails only with [`Error::Limit`], if a limit is reached: memory, time or a size, or the
/// caller has cancelled the work.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// The reason why a computation ended early.
#[derive(Debug, Clone, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The model, the preferences or an expression is invalid; every entry points at a place.
    #[error("{}", first_message(.0))]
    Input(Vec<Diagnostic>),
    /// A limit was reached; earlier results are kept.
    #[error("{0}")]
    Limit(Limit),
    /// A dump could not be read.
    #[error("{file}{}: {message}", at_line(*line))]
    Dump {
        /// The invalid file.
        file: String,
        /// The line, from 1; 0 if the error has no line.
        line: usize,
        /// The content that was found, and the content that was expected.
        message: String,
    },
    /// A file could not be read or written.
    #[error("{path}: {message}")]
    Io {
        /// The file.
        path: String,
        /// The message of the system.
        message: String,
    },
    /// A set of states or choices was given to an engine that did not make it.
    #[error("the set belongs to another exploration; an engine accepts only the sets that it made")]
    ForeignSet,
    /// The arguments of a call are inconsistent.
    #[error("{0}")]
    Usage(String),
}

fn first_message(diagnostics: &[Diagnostic]) -> String {
    match diagnostics {
        [] => "wrong input".to_owned(),
        [one] => one.message.clone(),
        [first, rest @ ..] => format!("{} (and {} more)", first.message, rest.len()),
    }
}

/// Returns `:7` for a line; nothing for 0, no line.
fn at_line(line: usize) -> String {
    if line == 0 { String::new() } else { format!(":{line}") }
}

impl Error {
    /// Returns the error for a file that could not be read; too little memory for it is a limit.
    pub fn reading(path: &Path, error: &io::Error) -> Self {
        let path = path.display().to_string();
        match error.kind() {
            io::ErrorKind::OutOfMemory => {
                Limit::System { what: format!("the memory to read {path}"), bytes: None }.into()
            }
            _ => Error::Io { path, message: said(error) },
        }
    }

    /// Returns the error for a file that could not be written; a full disk is a limit. `path` is
    /// the one that the user gave, as `error` may contain the path of a temporary file.
    pub fn writing(path: &Path, error: &io::Error) -> Self {
        let (path, message) = (path.display().to_string(), said(error));
        match error.kind() {
            io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded | io::ErrorKind::FileTooLarge => {
                Limit::Output { what: format!("{path}: {message}") }.into()
            }
            _ => Error::Io { path, message },
        }
    }
}

/// Returns an error if a condition is false.
///
/// # Errors
/// The given error.
pub fn ensure<E>(holds: bool, error: impl FnOnce() -> E) -> std::result::Result<(), E> {
    if holds { Ok(()) } else { Err(error()) }
}

/// Returns the message of the system, without a path that was added to it.
fn said(error: &io::Error) -> String {
    match (error.raw_os_error(), error.kind()) {
        (Some(_), io::ErrorKind::NotFound) => "no such file or directory".to_owned(),
        (Some(_), io::ErrorKind::IsADirectory) => "this is a directory".to_owned(),
        (Some(_), _) | (None, io::ErrorKind::Other) => error.to_string(),
        (None, kind) => kind.to_string(),
    }
}

impl From<Diagnostic> for Error {
    fn from(diagnostic: Diagnostic) -> Self {
        Error::Input(vec![diagnostic])
    }
}

impl From<Limit> for Error {
    fn from(limit: Limit) -> Self {
        Error::Limit(limit)
    }
}

/// The limit that ended the work.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum Limit {
    /// The work needs more memory than the memory limit of the engine's settings allows.
    Memory {
        /// The part that was full, in words: "the node table of 12345 nodes is full".
        what: String,
    },
    /// The caller's time limit has passed.
    Time(Duration),
    /// A part of the work has used up its share of the caller's time limit; the other parts ended earlier.
    Share(Duration),
    /// The system refuses further resources, whatever the settings allow.
    System {
        /// The requested resource.
        what: String,
        /// The requested bytes, if the memory limit determines them.
        bytes: Option<u64>,
    },
    /// The model has more states than the explicit engine can number, whatever the settings allow.
    States(u64),
    /// There are more states than the limit for listing states one by one.
    Listed(u64),
    /// The user interrupted the work.
    Interrupted,
    /// A limit has left this number of regions of a dump without a certificate.
    Uncertified(usize),
    /// The results could not be written.
    Output {
        /// The destination, and the message of the system.
        what: String,
    },
    /// An expression or a model exceeds a fixed bound of this program.
    Size {
        /// The object that is too large, its size, and the bound.
        what: String,
    },
}

/// The action by which a caller can avoid a limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Relief {
    /// Increase the memory limit of the engine's settings.
    MoreMemory,
    /// Decrease the memory limit of the engine's settings, or use a system with more memory.
    LessMemory,
    /// Use a system with more resources.
    System,
    /// Increase the time limit.
    Time,
    /// Increase the number of states that may be listed.
    Listed,
    /// Increase the time or memory limit with which the dump is exported.
    Export,
    /// Use the symbolic engine, which does not have this bound.
    Symbolic,
}

impl Limit {
    /// Returns the action that avoids the limit; none if no action does.
    pub fn relief(&self) -> Option<Relief> {
        match self {
            Limit::Memory { .. } => Some(Relief::MoreMemory),
            Limit::Time(_) | Limit::Share(_) => Some(Relief::Time),
            Limit::System { bytes: Some(_), .. } => Some(Relief::LessMemory),
            Limit::System { bytes: None, .. } => Some(Relief::System),
            Limit::States(_) => Some(Relief::Symbolic),
            Limit::Listed(_) => Some(Relief::Listed),
            Limit::Uncertified(_) => Some(Relief::Export),
            Limit::Interrupted | Limit::Output { .. } | Limit::Size { .. } => None,
        }
    }
}

impl fmt::Display for Limit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Limit::Memory { what } => write!(f, "out of memory: {what}"),
            Limit::Time(after) => write!(f, "out of time after {after:?}"),
            Limit::Share(of) => {
                write!(f, "out of time: a part of the work has used up its share of the limit of {of:?}")
            }
            Limit::System { what, .. } => write!(f, "the system does not provide {what}"),
            Limit::States(n) => write!(f, "too large: the explicit engine supports at most {n} states"),
            Limit::Listed(n) => write!(f, "too large: more than {n} states to list"),
            Limit::Interrupted => write!(f, "interrupted"),
            Limit::Uncertified(n) => write!(
                f,
                "a limit has left {n} regions without a certificate; all regions are written, with the proofs of \
                 the others"
            ),
            Limit::Output { what } => write!(f, "the results could not be written: {what}"),
            Limit::Size { what } => write!(f, "too large: {what}"),
        }
    }
}
