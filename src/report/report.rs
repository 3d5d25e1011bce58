//! The parts that all reports share.

use std::io;

use schemars::JsonSchema;
use serde::Serialize;

use super::columns::Row;
use super::style::Style;
use meliora_base::error::{Error, Limit};

/// The result of a command as plain data.
pub trait Report: Serialize {
    /// Marks the report as incomplete, with the reason.
    fn fail(&mut self, failure: Failure);
    /// Adds the seconds of the whole run and the largest resident set in bytes.
    fn finish(&mut self, seconds: f64, peak_rss_bytes: u64);
    /// Renders the report as text.
    fn text(&self, style: Style) -> String;

    /// Writes the report as text. Long reports are written in pieces.
    ///
    /// # Errors
    /// The output cannot be written.
    fn write(&self, style: Style, out: &mut dyn io::Write) -> io::Result<()> {
        out.write_all(self.text(style).as_bytes())
    }

    /// Returns the row of a sweep; empty for commands without sweeps.
    fn row(&self) -> Row {
        Row::default()
    }

    /// Returns whether the question was a yes/no question and the answer is no.
    fn is_no(&self) -> bool {
        false
    }

    /// Returns whether there were questions, and none could be read.
    fn is_unread(&self) -> bool {
        false
    }
}

/// The sort of an error.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum FailureKind {
    /// The model, the preferences, an expression or a file is wrong.
    Input,
    /// A limit of memory, nodes or time.
    Resource,
    /// The command line is wrong.
    Usage,
    /// A bug in this program.
    Internal,
}

/// An error in JSON.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
#[schemars(rename = "error")]
pub struct Failure {
    /// The kind and version of the object.
    #[schemars(extend("const" = "meliora.error/1"))]
    pub schema: &'static str,
    /// The sort of error: in the model, the preferences or a file; a limit or an interruption; in the
    /// command line; in this program.
    pub kind: FailureKind,
    /// The problem.
    pub message: String,
    /// The file, or the option, that is wrong; `null` if none.
    pub file: Option<String>,
    /// The line, from 1; `null` if the problem has no place.
    pub line: Option<usize>,
    /// The column in characters, from 1; `null` as `line`.
    pub column: Option<usize>,
    /// True if the user interrupted the work.
    #[serde(skip)]
    pub interrupted: bool,
}

impl Failure {
    /// Creates a failure without a place.
    pub fn new(kind: FailureKind, message: impl Into<String>) -> Self {
        let message = message.into();
        let schema = "meliora.error/1";
        Failure { schema, kind, message, file: None, line: None, column: None, interrupted: false }
    }
}

impl From<&Error> for Failure {
    fn from(error: &Error) -> Self {
        let mut failure = match error {
            Error::Limit(_) => Failure::new(FailureKind::Resource, error.to_string()),
            Error::Usage(_) | Error::ForeignSet => Failure::new(FailureKind::Usage, error.to_string()),
            // An error in a model, a dump or another file.
            _ => Failure::new(FailureKind::Input, error.to_string()),
        };
        match error {
            Error::Input(diagnostics) => {
                if let Some(first) = diagnostics.first() {
                    failure.message.clone_from(&first.message);
                    failure.file = Some(first.source.name.clone());
                    let (line, column) = first.position();
                    (failure.line, failure.column) = (Some(line), Some(column));
                }
            }
            Error::Dump { file, line, message } => {
                failure.message.clone_from(message);
                failure.file = Some(file.clone());
                failure.line = Some(*line);
            }
            Error::Io { path, .. } => failure.file = Some(path.clone()),
            Error::Limit(limit) => failure.interrupted = *limit == Limit::Interrupted,
            // Other errors have no place.
            _ => {}
        }
        failure
    }
}

/// The memory used.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, JsonSchema)]
#[schemars(rename = "memory")]
pub struct MemoryUse {
    /// The largest number of diagram nodes at once; 0 without diagrams.
    pub peak_nodes: u64,
    /// The largest resident set of the process, in bytes.
    pub peak_rss_bytes: u64,
}
