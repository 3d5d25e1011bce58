//! Differential tests of the solvers.

mod arenas;
mod bounded;
mod games;
mod if_reached;
mod objectives;
mod sides;
mod systems;
