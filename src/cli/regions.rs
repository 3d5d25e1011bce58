//! `meliora reach --out`: the regions of questions as a dump.

use std::path::Path;

use meliora_base::error::Error;
use meliora_dump::directory::check_directory;

use super::options::{EngineArgs, EngineChoice, ModelArgs};

/// The directory of the dump, checked before the work begins.
#[derive(Clone, Copy)]
pub(super) struct Regions<'a> {
    pub(super) directory: &'a Path,
    pub(super) model: &'a ModelArgs,
}

impl<'a> Regions<'a> {
    /// Checks the directory, and that the engine has diagrams.
    ///
    /// # Errors
    /// [`Error::Usage`]; the directory contains something else than a dump.
    pub(super) fn new(directory: &'a Path, model: &'a ModelArgs, engine: EngineArgs) -> Result<Self, Error> {
        let wrong = if directory.as_os_str() == "-" {
            "a dump is a directory; it cannot be written to standard output"
        } else if engine.engine == EngineChoice::Explicit {
            "`--out` writes decision diagrams; it cannot be used with `--engine explicit`, which has none"
        } else {
            check_directory(directory)?;
            return Ok(Regions { directory, model });
        };
        Err(Error::Usage(wrong.to_owned()))
    }
}
