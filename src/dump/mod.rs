//! Dumps: sets of states as files that other programs read.
//!
//! A dump is a directory. `regions.dddmp` holds every region as a root of one shared diagram in
//! DDDMP 2.0 text, `certificate.dddmp` the sets that a check without fixpoints needs, and
//! `manifest.json` says what the roots are and how states are bits ([`Manifest`]).
//!
//! [`Diagram`] is the form in between: nodes as plain data with complemented else arcs, the form
//! that CUDD and Python's `dd` use. No engine is needed to read, check or write one.

pub mod dddmp;
pub mod diagram;
pub mod directory;
pub mod dot;
pub mod manifest;
mod members;
mod place;
mod streams;

pub use diagram::{Diagram, Edge, Node};
pub use directory::{Dump, read_directory, write_directory};
pub use manifest::Manifest;
pub use members::Members;
