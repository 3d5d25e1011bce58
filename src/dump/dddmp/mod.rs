//! DDDMP 2.0 in text mode: the dialect that CUDD and Python's `dd` both read.
//!
//! `.varinfo 0`, five columns `id varid index then else`, one terminal `1 T 1 0 0`, complemented
//! else arcs as negative numbers, no `.rootnames` (which `dd` refuses). All variables count as
//! support, so that no list is empty where all functions are constant. Nodes are numbered level by
//! level from the deepest up: `dd.dddmp.load` numbers them the same way, so that the numbers in the
//! file are valid in the diagram that it returns.

mod lines;
mod read;
mod write;

pub use read::read;
pub use write::write;

/// The last line of a file.
const END: &[u8] = b".end";
/// The line before the nodes.
const NODES: &[u8] = b".nodes";
/// The terminal's line.
const TERMINAL: &[u8] = b"1 T 1 0 0";
