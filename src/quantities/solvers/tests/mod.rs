//! Differential tests of the solvers.

mod arenas;
mod games;
mod objectives;
mod systems;
