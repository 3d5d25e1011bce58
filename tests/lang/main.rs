//! The languages: accepted text, its meaning, and the error messages.

#[allow(dead_code, reason = "each program takes a part")]
#[path = "../common/amount.rs"]
mod amount;
mod arithmetic;
#[path = "../common/brute.rs"]
#[allow(dead_code, unreachable_pub, reason = "only the list of valuations is used")]
mod brute;
mod errors;
mod expressions;
mod jani;
mod meaning;
mod mistakes;
mod preferences;
#[path = "../common/random_program.rs"]
#[allow(dead_code, unreachable_pub, reason = "only programs are used")]
mod random_program;
mod rewards;
mod round_trip;
mod state_names;
