//! Partial relations and lists of them, which recursions split together with the sets.

mod chain;
pub(super) mod combinations;
pub(in crate::symbolic) mod lists;
pub(in crate::symbolic) mod partial_relation;
mod step;
pub(in crate::symbolic) mod support;
pub(in crate::symbolic) mod tuples;
