//! Tests of the parts of the engine that it does not show.

mod build;
mod exhaustive;
mod stress;
