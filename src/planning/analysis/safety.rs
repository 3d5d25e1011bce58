//! The safety mode. Each question about a mode is answered here, once.

use super::classes::Classes;
use super::improvement::{self, Arena};
use meliora_base::error::Result;
use meliora_engine::Engine;

meliora_base::named! {
    /// The safety mode, which selects the kept choices: `--safety`.
    #[derive(Default, strum::Display)]
    pub enum Safety {
        /// Drop every action with a successor that weakens the state. No step weakens the state before it,
        /// but several steps between incomparable states may still lose a sure objective of the start.
        Action,
        /// Drop weakening successors and keep the others, as in the paper's table. The dropped successors
        /// may still occur, so a strategy may weaken.
        Transition,
        /// Never weaken the state where planning started; after an improvement, the improved state.
        #[default]
        Prefix,
    }
}

impl Safety {
    /// Returns whether weakening successors are dropped while the other successors of their choice
    /// stay. Levels then count improvements that the model may miss.
    pub fn drops_successors(self) -> bool {
        match self {
            Safety::Transition => true,
            Safety::Action | Safety::Prefix => false,
        }
    }

    /// Returns whether steps are compared with a reference class, that of the state where planning
    /// started or of the last improvement, and not with the state that they leave. There is one arena
    /// per reference class then.
    pub fn has_reference(self) -> bool {
        match self {
            Safety::Prefix => true,
            Safety::Action | Safety::Transition => false,
        }
    }

    /// Returns whether no permitted step weakens the class that it is compared with.
    pub fn never_weakens(self) -> bool {
        match self {
            Safety::Action | Safety::Prefix => true,
            Safety::Transition => false,
        }
    }

    /// Computes the arenas of the improvement MDP; see [`improvement::Improvement::new`].
    pub(crate) fn arenas<E: Engine>(self, engine: &E, classes: &Classes<E>) -> Result<Vec<Arena<E>>> {
        match self {
            Safety::Action => Ok(vec![improvement::action(engine, classes)?]),
            Safety::Transition => Ok(vec![improvement::transition(engine, classes)?]),
            Safety::Prefix => improvement::prefix(engine, classes),
        }
    }
}
