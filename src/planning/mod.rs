//! Planning: outcomes, improvement, levels and strategies, once for all engines.
//!
//! | The paper | here |
//! | --- | --- |
//! | outcomes, MP(s) | [`outcomes`], [`classes`] |
//! | Definition "Improvement MDP" | [`improvement`] |
//! | Algorithm "Level set", rank | [`levels`] |
//! | SPI and SASI strategies | [`strategy`] |
//!
//! [`Analysis`] runs them one after the other and keeps what is known when a limit is hit.

pub mod analysis;
pub mod classes;
pub mod improvement;
pub mod levels;
pub mod outcomes;
pub mod result;
pub mod strategy;

pub use analysis::{Analysis, Event, Options, Phase};
pub use classes::{Class, Classes};
pub use improvement::{Improvement, Safety};
pub use levels::{Kind, Levels, Rank};
pub use outcomes::Outcomes;
pub use result::AnalysisResult;
