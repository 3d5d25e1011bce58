//! Differential tests of the solvers.

mod arenas;
mod systems;
