//! Strategies: the permitted and taken choices in each state, and the reasons.

pub(crate) mod achieve;
mod decision_rule;
pub mod explain;
pub mod finite_memory;
mod gains;
pub mod lasso;
mod of_analysis;
pub mod policy;
mod pursue;
mod standing;
pub mod strategy;
mod threat;
mod together;
mod verdict;

pub use decision_rule::DecisionRule;
pub use threat::Threat;
