//! The meaning of the safety modes for the check of a dump. The answers of planning are not used.

use meliora_dump::manifest::SafetyMode;

/// Returns whether weakening edges are dropped while the other edges of their choice stay.
pub(super) fn drops_edges(mode: SafetyMode) -> bool {
    match mode {
        SafetyMode::Transition => true,
        SafetyMode::Action | SafetyMode::Prefix => false,
    }
}

/// Returns whether steps are compared with a reference class, which has an arena of its own.
pub(super) fn has_reference(mode: SafetyMode) -> bool {
    match mode {
        SafetyMode::Prefix => true,
        SafetyMode::Action | SafetyMode::Transition => false,
    }
}
