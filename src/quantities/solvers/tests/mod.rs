//! Differential tests of the solvers.

mod arenas;
mod objectives;
mod systems;
