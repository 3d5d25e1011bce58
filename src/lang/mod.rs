//! The language front ends: text -> tokens -> syntax tree -> checked, flat program.

pub(crate) mod ast;
pub(crate) mod check;
mod combinations;
mod document;
pub(crate) mod flat;
pub(crate) mod jani;
mod load;
pub(crate) mod ltl;
mod mistaken;
pub(crate) mod named;
mod names;
pub(crate) mod parse;
pub(crate) mod pref;
mod preferences;
pub(crate) mod property;
pub(crate) mod property_file;
mod slip;
mod table;
pub(crate) mod token;
pub(crate) mod valuation;

pub use check::{Checked, lower_target};
pub use document::Document;
pub use flat::flat;
pub use load::{load, load_given, load_with_progress};
pub use parse::{parse_expression, parse_model};
pub use pref::parse_preferences;
pub use preferences::{load_preferences, outline_preferences};
pub use property::parse_property;
pub(crate) use property_file::{open_constants, parse_properties};
pub(crate) use valuation::split_constants;
pub use valuation::{Given, parse_constants, parse_state};
