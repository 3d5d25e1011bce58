//! Rewards of JANI models: transient numbers.

use meliora::advanced::lang::property::{Measure, Optimum, PropertyKind, Rewards};

use super::{around, load};
use crate::common::prelude::*;

/// A model with a transient real `cost`, around the edges given.
fn costly(edges: Json, initial: f64) -> Json {
    let mut model = around(edges);
    let cost = json!({"name": "cost", "type": "real", "transient": true, "initial-value": initial});
    model["variables"].as_array_mut().unwrap().push(cost);
    model
}

fn sets(x: Json, cost: Json) -> Json {
    json!([{"ref": "x", "value": x}, {"ref": "cost", "value": cost}])
}

fn earned(program: &Program, state: &[i64]) -> Vec<String> {
    let structure = &program.rewards[program.reward_structure(Some("cost")).unwrap()];
    let choices = program.choices(state).unwrap();
    choices.iter().map(|(c, _)| program.reward(structure, state, c).unwrap().to_string()).collect()
}

#[test]
fn steps_earn_the_expected_value_that_their_edges_assign() {
    let edges = json!([
        {"location": "l", "destinations": [
            {"location": "l", "probability": {"exp": 0.25}, "assignments": sets(json!(1), json!(2))},
            {"location": "l", "probability": {"exp": 0.75}, "assignments": sets(json!(2), json!("x"))}]},
        {"location": "l", "destinations": [{"location": "l"}]}
    ]);
    let program = load(&costly(edges, 0.0)).unwrap().program;
    assert_eq!(earned(&program, &[0]), ["1/2", "0"]);
    assert_eq!(earned(&program, &[3]), ["11/4", "0"]);
}

#[test]
fn assignments_of_an_edge_are_made_with_each_destination() {
    let edge = |own: Json, each: Json| {
        let destination = |p: f64, to: i64| {
            let mut all = each.as_array().unwrap().clone();
            all.push(json!({"ref": "x", "value": to}));
            json!({"location": "l", "probability": {"exp": p}, "assignments": all})
        };
        json!([{"location": "l", "assignments": own, "destinations": [destination(0.25, 1), destination(0.75, 2)]}])
    };
    let cost = json!([{"ref": "cost", "value": "x"}]);
    let [shared, same] = [edge(cost.clone(), json!([])), edge(json!([]), cost)];
    let [shared, same] = [shared, same].map(|edges| load(&costly(edges, 0.0)).unwrap().program);
    for x in 0..=3 {
        assert_eq!(earned(&shared, &[x]), [x.to_string()]);
        assert_eq!(shared.steps(&[x]).unwrap(), same.steps(&[x]).unwrap());
    }
    let twice = load(&costly(edge(json!([{"ref": "x", "value": 0}]), json!([])), 0.0));
    let Err(Error::Input(found)) = twice else { panic!("{twice:?}") };
    assert!(found[0].message.contains("assigned"), "{}", found[0].message);
}

#[test]
fn assignments_of_smaller_indices_are_read() {
    let mut assignments = sets(json!(3), json!("x"));
    assignments[1]["index"] = json!(1);
    let edges = json!([{"location": "l", "destinations": [{"location": "l", "assignments": assignments}]}]);
    assert_eq!(earned(&load(&costly(edges, 0.0)).unwrap().program, &[0]), ["3"]);
}

#[test]
fn states_earn_the_values_of_their_locations() {
    let mut model = costly(json!([{"location": "l", "destinations": [{"location": "l"}]}]), 0.0);
    model["automata"][0]["locations"][0]["transient-values"] = json!([{"ref": "cost", "value": "x"}]);
    let program = load(&model).unwrap().program;
    assert_eq!(earned(&program, &[2]), ["2"]);
}

#[test]
fn an_initial_value_that_every_step_would_earn_is_not_supported() {
    let edges = json!([{"location": "l", "destinations": [{"location": "l"}]}]);
    let checked = load(&costly(edges, 1.0)).unwrap();
    assert!(checked.warnings[0].message.contains("initial value other than 0"));
    let program = checked.program;
    let choice = program.choices(&[0]).unwrap().remove(0).0;
    assert!(matches!(program.reward(&program.rewards[0], &[0], &choice), Err(Error::Input(_))));
}

#[test]
fn properties_accumulate_what_they_name() {
    let edges = json!([{"location": "l", "destinations": [
        {"location": "l", "assignments": [{"ref": "cost", "value": 2}]}]}]);
    let mut model = costly(edges, 0.0);
    model["automata"][0]["locations"][0]["transient-values"] = json!([{"ref": "cost", "value": 5}]);
    let asked = |name: &str, exp: Json, accumulate: Json| {
        let target = json!({"op": "=", "left": "x", "right": 3});
        let asked = json!({"op": "Emax", "exp": exp, "accumulate": accumulate, "reach": target});
        json!({"name": name, "expression": {"op": "filter", "fun": "max", "states": {"op": "initial"}, "values": asked}})
    };
    model["properties"] = json!([
        asked("both", json!("cost"), json!(["exit", "steps", "time"])),
        asked("left", json!("cost"), json!(["exit"])),
        asked("taken", json!("cost"), json!(["steps"])),
        asked("number", json!(1), json!(["steps"])),
        asked("sum", json!("x"), json!(["exit"])),
        asked("after", json!("x"), json!(["steps"])),
    ]);
    let checked = load(&model).unwrap();
    let program = &checked.program;
    let choice = program.choices(&[3]).unwrap().remove(0).0;
    let mut earned = Vec::new();
    for property in &checked.properties {
        let Ok(term) = &property.term else {
            earned.push((property.name.as_str(), "no answer".to_owned()));
            continue;
        };
        let question = term.query(program).expect("it is one operator").question;
        let PropertyKind::Quantity(quantity) = &question else { panic!("{question:?}") };
        assert_eq!((quantity.optimum, quantity.bound.clone()), (Optimum::Max, None));
        let Measure::Reward(rewards @ Rewards::Numbered(_)) = &quantity.measure else {
            panic!("{quantity:?}")
        };
        let structure = &program.rewards[rewards.find(program).unwrap()];
        earned.push((&property.name, program.reward(structure, &[3], &choice).unwrap().to_string()));
    }
    let expected =
        [("both", "7"), ("left", "5"), ("taken", "2"), ("number", "1"), ("sum", "3"), ("after", "no answer")];
    assert_eq!(earned, expected.map(|(name, value)| (name, value.to_owned())));
}
