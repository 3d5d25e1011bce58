//! Sets of states with their engine.

use std::fmt;

use meliora_base::error::Result;
use meliora_engine::any::AnyStates;
use meliora_engine::{Algebra, AnyEngine, Count, Engine};
use meliora_model::State;

/// The size of small diagrams, in nodes: operations on two of them take milliseconds.
const SMALL_DIAGRAM: usize = 500;
/// The size of small scopes, in states: operations on their sets take milliseconds.
const SMALL_SCOPE: usize = 1 << 16;

/// A set of states of an [`Exploration`](super::Exploration).
///
/// Sets of different explorations are never equal, and operations that combine them fail.
#[derive(Clone)]
pub struct States {
    engine: AnyEngine,
    set: AnyStates,
}

impl States {
    pub(super) fn new(engine: &AnyEngine, set: AnyStates) -> Self {
        States { engine: engine.clone(), set }
    }

    /// Returns the engine of the set.
    pub fn engine(&self) -> &AnyEngine {
        &self.engine
    }

    /// Returns the set in the representation of the engine.
    pub fn set(&self) -> &AnyStates {
        &self.set
    }

    /// Returns |X|.
    pub fn count(&self) -> Result<Count> {
        self.engine.count(&self.set)
    }

    /// Returns true if X = ∅.
    pub fn is_empty(&self) -> Result<bool> {
        self.engine.is_empty(&self.set)
    }

    /// Returns true if s ∈ X.
    pub fn contains(&self, state: &[i64]) -> Result<bool> {
        Ok(state.len() == self.engine.program().variables.len() && self.engine.contains(&self.set, state)?)
    }

    /// Lists up to `limit` states in the order of their values, first variable first.
    pub fn list(&self, limit: usize) -> Result<Vec<State>> {
        self.engine.list_states(&self.set, limit)
    }

    /// Returns true if operations on this set take milliseconds: its diagram, or the scope of the
    /// explicit engine, is small.
    pub fn is_small(&self) -> bool {
        match (&self.set, self.engine.symbolic()) {
            (AnyStates::Symbolic(x), Some(engine)) => {
                engine.has_nodes(x, SMALL_DIAGRAM).is_ok_and(|large| !large)
            }
            (AnyStates::Explicit(x), _) => x.capacity() < SMALL_SCOPE,
            (AnyStates::Symbolic(_), None) => false,
        }
    }

    /// Returns X ∪ Y.
    ///
    /// # Errors
    /// [`ForeignSet`](meliora_base::error::Error::ForeignSet) if the other set belongs to another exploration; a limit is reached.
    pub fn union(&self, other: &States) -> Result<States> {
        Ok(States::new(&self.engine, self.engine.union(&self.set, &other.set)?))
    }

    /// Returns X ∩ Y.
    ///
    /// # Errors
    /// The errors of [`States::union`].
    pub fn intersection(&self, other: &States) -> Result<States> {
        Ok(States::new(&self.engine, self.engine.intersection(&self.set, &other.set)?))
    }

    /// Returns X \ Y.
    ///
    /// # Errors
    /// The errors of [`States::union`].
    pub fn difference(&self, other: &States) -> Result<States> {
        Ok(States::new(&self.engine, self.engine.difference(&self.set, &other.set)?))
    }

    /// Returns X △ Y.
    ///
    /// # Errors
    /// The errors of [`States::union`].
    pub fn symmetric_difference(&self, other: &States) -> Result<States> {
        self.difference(other)?.union(&other.difference(self)?)
    }

    /// Returns S \ X.
    pub fn complement(&self) -> Result<States> {
        let all = self.engine.all_states();
        Ok(States::new(&self.engine, self.engine.difference(&all, &self.set)?))
    }

    /// Returns true if X ⊆ Y.
    ///
    /// # Errors
    /// The errors of [`States::union`].
    pub fn is_subset(&self, other: &States) -> Result<bool> {
        self.difference(other)?.is_empty()
    }
}

/// Sets of different explorations are not equal.
impl PartialEq for States {
    fn eq(&self, other: &Self) -> bool {
        self.engine.same(&self.set, &other.set).unwrap_or(false)
    }
}

impl Eq for States {}

/// The number of states that are shown.
const SHOWN: usize = 3;

/// Formats a set as `{x=1,y=2; x=3,y=0}`, with the number of further states; with the error, if a
/// limit is reached.
impl fmt::Display for States {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (count, shown) = match (self.count(), self.list(SHOWN)) {
            (Ok(count), Ok(shown)) => (count, shown),
            (Err(error), _) | (_, Err(error)) => return write!(f, "{{… {error}}}"),
        };
        let program = self.engine.program();
        let shown: Vec<String> = shown.iter().map(|state| program.show_state(state)).collect();
        write!(f, "{{{}", shown.join("; "))?;
        let listed = Count::from(shown.len());
        if count > listed { write!(f, "; … and {} more}}", count - listed) } else { write!(f, "}}") }
    }
}

impl fmt::Debug for States {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "States{self}")
    }
}
