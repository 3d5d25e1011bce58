//! Temporal formulas: linear temporal logic in PRISM's syntax, and the monitors that evaluate it.
//!
//! A formula is read ([`parse_formula`]), brought into negation normal form (`normaliser`) and divided
//! into leaves, each with a deterministic monitor (`meliora_ltl`). The monitor becomes a variable
//! of the flat program (`install`), and the formula becomes a [`meliora_model::temporal::Condition`]
//! on states.

mod decided;
mod formula;
mod games;
mod install;
mod normaliser;
mod parse;
mod require;
mod stop;
#[cfg(test)]
mod tests;
mod wording;

pub use formula::{Formula, FormulaKind, Steps};
pub use install::Monitoring;
pub(crate) use parse::MOST_OPERATORS;
pub use parse::parse_formula;
pub use stop::Stopped;
