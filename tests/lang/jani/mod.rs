//! JANI models: their meaning, and the error messages for documents that are not models.

mod arrays;
mod corners;
mod errors;
mod names;
mod random;
mod rewards;
mod systems;
mod write;

use crate::common::prelude::*;

/// A model of one automaton `m` with one location, of an `x` from 0 to 3, around the edges given.
pub(crate) fn around(edges: Json) -> Json {
    json!({
        "jani-version": 1, "name": "m", "type": "mdp", "actions": [{"name": "go"}],
        "variables": [{"name": "x", "type": bounded(0, 3), "initial-value": 0}],
        "automata": [{"name": "m", "locations": [{"name": "l"}], "initial-locations": ["l"], "edges": edges}],
        "system": {"elements": [{"automaton": "m"}]}
    })
}

pub(crate) fn bounded(low: i64, high: i64) -> Json {
    json!({"kind": "bounded", "base": "int", "lower-bound": low, "upper-bound": high})
}

/// An edge from `l` that assigns an expression to `x`.
pub(crate) fn sets_x(value: Json) -> Json {
    json!({"location": "l", "destinations": [{"location": "l", "assignments": [{"ref": "x", "value": value}]}]})
}

pub(crate) fn load(document: &Json) -> Result<Checked, meliora::error::Error> {
    load_text(&serde_json::to_string_pretty(document).unwrap(), "")
}

pub(crate) fn load_text(text: &str, constants: &str) -> Result<Checked, meliora::error::Error> {
    lang::load(&SourceFile::new("m.jani", text), &SourceFile::new("--const", constants))
}
