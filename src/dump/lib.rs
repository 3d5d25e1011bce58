//! The format of dumps: sets of states in files that other programs can read. Dumps are read,
//! checked and written without an engine.
//!
//! - [`Dump`]: the manifest and the diagrams in memory.
//! - [`Manifest`]: the roots, and the encoding of states as bits.
//! - [`Diagram`]: nodes as plain data with complemented else arcs, as in CUDD and in Python's `dd`.
//!
//! A dump is a directory. `regions.dddmp` contains every region as a root of one shared diagram, in
//! DDDMP 2.0 text. `certificate.dddmp` contains the sets that a check without fixpoints needs.
//! `values.csv`, if there is one, contains bounds of quantities ([`bounds`]).
//! `manifest.json` describes the roots and the encoding of states as bits ([`Manifest`]).
//!
//! [`Diagram`] is the representation in memory: nodes as plain data with complemented else arcs, as
//! in CUDD and in Python's `dd`. Dumps are read, checked and written without an engine.
//!
//! # An example
//!
//! ```
//! use meliora_dump::{Diagram, Edge, dddmp};
//!
//! let mut diagram = Diagram { variables: vec!["x".into(), "y".into()], ..Diagram::default() };
//! let y = diagram.push(1, Edge::TRUE, Edge::FALSE)?;
//! let both = diagram.push(0, y, Edge::FALSE)?;
//! diagram.roots.push(both);
//! let mut text = Vec::new();
//! dddmp::write(&diagram, &mut text).unwrap();
//! assert_eq!(dddmp::read("both.dddmp", &text[..])?, diagram);
//! # Ok::<(), meliora_base::error::Error>(())
//! ```

pub mod bounds;
pub mod dddmp;
pub mod directory;
pub mod dot;
pub mod manifest;
mod manifest_check;
pub mod place;
mod streams;

pub use directory::{Dump, read_directory, write_directory};
pub use manifest::Manifest;
pub use meliora_base::diagram::{Diagram, Edge, Node};
pub use meliora_base::members::Members;
