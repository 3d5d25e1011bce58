//! Systems in systems, as Storm writes them, against the system of all automata.

use super::{bounded, load};
use crate::common::prelude::*;

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

/// The successors of a state, each with its action.
type Steps = Vec<(String, Vec<i64>)>;

/// The transitions of all states, each choice with its action.
fn transitions(system: Json) -> Vec<(Vec<i64>, Steps)> {
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

/// The files that Storm writes for `(Ax |[go]| Ay) || Az` and other compositions.
#[test]
fn a_system_of_systems_has_the_steps_of_the_system_of_all_automata() {
    let pair = |syncs: Json| json!({"elements": [one("Ax"), one("Ay")], "syncs": syncs});
    let go = || vector(json!(["go", "go"]), json!("go"));
    let own = |place: usize| {
        let mut actions = [json!(null), json!(null), json!(null)];
        actions[place] = json!("own");
        vector(json!(actions), json!("own"))
    };
    let all = |syncs: Vec<Json>| json!({"elements": [one("Ax"), one("Ay"), one("Az")], "syncs": syncs});
    let together = |actions: Json| vector(actions, json!("go"));
    let hidden = json!({"elements": [pair(json!([go()]))], "syncs": [vector(json!(["go"]), json!(""))]});
    for (name, nested, flat) in [
        (
            "`own` is in no vector, and happens alone",
            json!({"elements": [pair(json!([go()])), one("Az")], "syncs": [go()]}),
            all(vec![together(json!(["go", "go", "go"])), own(0), own(1), own(2)]),
        ),
        (
            "either of two",
            json!({"elements": [{"elements": [one("Ax"), one("Ay")]}, one("Az")], "syncs": [go()]}),
            all(vec![
                together(json!(["go", null, "go"])),
                together(json!([null, "go", "go"])),
                own(0),
                own(1),
                own(2),
            ]),
        ),
        (
            "hidden",
            json!({"elements": [hidden, one("Az")]}),
            all(vec![
                vector(json!(["go", "go", null]), json!(null)),
                together(json!([null, null, "go"])),
                own(0),
                own(1),
                own(2),
            ]),
        ),
        (
            "renamed",
            json!({"elements": [pair(json!([vector(json!(["go", "go"]), json!("both"))])), one("Az")],
                "syncs": [vector(json!(["both", "own"]), json!("go"))]}),
            all(vec![
                together(json!(["go", "go", "own"])),
                together(json!([null, null, "go"])),
                own(0),
                own(1),
            ]),
        ),
    ] {
        let found = transitions(nested);
        assert!(found.len() >= 4, "{name}");
        assert_eq!(found, transitions(flat), "{name}");
    }
}

#[test]
fn the_vectors_of_a_system_of_systems_have_a_place_for_each_element() {
    let inner = json!({"elements": [one("Ax"), one("Ay")], "syncs": []});
    let nested = json!({"elements": [inner, one("Az")], "syncs": [vector(json!(["go"]), json!("go"))]});
    let Err(Error::Input(all)) = load(&model(nested)) else { panic!("no error") };
    assert_eq!(all[0].message, "this vector has 1 places, but the system has 2 elements");
}
