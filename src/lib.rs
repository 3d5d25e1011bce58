//! Meliora: a symbolic model checker for opportunistic planning with incomplete preferences.

pub mod certify;
pub mod diagnostic;
pub mod dump;
pub mod engine;
pub mod error;
pub mod export;
pub mod generate;
pub mod lang;
pub mod model;
pub mod output;
pub mod planning;
pub mod query;
mod random;
