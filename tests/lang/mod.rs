//! The languages: accepted text, its meaning, and the error messages.

mod arithmetic;
mod errors;
mod expressions;
mod jani;
mod meaning;
mod mistakes;
mod preferences;
mod rewards;
mod round_trip;
mod state_names;
