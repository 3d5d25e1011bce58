//! The files of a model: one, or the domain and the problem of a planning problem.

use std::path::{Path, PathBuf};

use clap::Args;

/// The argument MODEL.
#[derive(Debug, Clone, Args)]
pub(super) struct ModelFiles {
    /// Model in PRISM's language, JANI, UMB, DRN or as PRISM's .tra, or a planning problem in PDDL (the domain
    /// and the problem, one after the other); `-` reads standard input
    #[arg(value_name = "MODEL")]
    model: PathBuf,

    /// The other half of a planning problem, which may also stand after MODEL
    #[arg(long, hide = true, value_name = "FILE", allow_hyphen_values = true)]
    problem: Option<PathBuf>,
}

impl ModelFiles {
    /// Returns the paths.
    pub(super) fn paths(&self) -> impl Iterator<Item = &Path> {
        [Some(&self.model), self.problem.as_ref()].into_iter().flatten().map(PathBuf::as_path)
    }

    /// Returns whether a file is read from standard input.
    pub(super) fn has_stdin(&self) -> bool {
        self.paths().any(|path| path == "-")
    }

    /// Returns the paths as reports show them, with a space between.
    pub(super) fn shown(&self) -> String {
        self.paths().map(|path| path.display().to_string()).collect::<Vec<_>>().join(" ")
    }
}
