//! Types for embedding the library, exported at the crate root: owners without lifetimes, which any
//! language can hold.
//!
//! A [`Model`] is read from a text. [`Model::explore`] builds an [`Exploration`] with either
//! engine. An exploration answers with sets of states ([`States`]), for any number of targets and
//! preferences, without exploring again. [`Exploration::prefer`] returns an
//! [`Analysis`], which has further methods here for sets, strategies and reports.
//! Clones are cheap: they share results.
//!
//! Each file imports only files before it: `states`, `members`, `analysis`, `exploration`,
//! `named_states`, `projection`, `model`, `task`,
//! `questions`, `kept`,
//! `policy_text`, `ask`, `results`, `quantities`, `levels`, `record`, `episodes`, `dumps`, `work`, `shield`, `check`, `compare`, `strategies`, `page`, `report`, `values`, `dump_files`, `explicit_files`,
//! `induced_files`, `region_dump`, `policies`, `sweep`.

mod analysis;
mod ask;
#[cfg(feature = "output")]
pub mod check;
#[cfg(feature = "output")]
mod compare;
#[cfg(feature = "output")]
pub mod dump_files;
mod dumps;
mod episodes;
#[cfg(feature = "output")]
pub mod explicit_files;
mod exploration;
#[cfg(feature = "output")]
pub mod induced_files;
mod kept;
mod levels;
mod members;
mod model;
mod named_states;
#[cfg(feature = "output")]
mod page;
#[cfg(feature = "output")]
mod policies;
#[cfg(feature = "output")]
pub mod policy_text;
mod projection;
mod quantities;
mod questions;
mod record;
#[cfg(feature = "output")]
pub mod region_dump;
#[cfg(feature = "output")]
mod report;
mod results;
#[cfg(feature = "output")]
mod shield;
mod states;
#[cfg(feature = "output")]
pub mod strategies;
#[cfg(feature = "output")]
pub mod sweep;
mod task;
#[cfg(feature = "output")]
pub mod values;
#[cfg(feature = "output")]
mod work;

pub use analysis::Analysis;
pub use ask::{Ask, AskResult};
#[cfg(feature = "output")]
pub use compare::compare;
pub use dumps::GivenDump;
pub use episodes::{Missed, Position, ShieldTable};
pub use exploration::{Exploration, Reached};
pub use kept::Kept;
pub use members::Listing;
pub use model::Model;
pub use named_states::{NamedStates, listed};
#[cfg(feature = "output")]
pub use page::PageRun;
#[cfg(feature = "output")]
pub use policies::{GivenPolicy, PolicyAim};
pub use projection::Projection;
pub use quantities::Wanted;
pub use questions::{Properties, PropertyFile, Terms};
pub use record::{Record, RecordedRun};
#[cfg(feature = "output")]
pub use report::Drawing;
pub use results::strategy_of;
pub use states::States;
pub use task::Task;
#[cfg(feature = "output")]
pub use work::Work;
