//! The parts that several suites share: random models, and definitions by the book.

pub(crate) mod agreement;
pub(crate) mod brute;
pub(crate) mod coverage;
pub(crate) mod entry;
pub(crate) mod factory;
pub(crate) mod graphs;
pub(crate) mod prelude;
pub(crate) mod random_game;
pub(crate) mod random_program;
pub(crate) mod set_up;
