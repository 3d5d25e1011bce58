//! Names that PRISM's language does not have: they are kept, except for those of constants and variables,
//! whose replacements are told at their places.

use meliora::lang::flat;

use super::{bounded, load_text};
use crate::common::prelude::*;

fn model() -> Json {
    let go = json!({"location": "lo c", "action": "go left", "guard": {"exp": {"op": "<", "left": "a b", "right": "k k"}},
        "destinations": [{"location": "lo c", "assignments": [
            {"ref": "a b", "value": {"op": "+", "left": "a b", "right": 1}}, {"ref": "my cost", "value": 1}]}]});
    let at_goal = json!([{"ref": "at goal", "value": {"op": "=", "left": "a b", "right": "k k"}}]);
    json!({
        "jani-version": 1, "name": "m", "type": "mdp", "actions": [{"name": "go left"}, {"name": "go_left"}],
        "constants": [{"name": "k k", "type": "int", "value": 3}],
        "variables": [
            {"name": "a b", "type": bounded(0, 3), "initial-value": 0},
            {"name": "a_b", "type": bounded(0, 3), "initial-value": 2},
            {"name": "at goal", "type": "bool", "transient": true, "initial-value": false},
            {"name": "my cost", "type": "real", "transient": true, "initial-value": 0}],
        "automata": [{
            "name": "auto maton", "initial-locations": ["lo c"],
            "locations": [{"name": "lo c", "transient-values": at_goal}, {"name": "1"}],
            "edges": [go, {"location": "lo c", "action": "go_left", "destinations": [{"location": "1"}]}]}],
        "properties": [{"name": "my prop", "expression": {"op": "filter", "fun": "max", "states": {"op": "initial"},
            "values": {"op": "Pmax", "exp": {"op": "F", "exp": {"op": "=", "left": "a b", "right": 3}}}}}],
        "system": {"elements": [{"automaton": "auto maton"}]}
    })
}

#[test]
fn names_of_actions_automata_labels_and_rewards_are_those_of_the_author() {
    let program = load_text(&model().to_string(), "").unwrap().program;
    assert_eq!(program.actions, ["go left", "go_left"]);
    assert_eq!(program.modules, ["auto maton"]);
    assert_eq!(program.rewards[0].name.as_deref(), Some("my cost"));
    assert!(program.labels.iter().map(|label| label.0.as_str()).eq(["my prop", "at goal"]));
}

/// All warnings pointed to the beginning of the file, also for names that were kept.
#[test]
fn only_constants_and_variables_are_renamed_and_the_warning_is_at_their_place() {
    let text = serde_json::to_string_pretty(&model()).unwrap();
    let checked = load_text(&text, "").unwrap();
    let names: Vec<&str> = checked.program.variables.iter().map(|v| v.name.as_str()).collect();
    // `a_b` was called `a_b_2`, because `a b` comes first.
    assert_eq!(names, ["a_b_2", "a_b", "auto_maton_loc"]);
    let told: Vec<_> = checked.warnings.iter().map(|w| (w.message.as_str(), &text[w.span.clone()])).collect();
    let reason = "it is not a name in PRISM's language";
    let [constant, variable] = [("k k", "k_k"), ("a b", "a_b_2")]
        .map(|(old, new)| format!("`{old}` is renamed to `{new}`: {reason}"));
    assert_eq!(told, [(constant.as_str(), "\"k k\""), (variable.as_str(), "\"a b\"")]);
}

#[test]
fn a_name_that_is_not_displayed_is_told_at_its_place() {
    let text = model().to_string().replace("go left", "go\\u202eleft");
    let checked = load_text(&text, "").unwrap();
    assert_eq!(checked.program.actions[0], "go\\u{202e}left");
    let told = checked.warnings.iter().find(|w| w.message.contains("not displayed")).unwrap();
    assert_eq!(&text[told.span.clone()], "\"go\\u202eleft\"");
}

#[test]
fn a_property_with_the_name_of_a_built_in_label_is_told_at_its_place() {
    let text = model().to_string().replace("my prop", "deadlock");
    let checked = load_text(&text, "").unwrap();
    assert!(checked.program.labels.iter().map(|label| label.0.as_str()).eq(["at goal"]));
    let told = checked.warnings.iter().find(|w| w.message.contains("meaning of its own")).unwrap();
    assert_eq!(&text[told.span.clone()], "\"deadlock\"");
}

#[test]
fn flat_programs_have_identifiers_and_the_same_choices() {
    let program = load_text(&model().to_string(), "").unwrap().program;
    let again = load_text(&flat(&program).unwrap(), "").unwrap().program;
    assert_eq!(again.modules, ["auto_maton"]);
    // The order of the variables differs: those that no command writes are global.
    let successors = |program: &Program| -> Vec<_> {
        let value = |v: &Variable| if v.name == "a_b" { 2 } else { 0 };
        let state: Vec<i64> = program.variables.iter().map(value).collect();
        let named = |state: &State| -> BTreeMap<String, i64> {
            program.variables.iter().map(|v| v.name.clone()).zip(state.iter().copied()).collect()
        };
        let steps = program.steps(&state).unwrap().into_iter();
        steps
            .map(|step| step.successors.iter().map(|(state, p)| (named(state), *p)).collect::<Vec<_>>())
            .collect()
    };
    assert_eq!(successors(&again).len(), 2);
    assert_eq!(successors(&again), successors(&program));
}
