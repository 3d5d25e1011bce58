//! The language front end: text -> tokens -> syntax tree -> checked, flat program.

pub mod ast;
pub mod check;
pub mod flat;
pub mod parse;
pub mod pref;
pub mod print;
pub mod property;
pub mod token;
pub mod valuation;

pub use check::{Checked, check, load, load_observed, load_preferences, lower_preferences, lower_target};
pub use flat::flat;
pub use parse::{parse_expression, parse_model};
pub use pref::parse_preferences;
pub use property::parse_property;
pub use valuation::{parse_constants, parse_state};
