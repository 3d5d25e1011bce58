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
//! `projection`, `model`, `ask`, `results`, `quantities`, `levels`, `record`, `episodes`, `report`, `dumps`, `sweep`.

mod analysis;
mod ask;
mod dumps;
mod episodes;
mod exploration;
mod levels;
mod members;
mod model;
mod projection;
mod quantities;
mod record;
#[cfg(feature = "output")]
mod report;
mod results;
mod states;
#[cfg(feature = "output")]
pub mod sweep;

pub use analysis::Analysis;
pub use ask::{Ask, AskResult, Properties};
pub use episodes::{Missed, Position, ShieldTable};
pub use exploration::{Exploration, Reached};
pub use members::Listing;
pub use model::Model;
pub use projection::Projection;
pub use quantities::Wanted;
pub use record::{Record, RecordedRun};
#[cfg(feature = "output")]
pub use report::Drawing;
pub use states::States;
