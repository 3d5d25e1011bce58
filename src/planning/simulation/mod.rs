//! Runs under a strategy: induced models, random runs and their statistics.

pub mod estimate;
pub mod induced_model;
mod opponent;
pub mod simulate;
pub mod tally;

pub use opponent::Opponent;
