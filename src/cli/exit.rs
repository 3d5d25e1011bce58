//! Exit statuses.

use std::process::ExitCode;

use meliora::error::{Error, Limit};

/// How the process ends; the contract that scripts rely on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Status {
    /// The work is done.
    Done,
    /// The answer is no.
    No,
    /// The command line is wrong.
    Usage,
    /// The model, the preferences or another file is wrong.
    Input,
    /// Out of memory, nodes, time or disk.
    Limit,
    /// Interrupted by the user.
    Interrupted,
    /// A mistake of this program.
    Internal,
}

impl Status {
    /// The status that an error ends with.
    pub(crate) fn of(error: &Error) -> Self {
        match error {
            Error::Usage(_) => Status::Usage,
            Error::Limit(Limit::Interrupted) => Status::Interrupted,
            Error::Limit(_) => Status::Limit,
            // What is wrong in a model, a dump or another file, whatever its sort.
            _ => Status::Input,
        }
    }

    /// The number that the system sees. 101 is what a panic of a Rust program ends with.
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
