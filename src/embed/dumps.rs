//! Dumps of an analysis, and their check.

use std::path::Path;
use std::sync::Arc;

use super::{Model, Task};
use meliora_base::error::{Error, Result, SourceFile};
use meliora_base::progress::ProgressSink;
use meliora_certify::{self as certify, Hashes, Verdict, Violation};
use meliora_dump::directory::sha256;
use meliora_dump::manifest::FILE;
use meliora_dump::{Dump, Manifest};
use meliora_engine::{Scope, Settings};
use meliora_model::Program;

/// A dump that was read from a directory, before it is checked.
pub struct GivenDump {
    dump: Dump,
    /// A picture that does not show its region.
    picture: Option<Violation>,
    directory: String,
}

impl GivenDump {
    /// Reads the dump in a directory.
    ///
    /// # Errors
    /// A file is invalid; the dump has regions of properties, which have no certificate; a limit is reached.
    pub fn read(directory: &Path, sink: &dyn ProgressSink) -> Result<Self> {
        let (dump, picture) = certify::read(directory, sink)?;
        let found = GivenDump { dump, picture, directory: directory.display().to_string() };
        if found.manifest().questions.is_empty() {
            return Ok(found);
        }
        let message = "the dump was written by `meliora reach --out`, which proves nothing: its regions are not \
                       certified; `verify` checks dumps of `meliora export`";
        Err(found.wrong(message))
    }

    /// Returns what the dump says about itself.
    pub fn manifest(&self) -> &Manifest {
        &self.dump.manifest
    }

    /// Checks the dump by one-step conditions for a model with preferences; the scope is that of the dump. Cost: two
    /// images per layer or round.
    ///
    /// # Errors
    /// The dump has no certificate, or an unknown scope; a limit is reached.
    pub fn check(&self, task: &Task, settings: Settings) -> Result<Verdict> {
        if self.dump.certificate.is_none() {
            return Err(self.wrong(
                "the dump has no certificate; `meliora export` without `--region` and `--no-certificate` writes one",
            ));
        }
        let settings = Settings { scope: self.scope()?, ..settings };
        let [model, preferences] =
            [&task.program.source, &task.source].map(|source| sha256(source.original().as_bytes()));
        let hashes = Hashes { model: &model, preferences: &preferences };
        let mut verdict = certify::verify(&task.program, &task.preferences, hashes, &self.dump, settings)?;
        verdict.violation = verdict.violation.or_else(|| self.picture.clone());
        Ok(verdict)
    }

    fn scope(&self) -> Result<Scope> {
        let [reachable, all] = [Scope::Reachable, Scope::All].map(Scope::name);
        let found = &self.manifest().scope;
        let wrong = || {
            let found = found.escape_debug();
            self.wrong(format!("the scope is `{found}`; expected `{reachable}` or `{all}`"))
        };
        found.parse().map_err(|_| wrong())
    }

    /// Explains an error in a text that is not the one that the dump was made from, `read`. `what` names the text.
    pub fn made_from(&self, what: &str, read: &SourceFile) -> Option<Error> {
        let manifest = self.manifest();
        let made_from = if what == "model" { &manifest.model } else { &manifest.preferences };
        if sha256(read.original().as_bytes()) == made_from.sha256 {
            return None;
        }
        let (made_from, file) = (made_from.path.escape_debug(), &read.name);
        Some(self.wrong(format!(
            "the dump was made from another {what}, `{made_from}`, whose text differs from that of `{file}`"
        )))
    }

    fn wrong(&self, message: impl Into<String>) -> Error {
        let file = Path::new(&self.directory).join(FILE).display().to_string();
        Error::Dump { file, line: 0, message: message.into() }
    }
}

impl Model {
    /// Checks the dump in a directory by one-step conditions, as `meliora verify` does, for this model
    /// and the text of the preferences. Returns the program of the states in the verdict, too. Cost: two
    /// images per layer or round.
    ///
    /// # Errors
    /// The dump or the preferences are invalid, or the dump has no certificate; a limit is reached.
    pub fn verify(
        &self,
        preferences: &Arc<SourceFile>,
        directory: &Path,
        settings: Settings,
    ) -> Result<(Arc<Program>, Verdict)> {
        let dump = GivenDump::read(directory, &*settings.sink)?;
        let task = self.clone().task(preferences)?;
        let verdict = dump.check(&task, settings)?;
        Ok((task.program, verdict))
    }
}
