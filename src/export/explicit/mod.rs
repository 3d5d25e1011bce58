//! Models with an explicit list of states, in the explicit formats of PRISM and Storm,
//! and in UMB.
//!
//! [`explored`] lists the model of an analysis, [`induced`] the model that a strategy induces;
//! [`chain()`] that of the nodes of a policy; [`prism`] and [`drn`] write them as text, [`umb()`] as an archive. States are numbered from 0 as they are found, the
//! initial ones first.

mod chain;
mod exact;
mod explore;
mod graph;
mod induced;
mod label;
mod quantities;
mod umb;
mod write;

pub use chain::{chain, program_text, state_rewards};
pub use explore::explored;
pub use graph::{Graph, Players, Row};
pub use induced::induced;
pub use quantities::{Quantities, Quantity};
pub use umb::{umb, umb_of_chain};
pub use write::action_table;
pub use write::{drn, prism, refuse_drn};
