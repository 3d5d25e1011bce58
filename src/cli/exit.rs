//! Exit statuses.

use std::process::ExitCode;

use meliora_base::error::{Error, Limit};

/// The exit statuses of the process: the contract that scripts rely on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Status {
    /// The command succeeded.
    Done,
    /// The answer is no.
    No,
    /// The command line is wrong.
    Usage,
    /// The model, the preferences or another file is wrong.
    Input,
    /// Out of memory, nodes, time or disk.
    Limit,
    /// The user interrupted the program.
    Interrupted,
    /// A bug in this program.
    Internal,
}

impl Status {
    /// Returns the exit status for an error.
    pub(crate) fn for_error(error: &Error) -> Self {
        match error {
            Error::Usage(_) | Error::ForeignSet => Status::Usage,
            Error::Limit(Limit::Interrupted) => Status::Interrupted,
            Error::Limit(_) => Status::Limit,
            // An error in a model, a dump or another file.
            _ => Status::Input,
        }
    }

    /// Returns the number that the system sees. 101 is the exit status of a panic in Rust.
    pub(crate) fn code(self) -> u8 {
        match self {
            Status::Done => 0,
            Status::No => 1,
            Status::Usage => 2,
            Status::Input => 3,
            Status::Limit => 4,
            Status::Internal => 101,
            Status::Interrupted => 130,
        }
    }
}

impl From<Status> for ExitCode {
    fn from(status: Status) -> Self {
        ExitCode::from(status.code())
    }
}
