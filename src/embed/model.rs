//! A model that was read.

use std::path::Path;
use std::sync::Arc;

use super::Exploration;
use crate::engine::{AnyEngine, Settings};
use crate::error::{Diagnostic, Result, SourceFile};
use crate::lang::{self, Given};
use crate::model::value::{Type, Value};
use crate::model::{ModelKind, Program, State};
use crate::progress::{NoProgress, ProgressSink};

/// A model in PRISM's language or in JANI, checked and flat; nothing of it is explored.
#[derive(Debug, Clone)]
pub struct Model {
    program: Arc<Program>,
    warnings: Vec<Diagnostic>,
}

impl Model {
    /// Reads a file. `constants` gives the undefined constants their values: `K=4,N=3`, or nothing.
    ///
    /// # Errors
    /// The file cannot be read; what is wrong in it, each with its place.
    pub fn open(path: impl AsRef<Path>, constants: &str) -> Result<Self> {
        Self::of(&SourceFile::open(path.as_ref())?, constants)
    }

    /// Reads a text, as [`Model::open`] reads a file.
    ///
    /// # Errors
    /// What is wrong in it, each with its place.
    pub fn parse(text: impl Into<String>, constants: &str) -> Result<Self> {
        Self::of(&SourceFile::new("model", text), constants)
    }

    fn of(source: &Arc<SourceFile>, constants: &str) -> Result<Self> {
        let constants = SourceFile::new("constants", constants);
        let given = Given { constants, bounds: SourceFile::new("bounds", "") };
        Self::given(source, &given, &NoProgress)
    }

    /// Reads a text with all that may be said of it from outside; `sink` may end the work.
    ///
    /// # Errors
    /// What is wrong in the texts, each with its place; a limit.
    pub fn given(source: &Arc<SourceFile>, given: &Given, sink: &dyn ProgressSink) -> Result<Self> {
        let checked = lang::load_given(source, given, sink)?;
        Ok(Model { program: Arc::new(checked.program), warnings: checked.warnings })
    }

    /// The flat program.
    pub fn program(&self) -> &Arc<Program> {
        &self.program
    }

    /// What is suspicious in the text, but no error.
    pub fn warnings(&self) -> &[Diagnostic] {
        &self.warnings
    }

    /// `mdp` or `dtmc`.
    pub fn kind(&self) -> ModelKind {
        self.program.kind
    }

    /// Explores the states of the scope with the engine that the settings name.
    ///
    /// # Errors
    /// A limit; what has no meaning in some state of the scope, with an example; an order that is wrong.
    pub fn explore(&self, settings: Settings) -> Result<Exploration> {
        Ok(Exploration::of(AnyEngine::new(Arc::clone(&self.program), settings)?))
    }

    /// Reads a state: `r=2,c=2,d=false`. Variables left out take their initial value.
    ///
    /// # Errors
    /// Unknown variables and values out of their range, each with its place.
    pub fn state(&self, text: &str) -> Result<State> {
        lang::parse_state(&SourceFile::new("state", text), &self.program)
    }

    /// A state as values by the names of their variables, in the order of declaration.
    pub fn values<'s>(&'s self, state: &'s [i64]) -> impl Iterator<Item = (&'s str, Value)> {
        self.program.variables.iter().zip(state).map(|(variable, &value)| {
            let value = if variable.ty == Type::Bool { Value::Bool(value != 0) } else { Value::Int(value) };
            (variable.name.as_str(), value)
        })
    }
}
