//! Dumps of an analysis, and their check.

use std::path::Path;
use std::sync::Arc;

use super::{Analysis, Model};
use meliora_base::error::{Error, Result, SourceFile};
use meliora_certify::{self as certify, Hashes, Verdict};
use meliora_dump::directory::{check_directory, sha256, write_directory};
use meliora_engine::{Engine, Scope, Settings, SymbolicEngine};
use meliora_export::{DumpContent, Inputs, export};
use meliora_lang as lang;
use meliora_model::Program;
use meliora_planning as planning;

impl Analysis {
    /// Writes a dump with a certificate into a directory, as `meliora export` does; an older dump there
    /// is replaced. `preferences` is their text. Cost: the analysis once more, with the diagrams and the remembered results
    /// of the symbolic engine, and then one image per layer of each region. The states of an explicit engine are
    /// explored again as diagrams.
    ///
    /// # Errors
    /// The directory contains something else, or cannot be written; an objective is called `nothing`; a
    /// limit is reached.
    pub fn export(&self, preferences: &SourceFile, directory: &Path) -> Result<()> {
        check_directory(directory)?;
        let (program, settings) = (self.exploration().own_program(), self.whole_engine().settings().clone());
        let (model, sink) = (Arc::clone(&program.source), Arc::clone(&settings.sink));
        // Other players than those of the engine's program need a program of their own.
        let engine = match self.whole_engine().symbolic() {
            Some(engine) if Arc::ptr_eq(engine.program(), &program) => Arc::clone(engine),
            _ => Arc::new(SymbolicEngine::new(program, settings)?),
        };
        let own = Arc::new(self.preferences().clone());
        let mut analysis = planning::Analysis::new(&engine, &own, self.options());
        analysis.run(&mut |_| ())?;
        let input = |source: &SourceFile| (source.name.clone(), sha256(source.original().as_bytes()));
        let inputs = Inputs { model: input(&model), preferences: input(preferences) };
        let dump = export(&analysis, &inputs, &DumpContent { wanted: &|_| true, certificate: true })?;
        write_directory(dump, directory, false, &*sink).map(drop)
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
        let (dump, picture) = certify::read(directory, &*settings.sink)?;
        let program = Program::clone(self.program());
        let lang::Task { mut program, preferences: own } = lang::load_preferences(preferences, program)?;
        if let Some(coalition) = &self.named {
            program.play_as(coalition);
        }
        if dump.certificate.is_none() {
            return Err(Error::Usage("the dump has no certificate".to_owned()));
        }
        let scope: Option<Scope> = dump.manifest.scope.parse().ok();
        let wrong =
            || Error::Usage(format!("the scope of the dump is `{}`", dump.manifest.scope.escape_debug()));
        let settings = Settings { scope: scope.ok_or_else(wrong)?, ..settings };
        let program = Arc::new(program);
        let [model, wishes] = [&program.source, preferences].map(|text| sha256(text.original().as_bytes()));
        let hashes = Hashes { model: &model, preferences: &wishes };
        let mut verdict = certify::verify(&program, &own, hashes, &dump, settings)?;
        verdict.violation = verdict.violation.or(picture);
        Ok((program, verdict))
    }
}
