//! The states of a program, listed one by one.
//!
//! - [`explore::Exploration`]: the states that a program reaches, with their choices and successors.
//! - [`weighted::Walker`]: the choices of any state, with exact probabilities, by its code.
//! - [`index::Index`]: the codes of states and their numbers.
//! - [`initial::Search`]: the initial states, without a look at all valuations.
//!
//! States are codes of a few words ([`layout`]). The expressions of a program are compiled once
//! ([`compile`], [`machine`], [`program`]); a [`stepper::Stepper`] evaluates them in one state after the
//! other. The explicit engine, numbers and exports stand on these.
//!
//! Bytes in memory, as [`meter::Meter`] counts them:
//!
//! | of | bytes |
//! | --- | --- |
//! | a state | 8 per word of its code, 5 to 10 for the table of numbers, 4 for its row of choices |
//! | a choice | 4 for its row of successors |
//! | a transition | 4 for the successor |
//! | kept lists | 2 per state for its commands, and 2 per choice for its probabilities |
//! | offers of participants | 2 per place of a table; at most 2 places per state, and 2^16 more |
//! | the reversed graph | 4 per state and per transition, and 0.75 per choice if states have several |
//!
//! ```
//! use std::sync::Arc;
//!
//! use meliora_base::error::SourceFile;
//! use meliora_space::{Limits, explore::Exploration};
//!
//! let model = "mdp module m x : [0..9] init 0; [] x<7 -> 1/2:(x'=x+1) + 1/2:(x'=x+2); endmodule";
//! let none = SourceFile::new("--const", "");
//! let program = meliora_lang::load(&SourceFile::new("m.prism", model), &none)?.program;
//! let (_, explored) = Exploration::new(Arc::new(program), Limits::default())?.finish()?;
//! assert_eq!((explored.graph.states(), explored.graph.choices()), (9, 9));
//! # Ok::<(), meliora_base::error::Error>(())
//! ```

mod batch;
pub mod bounds;
mod by_value;
pub mod compile;
pub mod enabled;
pub mod expand;
pub mod explore;
mod fractions;
pub mod graph;
mod guards;
pub mod index;
pub mod initial;
pub mod known;
pub mod layout;
mod lists;
mod lookup;
pub mod machine;
pub mod meter;
pub mod needs;
mod numbers;
mod offers;
mod players;
pub mod probabilities;
pub mod program;
pub mod set;
mod share;
mod states;
pub mod stepper;
mod steps;
#[cfg(test)]
mod tests;
pub mod total;
mod value_classes;
mod values;
mod weigher;
pub mod weighted;

use std::sync::Arc;

use meliora_base::progress::{NoProgress, ProgressSink};

/// The steps of diagrams that take about as long as a unit of work here: a state or a successor.
pub const STEPS_PER_WORK: u64 = 2;

meliora_base::named! {
    /// The valuations that count as states.
    #[derive(Default)]
    pub enum Scope {
        /// The valuations that are reachable from the initial states.
        #[default]
        Reachable,
        /// Every valuation of the declared variables.
        All,
    }
}

/// The extent of an exploration, and its limits.
#[derive(Clone)]
pub struct Limits {
    /// The valuations that count as states.
    pub scope: Scope,
    /// The most bytes of the arrays.
    pub memory: u64,
    /// True to keep the choices of each state by their commands, unless there are too many different lists of them.
    pub keeps_choices: bool,
    /// True to keep the probabilities of all choices, unless there are too many different lists of them.
    pub keeps_probabilities: bool,
    /// The progress sink, which also cancels work.
    pub sink: Arc<dyn ProgressSink>,
}

impl Default for Limits {
    fn default() -> Self {
        Limits {
            scope: Scope::Reachable,
            memory: 2 << 30,
            keeps_choices: false,
            keeps_probabilities: false,
            sink: Arc::new(NoProgress),
        }
    }
}
