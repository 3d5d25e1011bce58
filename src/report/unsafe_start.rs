//! The text for an initial state from which no strategy keeps the requirements.

use std::fmt::Write;

use super::Style;
use meliora_planning::result::{Escape, EscapeStep};

/// Shows how a requirement gets violated from a state; nothing without a path.
pub(super) fn text(escape: Option<&Escape>, style: Style) -> String {
    let Some((escape, start)) = escape.and_then(|escape| Some((escape, &escape.path.first()?.state))) else {
        return String::new();
    };
    let title = format!("No strategy keeps the requirements from {start}");
    let mut out = format!("\n{}\n", style.bad(&title));
    if let Some(violated) = &escape.violated {
        let _ = writeln!(out, "  A shortest path to the violation of `{violated}`; in each state,");
        let _ = writeln!(out, "  every action may lead on to a violation:");
    }
    for EscapeStep { state, action } in &escape.path {
        let action = action.as_ref().map_or("violated".to_owned(), |action| format!("by {action}"));
        let _ = writeln!(out, "    {state}  {action}");
    }
    out
}
