//! A model with preferences over it.

use std::sync::Arc;

use super::Model;
use meliora_base::error::{Result, SourceFile};
use meliora_lang as lang;
use meliora_model::Program;
use meliora_model::predicate::Predicate;
use meliora_model::preference::Preferences;
use meliora_question::Warning;
use meliora_question::warnings::overlap;

/// A model with preferences over it, before it is explored.
#[derive(Debug, Clone)]
pub struct Task {
    /// The model; for whole paths, its product with the monitors.
    pub program: Arc<Program>,
    /// The preferences.
    pub preferences: Arc<Preferences>,
    /// The text of the preferences.
    pub source: Arc<SourceFile>,
    /// The states of a `dtmc` in which several choices are merged; see [`overlap`].
    pub overlap: Option<Predicate>,
}

impl Model {
    /// Reads preferences over the model. In a game we are the coalition that the text names, unless
    /// [`Model::with_coalition`] named one.
    ///
    /// # Errors
    /// The text is invalid; each error has its place.
    pub fn task(self, source: &Arc<SourceFile>) -> Result<Task> {
        let (named, program) = (self.named.clone(), self.into_program());
        let overlap = overlap(&program);
        let lang::Task { mut program, preferences } = lang::load_preferences(source, program)?;
        program.note_inexact(preferences.predicates());
        if let Some(coalition) = named {
            program.play_as(&coalition);
        }
        let (program, preferences) = (Arc::new(program), Arc::new(preferences));
        Ok(Task { program, preferences, source: Arc::clone(source), overlap })
    }
}

impl Task {
    /// Returns the warnings about the text of the preferences.
    pub fn warnings(&self) -> Vec<Warning> {
        let pointed = self.source.encoding_warning().map(|warning| Warning::Pointed(vec![warning]));
        let texts = self.preferences.warnings().into_iter();
        let texts = texts.map(|warning| Warning::Text(format!("{} {warning}", self.source.name)));
        pointed.into_iter().chain(texts).collect()
    }
}
