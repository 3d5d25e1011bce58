//! The manifest check: derives the manifest anew from model, preferences and options, and compares.
//!
//! Three fields are free: see [`INFORMATIVE`]. The order of the bits may be any order of the model's
//! bits, if the files have the same.

use serde_json::Value as Json;

use super::Hashes;
use super::condition::Condition;
use super::description;
use super::error::{CheckError, CheckResult};
use super::safety;
use meliora_dump::Manifest;
use meliora_dump::manifest::File;
use meliora_engine::Engine;
use meliora_engine::symbolic::SymbolicEngine;
use meliora_model::Program;
use meliora_model::preference::{Goal, Objective, Preferences};

/// The fields of a manifest that nothing proves: the version of the program that wrote the dump, and the
/// paths of the inputs, which may have been moved since.
pub const INFORMATIVE: &[&str] = &["tool.version", "model.path", "preferences.path"];

/// Compares the hashes of the texts with those of the dump.
pub(super) fn inputs(manifest: &Manifest, hashes: Hashes<'_>) -> CheckResult {
    for (what, now, then) in [
        ("model", hashes.model, &manifest.model.sha256),
        ("preferences", hashes.preferences, &manifest.preferences.sha256),
    ] {
        if now != then {
            let (now, then) = (now.to_owned(), then.clone());
            let condition = Condition::Hash { what, now, then };
            return Err(CheckError::violated(condition, None));
        }
    }
    Ok(())
}

/// Compares the players of a game, and those of them who we are, with those of the dump.
pub(super) fn players(program: &Program, manifest: &Manifest) -> CheckResult {
    let [players, coalition] = description::players(program);
    let condition = if manifest.players != players {
        Condition::Players { expected: players, said: manifest.players.clone() }
    } else if manifest.coalition != coalition {
        Condition::Coalition { expected: coalition, said: manifest.coalition.clone() }
    } else {
        return Ok(());
    };
    Err(CheckError::violated(condition, None))
}

/// Refuses the options and objectives that are not supported for games.
pub(super) fn is_supported(
    engine: &SymbolicEngine,
    preferences: &Preferences,
    manifest: &Manifest,
) -> CheckResult {
    let over_paths = |objective: &Objective| matches!(objective.goal, Goal::Satisfy { .. });
    if !engine.is_game() {
        return Ok(());
    }
    let wrong = if safety::drops_edges(manifest.safety) {
        Condition::NoTransitionSafety
    } else if preferences.objectives.iter().any(over_paths) {
        Condition::NoTemporalObjectives
    } else {
        return Ok(());
    };
    Err(CheckError::violated(wrong, None))
}

/// Compares all fields of the manifest, except its files, with those that model, preferences and
/// options imply.
pub(super) fn all(
    engine: &SymbolicEngine,
    preferences: &Preferences,
    hashes: Hashes<'_>,
    manifest: &Manifest,
) -> CheckResult {
    let expected = description::expected(engine, preferences, hashes, manifest);
    let said = Manifest { regions: File::default(), certificate: None, values: None, ..manifest.clone() };
    let mut said = json(&said)?;
    said["regions"] = Json::Null;
    match difference(&expected, &said, String::new()) {
        None => Ok(()),
        Some((path, expected, said)) => {
            Err(CheckError::violated(Condition::Field { path, expected, said }, None))
        }
    }
}

fn json(manifest: &Manifest) -> CheckResult<Json> {
    let failed =
        |error: serde_json::Error| CheckError::violated(Condition::Json { problem: error.to_string() }, None);
    serde_json::to_value(manifest).map_err(failed)
}

/// Returns the first place in which two values differ, and both values there.
fn difference(expected: &Json, said: &Json, path: String) -> Option<(String, String, String)> {
    match (expected, said) {
        (Json::Object(a), Json::Object(b)) => {
            let prefix = if path.is_empty() { path } else { format!("{path}.") };
            let mut names = a.keys().chain(b.keys().filter(|&name| !a.contains_key(name)));
            names.find_map(|name| match (a.get(name), b.get(name)) {
                (Some(a), Some(b)) => difference(a, b, format!("{prefix}{name}")),
                (a, b) => Some((
                    format!("{prefix}{name}"),
                    a.map_or_else(absent, shown),
                    b.map_or_else(absent, shown),
                )),
            })
        }
        (Json::Array(a), Json::Array(b)) if a.len() == b.len() => {
            let mut pairs = a.iter().zip(b).enumerate();
            pairs.find_map(|(position, (a, b))| difference(a, b, format!("{path}[{position}]")))
        }
        _ if expected == said => None,
        _ => Some((path, shown(expected), shown(said))),
    }
}

fn absent() -> String {
    "absent".to_owned()
}

/// Formats a value for a message, cut after 200 characters.
fn shown(value: &Json) -> String {
    let text = value.to_string();
    match text.char_indices().nth(200) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text,
    }
}
