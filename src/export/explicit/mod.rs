//! Models state by state, for programs that read such: PRISM's and Storm's explicit formats.
//!
//! [`explored`] is the model of an analysis, [`induced`] the one that a strategy makes of it; [`prism`]
//! and [`drn`] are their texts. States are numbered from 0 as they are found, the initial ones first.

mod explore;
mod graph;
mod induced;
mod label;
mod write;

pub use explore::explored;
pub use graph::{Column, Graph, Row};
pub use induced::induced;
pub use write::{PrismFiles, action_table, drn, prism};
