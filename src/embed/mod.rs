//! Types for embedding the library: owners without lifetimes, which any language can hold.
//!
//! A [`Model`] is read from a text. [`Model::explore`] builds an [`Exploration`] with either
//! engine. An exploration answers with sets of states ([`States`]), for any number of targets and
//! preferences, without exploring again. A [`Planning`] is an analysis under preferences; a
//! [`Strategy`] selects actions. Clones are cheap: they share results.

mod exploration;
mod members;
mod model;
mod planning;
mod projection;
#[cfg(feature = "output")]
mod report;
mod states;

pub use exploration::Exploration;
pub use members::Listing;
pub use model::Model;
pub use planning::{Planning, Strategy};
pub use projection::Projection;
#[cfg(feature = "output")]
pub use report::Drawing;
pub use states::States;
