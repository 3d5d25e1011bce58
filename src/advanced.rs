//! Parts that most programs do not need: the sets and diagrams of each engine, variable orders, and
//! the thresholds of the symbolic engine.
//!
//! Bindings, tests and experiments use them. They change more often than the rest of the library.

/// Sets of an engine that is selected at run time.
pub mod any {
    pub use crate::engine::any::{AnyChoices, AnyStates};
}

/// Sets of the explicit engine.
pub mod explicit {
    pub use crate::engine::explicit::{ChoiceSet, Listing, StateSet};
}

/// Sets, bits and choice numbers of the symbolic engine, and its choice of methods.
pub mod symbolic {
    pub use crate::engine::symbolic::{
        Bit, ChoiceSet, DiagramSizes, Encoding, Listing, Numbered, Set, StateSet, Thresholds, Ways, order,
    };
}

/// Names of regions.
pub mod names {
    pub use crate::names::{class, members};
}

/// Comma-separated values.
pub mod csv {
    pub use crate::csv::lines;
}

/// Escaping of untrusted text for display.
pub mod escape {
    pub use crate::escape::{is_shown, line, lines};
}
