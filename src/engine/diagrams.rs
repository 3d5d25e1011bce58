//! Access to the decision diagrams of an engine that may have them.

use super::any::{AnyChoices, AnyEngine, AnyStates};
use super::engine::Engine;
use super::settings::Storage;
use super::symbolic::{ChoiceSet, StateSet, SymbolicEngine};
use meliora_base::error::{Error, Result};

/// An engine whose sets may be decision diagrams. Code that draws or writes diagrams accepts any
/// such engine.
pub trait Dumpable: Engine {
    /// Returns the symbolic engine that owns the diagrams.
    ///
    /// # Errors
    /// [`Error::Usage`] if the sets are not decision diagrams.
    fn diagrams(&self) -> Result<&SymbolicEngine>;

    /// Returns the diagram of a state set.
    ///
    /// # Errors
    /// The set is not a diagram.
    fn states_diagram<'s>(&self, x: &'s Self::States) -> Result<&'s StateSet>;

    /// Returns the diagrams of a choice set.
    ///
    /// # Errors
    /// The set is not a diagram.
    fn choices_diagram<'s>(&self, c: &'s Self::Choices) -> Result<&'s ChoiceSet>;
}

impl Dumpable for SymbolicEngine {
    fn diagrams(&self) -> Result<&SymbolicEngine> {
        Ok(self)
    }

    fn states_diagram<'s>(&self, x: &'s StateSet) -> Result<&'s StateSet> {
        Ok(x)
    }

    fn choices_diagram<'s>(&self, c: &'s ChoiceSet) -> Result<&'s ChoiceSet> {
        Ok(c)
    }
}

impl Dumpable for AnyEngine {
    fn diagrams(&self) -> Result<&SymbolicEngine> {
        let none = || {
            let message = format!(
                "this needs decision diagrams; the engine `{}` has none, the engine `{}` has them",
                Storage::Explicit.name(),
                Storage::Symbolic.name()
            );
            Error::Usage(message)
        };
        Ok(self.symbolic().ok_or_else(none)?)
    }

    fn states_diagram<'s>(&self, x: &'s AnyStates) -> Result<&'s StateSet> {
        match x {
            AnyStates::Symbolic(x) => Ok(x),
            AnyStates::Explicit(_) => Err(Error::ForeignSet),
        }
    }

    fn choices_diagram<'s>(&self, c: &'s AnyChoices) -> Result<&'s ChoiceSet> {
        match c {
            AnyChoices::Symbolic(c) => Ok(c),
            AnyChoices::Explicit(_) => Err(Error::ForeignSet),
        }
    }
}
