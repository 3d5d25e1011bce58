//! The error space: wrong input (with its place), limits that were hit, files, usage.

use std::path::Path;
use std::time::Duration;
use std::{fmt, io};

pub use crate::diagnostic::{Diagnostic, Severity, SourceFile, render};

/// The result of every operation of the library that can fail.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Whatever can end a computation early.
#[derive(Debug, Clone, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The model, the preferences or an expression is wrong; every entry points at a place.
    #[error("{}", first_message(.0))]
    Input(Vec<Diagnostic>),
    /// A limit was hit: an answer in its own right, with what was reached.
    #[error("{0}")]
    Limit(Limit),
    /// A dump could not be read: file, line, what was expected.
    #[error("{file}:{line}: {message}")]
    Dump {
        /// The file that is wrong.
        file: String,
        /// Its line, from 1; 0 where no line can be named.
        line: usize,
        /// What was found and what was expected.
        message: String,
    },
    /// A file could not be read or written.
    #[error("{path}: {message}")]
    Io {
        /// The file.
        path: String,
        /// What the system said.
        message: String,
    },
    /// What is asked for does not fit together.
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

impl Error {
    /// What the system said of a file that is read.
    pub fn reading(path: &Path, error: &io::Error) -> Self {
        Error::Io { path: path.display().to_string(), message: said(error) }
    }

    /// What the system said of a file that is written; a full disk is a limit. `path` is the user's: the
    /// error may know another one, of a temporary file.
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

/// What the system said, without the path that was added to it on the way.
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

/// Which limit ended the work.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum Limit {
    /// The work would take more than [`crate::engine::Settings::memory`].
    Memory {
        /// What was full, in words: "the node table of 12345 nodes is full".
        what: String,
    },
    /// The caller's time limit has passed.
    Time(Duration),
    /// The system gives no more, whatever the settings allow.
    System {
        /// What was asked for.
        what: String,
        /// How many bytes that was, where [`crate::engine::Settings::memory`] says how many.
        bytes: Option<u64>,
    },
    /// More states than the explicit engine numbers, whatever the settings allow.
    States(u64),
    /// More states than were to be listed one by one.
    Listed(u64),
    /// Interrupted by the user.
    Interrupted,
    /// What was found could not be written.
    Output {
        /// Where to, and what the system said.
        what: String,
    },
    /// An expression or a model is larger than a fixed bound of this program.
    Size {
        /// What is too large, its size, and the bound.
        what: String,
    },
}

/// What a caller can do about a limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Relief {
    /// More of [`crate::engine::Settings::memory`].
    MoreMemory,
    /// Less of [`crate::engine::Settings::memory`], or a system that gives more.
    LessMemory,
    /// A system that gives more.
    System,
    /// A later end.
    Time,
    /// More states to be listed.
    Listed,
    /// The symbolic engine, which has no such bound.
    Symbolic,
}

impl Limit {
    /// What raises the limit, or gets by without it; none where nothing does.
    pub fn relief(&self) -> Option<Relief> {
        match self {
            Limit::Memory { .. } => Some(Relief::MoreMemory),
            Limit::Time(_) => Some(Relief::Time),
            Limit::System { bytes: Some(_), .. } => Some(Relief::LessMemory),
            Limit::System { bytes: None, .. } => Some(Relief::System),
            Limit::States(_) => Some(Relief::Symbolic),
            Limit::Listed(_) => Some(Relief::Listed),
            Limit::Interrupted | Limit::Output { .. } | Limit::Size { .. } => None,
        }
    }
}

impl fmt::Display for Limit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Limit::Memory { what } => write!(f, "out of memory: {what}"),
            Limit::Time(after) => write!(f, "out of time after {after:?}"),
            Limit::System { what, .. } => write!(f, "the system does not provide {what}"),
            Limit::States(n) => write!(f, "too large: the explicit engine supports at most {n} states"),
            Limit::Listed(n) => write!(f, "too large: more than {n} states to list"),
            Limit::Interrupted => write!(f, "interrupted"),
            Limit::Output { what } => write!(f, "the results could not be written: {what}"),
            Limit::Size { what } => write!(f, "too large: {what}"),
        }
    }
}
