//! Sets of states that know where they come from.

use std::fmt;

use crate::engine::any::AnyStates;
use crate::engine::{Algebra, AnyEngine, Count, Engine};
use crate::error::{Error, Result};
use crate::model::State;

/// Operations on two diagrams of so many nodes are done in milliseconds.
const SMALL_DIAGRAM: usize = 500;
/// And those on sets out of so many states.
const SMALL_SCOPE: usize = 1 << 16;

/// A set of states of an [`Exploration`](super::Exploration).
///
/// Sets of different explorations are never equal, and no operation takes them together.
#[derive(Clone)]
pub struct States {
    engine: AnyEngine,
    set: AnyStates,
}

impl States {
    pub(super) fn of(engine: &AnyEngine, set: AnyStates) -> Self {
        States { engine: engine.clone(), set }
    }

    /// The set, for the engine that it is of.
    ///
    /// # Errors
    /// [`Error::Usage`] where it is of another one.
    pub(super) fn within(&self, engine: &AnyEngine) -> Result<&AnyStates> {
        if self.engine.shares(engine) {
            return Ok(&self.set);
        }
        Err(Error::Usage("the set of states belongs to another exploration".to_owned()))
    }

    /// The engine that it is of.
    pub fn engine(&self) -> &AnyEngine {
        &self.engine
    }

    /// The set as the engine has it.
    pub fn set(&self) -> &AnyStates {
        &self.set
    }

    /// |X|
    ///
    /// # Errors
    /// A limit.
    pub fn count(&self) -> Result<Count> {
        self.engine.count(&self.set)
    }

    /// X = ∅
    pub fn is_empty(&self) -> bool {
        self.engine.is_empty(&self.set)
    }

    /// s ∈ X
    pub fn contains(&self, state: &[i64]) -> bool {
        state.len() == self.engine.program().variables.len() && self.engine.contains(&self.set, state)
    }

    /// Up to `limit` states in the order of their values, first variable first.
    ///
    /// # Errors
    /// A limit.
    pub fn list(&self, limit: usize) -> Result<Vec<State>> {
        self.engine.list_states(&self.set, limit)
    }

    /// Whether an operation on this set takes a moment only: its diagram, or the scope of an engine without
    /// diagrams, is small.
    pub fn is_small(&self) -> bool {
        match (&self.set, self.engine.symbolic()) {
            (AnyStates::Symbolic(x), Some(engine)) => !engine.has_nodes(x, SMALL_DIAGRAM),
            (AnyStates::Explicit(x), _) => x.capacity() < SMALL_SCOPE,
            (AnyStates::Symbolic(_), None) => false,
        }
    }

    /// X ∪ Y
    ///
    /// # Errors
    /// A limit; [`Error::Usage`] where the other set is of another exploration.
    pub fn union(&self, other: &States) -> Result<States> {
        Ok(States::of(&self.engine, self.engine.union(&self.set, other.within(&self.engine)?)?))
    }

    /// X ∩ Y
    ///
    /// # Errors
    /// Those of [`States::union`].
    pub fn intersection(&self, other: &States) -> Result<States> {
        Ok(States::of(&self.engine, self.engine.intersection(&self.set, other.within(&self.engine)?)?))
    }

    /// X \ Y
    ///
    /// # Errors
    /// Those of [`States::union`].
    pub fn difference(&self, other: &States) -> Result<States> {
        Ok(States::of(&self.engine, self.engine.difference(&self.set, other.within(&self.engine)?)?))
    }

    /// X △ Y
    ///
    /// # Errors
    /// Those of [`States::union`].
    pub fn symmetric_difference(&self, other: &States) -> Result<States> {
        self.difference(other)?.union(&other.difference(self)?)
    }

    /// S \ X
    ///
    /// # Errors
    /// A limit.
    pub fn complement(&self) -> Result<States> {
        let all = self.engine.all_states();
        Ok(States::of(&self.engine, self.engine.difference(&all, &self.set)?))
    }

    /// X ⊆ Y
    ///
    /// # Errors
    /// Those of [`States::union`].
    pub fn is_subset(&self, other: &States) -> Result<bool> {
        Ok(self.difference(other)?.is_empty())
    }
}

impl PartialEq for States {
    fn eq(&self, other: &Self) -> bool {
        self.engine.shares(&other.engine) && self.engine.same(&self.set, &other.set)
    }
}

impl Eq for States {}

/// So many states are shown.
const SHOWN: usize = 3;

/// `{x=1,y=2; x=3,y=0}`, with how many more there are.
impl fmt::Display for States {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // What a limit stops is not shown.
        let (count, shown) = (self.count().unwrap_or_default(), self.list(SHOWN).unwrap_or_default());
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
