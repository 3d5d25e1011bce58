//! Policies as text, as planners write and read them, and as JSON.

use std::fmt::Write;

use serde::Serialize;

use meliora_model::Program;
use meliora_planning::policy::{Policy, PolicyEntry};

/// An entry of a policy in JSON.
#[derive(Serialize)]
struct Entry<'e> {
    /// The facts that hold, or the values of all variables.
    state: Vec<String>,
    action: &'e str,
    distance: usize,
}

/// Returns a policy as text: for each state the facts that hold, the action, `SC` for strong cyclic, and
/// the distance to the goal.
pub fn text(policy: &Policy, program: &Program) -> String {
    let mut out = String::from("Policy:\n");
    for entry in &policy.entries {
        let state = state(program, entry).join("/");
        let _ = write!(out, "If holds: {state}\nExecute: {} / SC / d={}\n\n", entry.action, entry.distance);
    }
    out
}

/// Returns a policy as a list in JSON, with the fields `state`, `action` and `distance`.
///
/// # Errors
/// A name cannot be written, which does not happen.
pub fn json(policy: &Policy, program: &Program) -> serde_json::Result<String> {
    let entry =
        |entry| Entry { state: state(program, entry), action: &entry.action, distance: entry.distance };
    serde_json::to_string_pretty(&policy.entries.iter().map(entry).collect::<Vec<_>>())
}

/// Lists the facts that hold in a state of a planning problem; in other models, all values.
fn state(program: &Program, entry: &PolicyEntry) -> Vec<String> {
    match &program.planning {
        Some(planning) => {
            let holds = planning.facts.iter().filter(|f| entry.state[f.variable.index()] == f.value);
            holds.map(|fact| fact.name.clone()).collect()
        }
        None => {
            let values = program.variables.iter().zip(&entry.state);
            values.map(|(variable, &value)| variable.equation(value)).collect()
        }
    }
}
