//! Parts that most programs do not need: the sets and diagrams of each engine, variable orders, and
//! the thresholds of the symbolic engine.
//!
//! Bindings, tests and experiments use them. They change more often than the rest of the library.

/// Sets of an engine that is selected at run time.
pub mod any {
    pub use meliora_engine::any::{AnyChoices, AnyStates};
}

/// Sets of the explicit engine.
pub mod explicit {
    pub use meliora_engine::explicit::{ChoiceSet, Listing, StateSet};
}

/// Sets, bits and choice numbers of the symbolic engine, and its choice of methods.
pub mod symbolic {
    pub use meliora_engine::symbolic::{
        Bit, ChoiceSet, DiagramSizes, Encoding, Listing, Numbered, Set, Side, StateSet, Thresholds, Ways,
        order,
    };
}

/// Files that appear whole or not at all.
pub mod files {
    pub use meliora_base::files::{Installed, NewDirectory, Replacement, folder};
}

/// Names of regions.
pub mod names {
    pub use meliora_model::region::{RegionName, members};
}

/// Policies of planners, read from files and checked.
#[cfg(feature = "output")]
pub mod policies {
    pub use meliora_certify::policy::rules::{PolicyFault, Rules, Visited};
    pub use meliora_report::policy_file::read;
}

/// Comma-separated values.
pub mod csv {
    pub use meliora_base::csv::{Lines, cell, lines, text};
}

/// Escaping of untrusted text: one function for each target.
pub mod escape {
    pub use meliora_base::escape::{dot, first_word, is_shown, line, lines, quoted, unword, word};
}

/// JSON in which every character is displayed.
pub mod json {
    pub use meliora_base::json::{compact, pretty};
}

/// Syntax trees, temporal formulas and properties, before they become part of a program.
pub mod lang {
    pub use meliora_lang::flat::Flat;

    /// The syntax tree of expressions and systems.
    pub mod ast {
        pub use meliora_lang::ast::*;
    }

    /// Temporal formulas and their monitors.
    pub mod ltl {
        pub use meliora_lang::ltl::*;
    }

    /// The syntax tree of preferences.
    pub mod pref {
        pub use meliora_lang::pref::*;
    }

    /// Properties that a model or a command line names.
    pub mod named {
        pub use meliora_lang::named::*;
    }

    /// Qualitative properties.
    pub mod property {
        pub use meliora_lang::property::*;
    }

    /// Files of properties.
    pub mod property_file {
        pub use meliora_lang::property_file::*;
    }
}
