//! The languages: PRISM, JANI, preferences, properties and temporal formulas. A text becomes tokens,
//! a syntax tree, and a checked, flat program.
//!
//! - [`load`]: a model from a text, as [`Checked`].
//! - [`load_preferences`]: a preference file for a program.
//! - [`parse_property`], [`parse_expression`], [`parse_state`]: smaller texts.
//!
//! ```
//! use meliora_base::error::SourceFile;
//!
//! let model = "mdp module m x : [0..N] init 0; [] x<N -> 1/2: (x'=x+1) + 1/2: true; endmodule const int N;";
//! let constants = SourceFile::new("--const", "N=4");
//! let program = meliora_lang::load(&SourceFile::new("m.prism", model), &constants)?.program;
//! assert_eq!((program.variables[0].low, program.variables[0].high), (0, 4));
//! # Ok::<(), meliora_base::error::Error>(())
//! ```

pub mod ast;
mod atoms;
pub(crate) mod check;
mod combinations;
pub mod flat;
pub(crate) mod jani;
mod load;
pub mod ltl;
mod mistaken;
pub mod named;
pub mod names;
pub(crate) mod parse;
mod players;
pub mod pref;
mod preferences;
pub mod property;
pub mod property_file;
pub mod refusal;
pub(crate) mod token;
pub(crate) mod valuation;

pub use check::{Actions, Checked, lower_target};
pub use flat::flat;
pub use load::{load, load_given};
pub use parse::{parse_expression, parse_model};
pub use players::parse_coalition;
pub use pref::parse_preferences;
pub use preferences::{
    Task, implied_objectives, load_preferences, outline_preferences, outline_preferences_for,
};
pub use property::parse_property;
pub use property_file::{open_constants, outline_properties, parse_properties, refuse_values};
pub use token::BUILT_IN_LABELS;
pub use valuation::split_constants;
pub use valuation::{Given, Place, parse_constants, parse_state, parse_states};
