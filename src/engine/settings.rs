//! Settings of an engine, and its use of resources.

use std::sync::Arc;

use num_bigint::BigUint;

use super::symbolic::order::Order;
use super::symbolic::store::thresholds::Thresholds;
use meliora_base::progress::{NoProgress, ProgressSink};
use meliora_space::Limits;
pub use meliora_space::Scope;

/// An exact number of states, choices or transitions.
pub type Count = BigUint;

meliora_base::named! {
    /// The way an engine stores states.
    #[derive(Default)]
    pub enum Storage {
        /// Sets of states are binary decision diagrams.
        #[default]
        Symbolic,
        /// States are stored one by one; for small models and cross-checks.
        Explicit,
    }
}

/// The settings of an engine. Only the scope has an influence on results.
#[derive(Clone)]
pub struct Settings {
    /// The valuations that count as states.
    pub scope: Scope,
    /// The kind of engine that [`AnyEngine::new`](crate::AnyEngine::new) creates.
    pub storage: Storage,
    /// The memory limit in bytes: for the node table, the operation cache, relation lists and
    /// intermediate results of the symbolic engine, or for the arrays of the explicit engine.
    pub memory: u64,
    /// The order of the bits in decision diagrams.
    pub order: Order,
    /// The thresholds at which the symbolic engine switches between methods with the same result.
    pub thresholds: Thresholds,
    /// The number of threads of a [`Selection`](crate::Selection) that is open: as many ways run at once.
    pub threads: usize,
    /// True if the explicit engine keeps the choices of each state by their commands: for the rewards and the names of choices.
    pub keeps_choices: bool,
    /// True if it keeps the probabilities of all choices: for numbers.
    pub keeps_probabilities: bool,
    /// The progress sink, which also cancels work.
    pub sink: Arc<dyn ProgressSink>,
}

impl Default for Settings {
    fn default() -> Self {
        Settings {
            scope: Scope::Reachable,
            storage: Storage::Symbolic,
            memory: 2 << 30,
            order: Order::Auto,
            thresholds: Thresholds::default(),
            threads: 1,
            keeps_choices: false,
            keeps_probabilities: false,
            sink: Arc::new(NoProgress),
        }
    }
}

impl Settings {
    /// Ends the other ways of a race before work that costs the same on each of them. Returns the bytes of memory that this
    /// way has from then on.
    pub fn settle(&self) -> u64 {
        self.sink.settle().unwrap_or(self.memory)
    }

    /// Returns the extent and the limits of an exploration.
    pub(crate) fn limits(&self) -> Limits {
        Limits {
            scope: self.scope,
            memory: self.memory,
            keeps_choices: self.keeps_choices,
            keeps_probabilities: self.keeps_probabilities,
            sink: Arc::clone(&self.sink),
        }
    }
}

/// The resources that an engine has used.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Usage {
    /// The largest number of diagram nodes alive at once; 0 without diagrams.
    pub peak_nodes: u64,
    /// The bytes of the engine's own tables.
    pub bytes: u64,
    /// The steps of all recursions over diagrams: a measure of work that does not depend on the machine; 0 without diagrams.
    pub steps: u64,
}
