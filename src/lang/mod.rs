//! The language front ends: text -> tokens -> syntax tree -> checked, flat program.

pub mod ast;
pub mod check;
mod combinations;
pub mod flat;
pub mod jani;
mod load;
pub mod ltl;
mod mistaken;
pub mod named;
mod names;
pub mod parse;
pub mod pref;
mod preferences;
pub mod property;
pub mod property_file;
mod slip;
pub mod token;
pub mod valuation;

pub use check::{Checked, lower_target};
pub use flat::flat;
pub use load::{load, load_given, load_with_progress};
pub use parse::{parse_expression, parse_model};
pub use pref::parse_preferences;
pub use preferences::{load_preferences, lower_preferences, outline_preferences};
pub use property::parse_property;
pub use property_file::{open_constants, parse_properties};
pub use valuation::{Given, parse_constants, parse_state, split_constants};
