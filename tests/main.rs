//! The tests that cross crates, in one program, so that the library and its dependencies are linked once.
//!
//! `cargo test --test all cli::` runs one suite.

mod cli;
mod common;
mod dumps;
mod engines;
mod games;
mod lang;
mod planning;
