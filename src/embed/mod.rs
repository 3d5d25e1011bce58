//! Owners for those who embed the library: types without lifetimes, which any language can hold.
//!
//! A [`Model`] is read from a text; [`Model::explore`] makes an [`Exploration`] of it by either engine, which
//! answers with sets of states ([`States`]) and takes any number of targets and preferences, none of which
//! explores again; a [`Planning`] is an analysis under preferences, and a [`Strategy`] what to do. Clones are
//! cheap: they share what was computed.

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
