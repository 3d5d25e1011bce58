//! Tests of many states for membership in several sets.

use std::ops::Range;
use std::sync::Arc;

use super::engine::Engine;
use meliora_base::error::Result;
use meliora_space::enabled::Enabled;
use meliora_space::probabilities::Probabilities;

/// The greatest number of sets of a [`Membership`].
pub const MOST: usize = u64::BITS as usize;

/// Tests states for membership in several sets at once.
pub trait Membership: Sync {
    /// Returns the sets that contain a state: bit i for set i.
    ///
    /// # Errors
    /// A set belongs to another engine.
    fn of(&self, state: &[i64]) -> Result<u64>;

    /// Returns the numbers of the states, if the engine stores them one by one.
    fn numbers(&self) -> Option<&dyn Numbers> {
        None
    }
}

/// The states of an engine that stores them one by one, by number.
pub trait Numbers {
    /// Returns the number of states.
    fn states(&self) -> usize;

    /// Returns the number of the state with a code of [`Codec`](meliora_space::weighted::Codec);
    /// `None` outside the scope.
    fn number(&self, code: &[u64]) -> Option<u32>;

    /// Returns the code of a state.
    fn code(&self, number: u32) -> &[u64];

    /// Returns the sets that contain a state: bit i for set i.
    fn marks(&self, number: u32) -> u64;

    /// Returns the numbers of the choices of a state, in the order of [`Program::steps`](meliora_model::Program::steps).
    fn choices(&self, number: u32) -> Range<usize>;

    /// Returns the choices of the states by their commands, if the engine keeps them.
    fn kept_choices(&self) -> Option<&Arc<Enabled>>;

    /// Returns the probabilities of the choices, if the engine keeps them.
    fn probabilities(&self) -> Option<&Arc<Probabilities>>;

    /// Returns the successors of a choice, each once; in the order of the values if the probabilities are kept.
    fn successors(&self, choice: usize) -> &[u32];
}

/// Tests one set after the other.
pub(crate) struct Each<'e, E: Engine> {
    engine: &'e E,
    sets: Vec<E::States>,
}

impl<'e, E: Engine> Each<'e, E> {
    /// Creates the test for at most [`MOST`] sets.
    pub(crate) fn new(engine: &'e E, sets: &[&E::States]) -> Self {
        Each { engine, sets: sets.iter().map(|&x| x.clone()).collect() }
    }
}

impl<E: Engine> Membership for Each<'_, E> {
    fn of(&self, state: &[i64]) -> Result<u64> {
        let mut found = 0;
        for (number, x) in self.sets.iter().enumerate() {
            found |= u64::from(self.engine.contains(x, state)?) << number;
        }
        Ok(found)
    }
}
