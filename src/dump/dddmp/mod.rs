//! DDDMP 2.0 in text mode, in the dialect that both CUDD and Python's `dd` read.
//!
//! The file has `.varinfo 0`, five columns `id varid index then else`, one terminal `1 T 1 0 0`,
//! complemented else arcs as negative numbers, and no `.rootnames` (which `dd` refuses). All
//! variables are listed as support, so that the lists are not empty if all functions are constant.
//! Nodes are numbered level by level from the deepest up. `dd.dddmp.load` numbers them in the same
//! way, so the numbers in the file are valid in the diagram that it returns.

mod lines;
mod read;
mod write;

pub use read::read;
pub use write::write;

/// The last line of a file.
const END: &[u8] = b".end";
/// The line before the nodes.
const NODES: &[u8] = b".nodes";
/// The line of the terminal.
const TERMINAL: &[u8] = b"1 T 1 0 0";
