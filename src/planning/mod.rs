//! Planning: outcomes, improvement, levels and strategies, once for all engines.
//!
//! | The paper | here |
//! | --- | --- |
//! | outcomes, MP(s) | [`winning_regions`], [`classes`] |
//! | Definition "Improvement MDP" | [`improvement`] |
//! | Algorithm "Level set", rank | [`levels`] |
//! | SPI and SASI strategies | [`strategy`], [`finite_memory`] |
//!
//! [`Analysis`] runs them one after the other and keeps what is known when a limit is hit. [`explain`]
//! says why a strategy does what it does, [`induced_model`] what can come of it, [`simulate`] what does.

pub mod analysis;
pub mod classes;
pub mod explain;
pub mod finite_memory;
pub mod improvement;
pub mod induced_model;
pub mod levels;
pub mod regions;
pub mod result;
pub mod simulate;
pub mod strategy;
pub mod temporal;
pub mod winning_regions;

pub use analysis::{Analysis, Event, Options, Phase};
pub use classes::{Class, Classes};
pub use explain::Explanation;
pub use finite_memory::{FiniteMemoryStrategy, Memory};
pub use improvement::{Improvement, Safety};
pub use induced_model::{InducedModel, Scheduler};
pub use levels::{Kind, Levels, Rank};
pub use result::AnalysisResult;
pub use simulate::{Setup, Simulation};
pub use winning_regions::WinningRegions;
