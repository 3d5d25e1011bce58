//! Policies as text, as planners write and read them, and as JSON.

use std::fmt::Write;

use serde::Serialize;

use meliora_base::error::{Error, Result};
use meliora_model::Program;
use meliora_planning::policy::{Policy, PolicyEntry};

use super::policy_names::{equation, name};

/// An entry of a policy in JSON.
#[derive(Serialize)]
struct Entry<'e> {
    /// The facts that hold, or the values of all variables.
    state: Vec<String>,
    action: &'e str,
    /// The position among the choices of the state, if another one has the same name.
    #[serde(skip_serializing_if = "Option::is_none")]
    position: Option<usize>,
    distance: usize,
}

/// Returns a policy as text: for each state the facts that hold, the action, `SC` for strong cyclic, and
/// the distance to the goal.
///
/// # Errors
/// Two facts have one name, so the text could not be read.
pub fn text(policy: &Policy, program: &Program) -> Result<String> {
    let mut out = String::from("Policy:\n");
    for (state, entry) in rules(policy, program)? {
        let position = entry.position.map_or_else(String::new, |position| format!(" / position={position}"));
        let (state, action, distance) = (state.join("/"), name(&entry.action), entry.distance);
        let _ = write!(out, "If holds: {state}\nExecute: {action}{position} / SC / d={distance}\n\n");
    }
    Ok(out)
}

/// Returns a policy as a list in JSON, with the fields `state`, `action` and `distance`, and `position` where two choices
/// have one name.
///
/// # Errors
/// Two facts have one name, so the list could not be read.
pub fn json(policy: &Policy, program: &Program) -> Result<String> {
    let mut entries = Vec::new();
    for (state, PolicyEntry { action, position, distance, .. }) in rules(policy, program)? {
        entries.push(Entry { state, action, position: *position, distance: *distance });
    }
    serde_json::to_string_pretty(&entries).map_err(|error| Error::Usage(error.to_string()))
}

/// Returns the conditions of each state: the facts that hold in a planning problem; in other models, all values. A rule of
/// few facts holds where more facts hold, too, so states with more facts come first.
fn rules<'p>(policy: &'p Policy, program: &Program) -> Result<Vec<(Vec<String>, &'p PolicyEntry)>> {
    let Some(planning) = &program.planning else {
        let all = |entry: &PolicyEntry| {
            program
                .variables
                .iter()
                .zip(&entry.state)
                .map(|(variable, &value)| equation(variable, value))
                .collect()
        };
        return Ok(policy.entries.iter().map(|entry| (all(entry), entry)).collect());
    };
    if let Some(fact) = planning.doubled_fact() {
        let message = format!("two facts are called `{fact}`, so no policy can name them: rename an object");
        return Err(Error::Usage(message));
    }
    let state = |entry: &PolicyEntry| {
        let holds = planning.facts.iter().filter(|f| entry.state[f.variable.index()] == f.value);
        holds.map(|fact| name(&fact.name).into_owned()).collect::<Vec<_>>()
    };
    let mut rules: Vec<_> = policy.entries.iter().map(|entry| (state(entry), entry)).collect();
    rules.sort_by_key(|(state, _)| std::cmp::Reverse(state.len()));
    Ok(rules)
}
