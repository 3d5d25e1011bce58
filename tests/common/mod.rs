//! The parts that several suites share: random models, definitions by the book, and the amount of cases.

pub(crate) mod agreement;
pub(crate) mod amount;
pub(crate) mod brute;
pub(crate) mod coverage;
pub(crate) mod entry;
pub(crate) mod factory;
pub(crate) mod graphs;
pub(crate) mod prelude;
pub(crate) mod random_game;
pub(crate) mod random_program;
pub(crate) mod set_up;
