//! Systems in systems, as Storm writes them, against the system of all automata.

use std::sync::Arc;

use meliora::engine::{AnyEngine, Engine, Settings, Storage};
use meliora::error::Error;
use serde_json::{Value as Json, json};

use super::{bounded, load};

/// An automaton that counts its own variable up to 2 by `go`, and has a silent edge back from 2 and one `own` edge.
fn automaton(name: &str) -> Json {
    let edge = |action: Option<&str>, guard: Json, value: Json| {
        let mut edge = json!({"location": "l", "guard": {"exp": guard},
            "destinations": [{"location": "l", "assignments": [{"ref": name, "value": value}]}]});
        if let Some(action) = action {
            edge["action"] = json!(action);
        }
        edge
    };
    let is = |x: u8| json!({"op": "=", "left": name, "right": x});
    let below = json!({"op": "<", "left": name, "right": 2});
    json!({"name": format!("A{name}"), "locations": [{"name": "l"}], "initial-locations": ["l"], "edges": [
        edge(Some("go"), below, json!({"op": "+", "left": name, "right": 1})),
        edge(None, is(2), json!(3)),
        edge(Some("own"), is(3), json!(0)),
    ]})
}

fn model(system: Json) -> Json {
    let variable = |name: &str| json!({"name": name, "type": bounded(0, 3), "initial-value": 0});
    let (variables, automata) = (["x", "y", "z"].map(variable), ["x", "y", "z"].map(automaton));
    json!({
        "jani-version": 1, "name": "m", "type": "mdp",
        "actions": [{"name": "go"}, {"name": "own"}, {"name": "both"}],
        "variables": variables, "automata": automata, "system": system
    })
}

/// The transitions of all states, each choice with its action.
fn transitions(system: Json) -> Vec<(Vec<i64>, Vec<(String, Vec<i64>)>)> {
    let program = Arc::new(load(&model(system)).unwrap_or_else(|e| panic!("{e}")).program);
    let engine =
        AnyEngine::new(program.clone(), Settings { storage: Storage::Explicit, ..Settings::default() })
            .unwrap();
    let steps = |state: &Vec<i64>| {
        let mut all = Vec::new();
        for step in program.steps(state).unwrap() {
            let name = step.name.split(['(', '#']).next().unwrap().to_owned();
            all.extend(step.successors.into_iter().map(|(to, _)| (name.clone(), to)));
        }
        all.sort();
        all
    };
    let states = engine.list_states(&engine.all_states(), 100).unwrap();
    states.iter().map(|state| (state.clone(), steps(state))).collect()
}

fn one(name: &str) -> Json {
    json!({"automaton": name})
}

fn vector(actions: Json, result: Json) -> Json {
    json!({"synchronise": actions, "result": result})
}

#[test]
fn a_system_of_systems_has_the_steps_of_the_system_of_all_automata() {
    // x and y go together, as `both`; each takes `own` alone, silently. Outside, `both` and the `go` of z are one step.
    let inner = json!({"elements": [one("Ax"), one("Ay")], "syncs": [
        vector(json!(["go", "go"]), json!("both")),
        vector(json!(["own", null]), json!(null)),
        vector(json!([null, "own"]), json!("own")),
    ]});
    let alone = json!({"elements": [one("Az")]});
    for (z, name) in [(one("Az"), "an automaton"), (alone, "a system of one")] {
        let nested = json!({"elements": [inner, z], "syncs": [
            vector(json!(["both", "go"]), json!("go")),
            vector(json!(["own", null]), json!("own")),
            vector(json!([null, "own"]), json!("own")),
        ]});
        let flat = json!({"elements": [one("Ax"), one("Ay"), one("Az")], "syncs": [
            vector(json!(["go", "go", "go"]), json!("go")),
            vector(json!(["own", null, null]), json!(null)),
            vector(json!([null, "own", null]), json!("own")),
            vector(json!([null, null, "own"]), json!("own")),
        ]});
        let found = transitions(nested);
        assert!(found.len() > 20);
        assert_eq!(found, transitions(flat), "{name}");
    }
    let whole = json!({"elements": [{"elements": [one("Ax")]}]});
    assert_eq!(transitions(whole), transitions(json!({"elements": [one("Ax")]})));
}

#[test]
fn the_vectors_of_a_system_of_systems_have_a_place_for_each_element() {
    let inner = json!({"elements": [one("Ax"), one("Ay")], "syncs": []});
    let nested = json!({"elements": [inner, one("Az")], "syncs": [vector(json!(["go"]), json!("go"))]});
    let Err(Error::Input(all)) = load(&model(nested)) else { panic!("no error") };
    assert_eq!(all[0].message, "this vector has 1 places, but the system has 2 elements");
}
