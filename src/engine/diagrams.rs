//! Access to the decision diagrams of an engine that may have them.

use super::any::{AnyChoices, AnyEngine, AnyStates};
use super::symbolic::{ChoiceSet, StateSet, SymbolicEngine};
use super::{Engine, Storage};
use crate::error::{Error, Result};

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
    /// # Panics
    /// The set is not a diagram; [`Dumpable::diagrams`] fails in this case.
    fn states_diagram<'s>(&self, x: &'s Self::States) -> &'s StateSet;

    /// Returns the diagrams of a choice set.
    ///
    /// # Panics
    /// The set is not a diagram; [`Dumpable::diagrams`] fails in this case.
    fn choices_diagram<'s>(&self, c: &'s Self::Choices) -> &'s ChoiceSet;
}

impl Dumpable for SymbolicEngine {
    fn diagrams(&self) -> Result<&SymbolicEngine> {
        Ok(self)
    }

    fn states_diagram<'s>(&self, x: &'s StateSet) -> &'s StateSet {
        x
    }

    fn choices_diagram<'s>(&self, c: &'s ChoiceSet) -> &'s ChoiceSet {
        c
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

    fn states_diagram<'s>(&self, x: &'s AnyStates) -> &'s StateSet {
        match x {
            AnyStates::Symbolic(x) => x,
            AnyStates::Explicit(_) => panic!("a set of states that is not a diagram"),
        }
    }

    fn choices_diagram<'s>(&self, c: &'s AnyChoices) -> &'s ChoiceSet {
        match c {
            AnyChoices::Symbolic(c) => c,
            AnyChoices::Explicit(_) => panic!("a set of choices that is not a diagram"),
        }
    }
}
