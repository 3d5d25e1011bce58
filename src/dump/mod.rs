//! Dumps: sets of states in files that other programs can read.
//!
//! A dump is a directory. `regions.dddmp` contains every region as a root of one shared diagram, in
//! DDDMP 2.0 text. `certificate.dddmp` contains the sets that a check without fixpoints needs.
//! `values.csv`, if there is one, contains bounds of quantities ([`values`]).
//! `manifest.json` describes the roots and the encoding of states as bits ([`Manifest`]).
//!
//! [`Diagram`] is the representation in memory: nodes as plain data with complemented else arcs, as
//! in CUDD and in Python's `dd`. Dumps are read, checked and written without an engine.

pub mod dddmp;
pub mod directory;
pub mod dot;
pub mod manifest;
pub(crate) mod place;
mod streams;
pub mod values;

pub use crate::model::diagram::{Diagram, Edge, Node};
pub use crate::model::members::Members;
pub use directory::{Dump, read_directory, write_directory};
pub use manifest::Manifest;
