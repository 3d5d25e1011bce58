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

/// Files that appear whole or not at all.
pub mod files {
    pub use crate::files::{Installed, NewDirectory, Replacement, folder};
}

/// Names of regions.
pub mod names {
    pub use crate::names::{class, members};
}

/// Comma-separated values.
pub mod csv {
    pub use crate::csv::{Lines, lines};
}

/// Escaping of untrusted text for display.
pub mod escape {
    pub use crate::escape::{is_shown, line, lines};
}

/// Syntax trees, temporal formulas and properties, before they become part of a program.
pub mod lang {
    pub use crate::lang::flat::Flat;

    /// The syntax tree of expressions and systems.
    pub mod ast {
        pub use crate::lang::ast::*;
    }

    /// Temporal formulas and their monitors.
    pub mod ltl {
        pub use crate::lang::ltl::*;
    }

    /// The syntax tree of preferences.
    pub mod pref {
        pub use crate::lang::pref::*;
    }

    /// Properties that a model or a command line names.
    pub mod named {
        pub use crate::lang::named::*;
    }

    /// Qualitative properties.
    pub mod property {
        pub use crate::lang::property::*;
    }

    /// Files of properties.
    pub mod property_file {
        pub use crate::lang::property_file::*;
    }
}
