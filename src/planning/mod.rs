//! Planning: winning regions, improvement MDP, levels and strategies, written once for all engines.
//!
//! | The paper | here |
//! | --- | --- |
//! | (beyond the paper) requirements | [`requirements`] |
//! | outcomes, MP(s) | [`winning_regions`], [`classes`] |
//! | Definition "Improvement MDP" | [`improvement`] |
//! | Algorithm "Level set", rank | [`levels`] |
//! | SPI and SASI strategies | [`strategy`], [`finite_memory`] |
//!
//! [`Analysis`] runs them one after the other and keeps its results when a limit is reached.
//! [`explain`] says why an action is permitted, [`induced_model`] computes the states that a
//! strategy may visit, [`simulate`] draws random runs, and [`shield`] makes a table of permitted
//! actions.

pub(crate) mod achieve;
pub(crate) mod analysis;
pub mod classes;
pub(crate) mod decision_rule;
pub(crate) mod estimate;
pub mod explain;
pub mod finite_memory;
pub mod improvement;
pub mod induced_model;
pub(crate) mod joint;
mod level_search;
pub mod levels;
mod phases;
mod pursue;
pub mod regions;
pub mod requirements;
pub mod result;
pub mod shield;
pub mod simulate;
pub mod strategy;
pub mod tally;
pub mod temporal;
pub mod winning_regions;

pub use analysis::{Analysis, Event, Options, Phase};
pub use classes::{Class, Classes};
pub(crate) use decision_rule::DecisionRule;
pub use estimate::Sample;
pub use explain::Explanation;
pub use finite_memory::{FiniteMemoryStrategy, Memory, StrategyKind};
pub use improvement::{Improvement, Safety};
pub use induced_model::{InducedModel, Scheduler};
pub use levels::{Kind, Levels, Rank};
pub use requirements::Requirements;
pub use result::AnalysisResult;
pub use shield::{Shield, ShieldNode, ShieldVariable};
pub use simulate::{Setup, Simulation};
