//! Special cases of the format, one per test: the meaning of the documents, state by state.

use super::{around, bounded, load, sets_x};
use crate::common::prelude::*;

/// The successors of a state with their probabilities, choice by choice.
fn successors(program: &Program, state: &[i64]) -> Vec<Vec<(State, f64)>> {
    program.steps(state).unwrap().into_iter().map(|s| s.successors).collect()
}

/// Returns the only successor of a state by its only choice.
fn next(program: &Program, state: &[i64]) -> State {
    let all = successors(program, state);
    assert_eq!((all.len(), all[0].len()), (1, 1), "{all:?}");
    all[0][0].0.clone()
}

fn assignment(variable: &str, value: Json, index: i64) -> Json {
    json!({"ref": variable, "value": value, "index": index})
}

/// Two automata `a` and `b`, each with one edge for `go`, that move together.
fn pair(variables: Json, a: Json, b: Json) -> Json {
    let automaton = |name: &str, assignments: Json| {
        json!({"name": name, "locations": [{"name": "l"}], "initial-locations": ["l"], "edges": [
            {"location": "l", "action": "go", "destinations": [{"location": "l", "assignments": assignments}]}]})
    };
    json!({
        "jani-version": 1, "name": "m", "type": "mdp", "actions": [{"name": "go"}], "variables": variables,
        "automata": [automaton("a", a), automaton("b", b)],
        "system": {"elements": [{"automaton": "a"}, {"automaton": "b"}],
                   "syncs": [{"synchronise": ["go", "go"], "result": "go"}]}
    })
}

#[test]
fn assignments_of_one_index_read_the_state_before_and_those_of_the_next_what_they_gave() {
    let swap = json!([
        assignment("x", json!("y"), 0),
        assignment("y", json!("x"), 0),
        assignment("z", json!({"op": "+", "left": "x", "right": "y"}), 1)
    ]);
    let mut document =
        around(json!([{"location": "l", "destinations": [{"location": "l", "assignments": swap}]}]));
    for name in ["y", "z"] {
        let variable = json!({"name": name, "type": bounded(0, 6), "initial-value": 0});
        document["variables"].as_array_mut().unwrap().push(variable);
    }
    let program = load(&document).unwrap().program;
    assert_eq!(next(&program, &[1, 2, 0]), [2, 1, 3]);
}

#[test]
fn indices_order_the_assignments_of_edges_that_move_together() {
    let variables = json!([{"name": "x", "type": bounded(0, 3), "initial-value": 0},
                           {"name": "y", "type": bounded(0, 3), "initial-value": 0}]);
    // b reads what a has assigned with a smaller index, whichever of them stands first.
    let one = pair(
        variables.clone(),
        json!([assignment("x", json!(2), 0)]),
        json!([assignment("y", json!("x"), 1)]),
    );
    assert_eq!(next(&load(&one).unwrap().program, &[0, 0]), [2, 2]);
    let other = pair(
        variables.clone(),
        json!([assignment("y", json!("x"), 1)]),
        json!([assignment("x", json!(2), 0)]),
    );
    assert_eq!(next(&load(&other).unwrap().program, &[0, 0]), [2, 2]);
    // The same variable, one after the other.
    let both = pair(
        variables,
        json!([assignment("x", json!({"op": "+", "left": "x", "right": 1}), 1)]),
        json!([assignment("x", json!({"op": "*", "left": "x", "right": 2}), 0)]),
    );
    let program = load(&both).unwrap().program;
    assert_eq!(next(&program, &[1, 0]), [3, 0]);
    assert_eq!(program.steps(&[1, 0]).unwrap()[0].name, "go");
}

#[test]
fn a_transient_variable_carries_a_value_from_one_assignment_to_the_next() {
    let steps = json!([
        assignment("t", json!({"op": "+", "left": "x", "right": 1}), 0),
        assignment("x", json!({"op": "min", "left": "t", "right": 3}), 1)
    ]);
    let mut document =
        around(json!([{"location": "l", "destinations": [{"location": "l", "assignments": steps}]}]));
    let transient = json!({"name": "t", "type": "int", "transient": true, "initial-value": 0});
    document["variables"].as_array_mut().unwrap().push(transient);
    let program = load(&document).unwrap().program;
    assert_eq!(next(&program, &[1]), [2]);
    assert_eq!(next(&program, &[3]), [3]);
}

#[test]
fn a_transient_boolean_has_the_value_of_its_location() {
    let document = json!({
        "jani-version": 1, "name": "m", "type": "mdp",
        "variables": [{"name": "busy", "type": "bool", "transient": true, "initial-value": false},
                      {"name": "x", "type": bounded(0, 1), "initial-value": 0}],
        "automata": [{"name": "m", "initial-locations": ["rest"],
            "locations": [{"name": "rest"},
                {"name": "work", "transient-values": [{"ref": "busy", "value": {"op": "=", "left": "x", "right": 1}}]}],
            "edges": [{"location": "rest", "guard": {"exp": {"op": "¬", "exp": "busy"}},
                       "destinations": [{"location": "work", "assignments": [{"ref": "x", "value": 1}]}]},
                      {"location": "work", "guard": {"exp": "busy"}, "destinations": [{"location": "rest"}]}]}],
        "system": {"elements": [{"automaton": "m"}]}
    });
    let program = load(&document).unwrap().program;
    assert_eq!(program.show_state(&[0, 1]), "x=0,m_loc=work");
    assert_eq!(next(&program, &[0, 0]), [1, 1]);
    assert_eq!(next(&program, &[1, 1]), [1, 0]);
    assert_eq!(next(&program, &[0, 1]), [0, 1], "a deadlock: it is not busy there");
    let busy = program.labels.iter().find(|(name, _)| name == "busy").unwrap().1;
    let holds = |state: &[i64]| program.pool.eval(busy, state).unwrap().to_f64();
    assert_eq!([[0, 0], [1, 0], [0, 1], [1, 1]].map(|s| holds(&s)), [0.0, 0.0, 0.0, 1.0]);
}

#[test]
fn operators_that_the_modelling_language_lacks_are_put_in_its_words() {
    let value = |e: Json| {
        let program = load(&around(json!([sets_x(e)]))).unwrap().program;
        (0..=3).map(|x| next(&program, &[x])[0]).collect::<Vec<_>>()
    };
    let less = |left: Json, right: Json| json!({"op": "-", "left": left, "right": right});
    let one = |op: &str, exp: Json| json!({"op": op, "exp": exp});
    assert_eq!(value(one("abs", less(json!("x"), json!(2)))), [2, 1, 0, 1]);
    let sign = json!({"op": "+", "left": 1, "right": one("sgn", less(json!("x"), json!(1)))});
    assert_eq!(value(sign), [0, 1, 2, 2]);
    let half = json!({"op": "/", "left": less(json!("x"), json!(3)), "right": 2});
    let cut = json!({"op": "+", "left": 1, "right": one("trc", half)});
    assert_eq!(value(cut), [0, 0, 1, 1]);
    let modulo = json!({"op": "%", "left": "x", "right": 2});
    assert_eq!(value(modulo), [0, 1, 0, 1]);
    let angle =
        json!({"op": "floor", "exp": {"op": "min", "left": {"constant": "π"}, "right": {"constant": "e"}}});
    assert_eq!(value(angle), [2; 4]);
}

#[test]
fn functions_are_put_in_with_their_arguments() {
    let mut document = around(json!([sets_x(json!({"op": "call", "function": "twice", "args": ["x"]}))]));
    let call = json!({"op": "call", "function": "top", "args": []});
    let body = json!({"op": "min", "left": {"op": "+", "left": "v", "right": "v"}, "right": call});
    document["functions"] = json!([
        {"name": "twice", "type": "int", "parameters": [{"name": "v", "type": "int"}], "body": body},
        {"name": "top", "type": "int", "parameters": [], "body": 3}]);
    let program = load(&document).unwrap().program;
    assert_eq!((0..=3).map(|x| next(&program, &[x])[0]).collect::<Vec<_>>(), [0, 2, 3, 3]);
}

#[test]
fn variables_without_a_value_take_every_one_that_the_restriction_lets_through() {
    let mut document = around(json!([]));
    document["variables"][0].as_object_mut().unwrap().remove("initial-value");
    document["restrict-initial"] = json!({"exp": {"op": "≠", "left": "x", "right": 1}});
    let program = load(&document).unwrap().program;
    let initial = |x| program.pool.eval(program.initial, &[x]).unwrap().to_f64() > 0.5;
    assert_eq!([0, 1, 2, 3].map(initial), [true, false, true, true]);
}

#[test]
fn one_automaton_stands_in_the_system_as_often_as_it_is_named() {
    let mut document = around(json!([]));
    document["automata"][0]["variables"] = json!([{"name": "own", "type": "bool", "initial-value": true}]);
    document["system"]["elements"] = json!([{"automaton": "m"}, {"automaton": "m"}]);
    let program = load(&document).unwrap().program;
    assert_eq!(program.modules, ["m", "m_2"]);
    assert_eq!(program.show_state(&[0, 1, 1]), "x=0,m_own=true,m_2_own=true");
}

#[test]
fn actions_that_no_vector_has_never_happen_unless_there_are_no_vectors() {
    let mut edge = sets_x(json!(1));
    edge["action"] = json!("go");
    let mut document = around(json!([edge]));
    let free = load(&document).unwrap();
    assert_eq!(next(&free.program, &[0]), [1]);
    assert!(free.warnings.is_empty());
    document["system"]["syncs"] = json!([]);
    let bound = load(&document).unwrap();
    assert_eq!(next(&bound.program, &[0]), [0]);
    assert!(bound.warnings[0].message.contains("occurs in no synchronisation vector"));
}

#[test]
fn integers_without_bounds_take_those_that_are_given() {
    use meliora::lang::{Given, load_given};
    let mut document = around(json!([sets_x(json!(5))]));
    document["variables"][0]["type"] = json!("int");
    let source = SourceFile::new("m.jani", document.to_string());
    let given = |bounds: &str| Given {
        constants: SourceFile::new("--const", ""),
        bounds: SourceFile::new("--bounds", bounds),
    };
    let sink = meliora::progress::NoProgress;
    let program = load_given(&source, &given("x=-1..7"), &sink).unwrap().program;
    assert_eq!((program.variables[0].low, program.variables[0].high), (-1, 7));
    for wrong in ["", "y=0..1", "x=0..7,y=0..1", "x", "x=1..0"] {
        assert!(load_given(&source, &given(wrong), &sink).is_err(), "{wrong}");
    }
}

#[test]
fn names_that_the_modelling_language_does_not_know_are_changed_and_told() {
    let mut document = around(json!([]));
    document["variables"][0]["name"] = json!("a.b");
    let checked = load(&document).unwrap();
    assert_eq!(checked.program.variables[0].name, "a_b");
    assert!(checked.warnings[0].message.contains("`a.b` is renamed to `a_b`"));
}

#[test]
fn automata_that_write_one_variable_together_with_others_are_one_module_of_the_modelling_language() {
    use meliora::lang;
    let x = json!([{"name": "x", "type": bounded(0, 3), "initial-value": 0}]);
    let more = json!({"op": "min", "left": 3, "right": {"op": "+", "left": "x", "right": 1}});
    // For `go` a writes, and for `back` b.
    let mut document = pair(x, json!([assignment("x", more, 0)]), json!([]));
    document["actions"] = json!([{"name": "go"}, {"name": "back"}]);
    let edge = |assignments: Json| json!({"location": "l", "action": "back", "destinations": [{"location": "l", "assignments": assignments}]});
    document["automata"][0]["edges"].as_array_mut().unwrap().push(edge(json!([])));
    document["automata"][1]["edges"].as_array_mut().unwrap().push(edge(json!([assignment(
        "x",
        json!(0),
        0
    )])));
    let vector = json!({"synchronise": ["back", "back"], "result": "back"});
    document["system"]["syncs"].as_array_mut().unwrap().push(vector);
    let program = load(&document).unwrap().program;
    let text = lang::flat(&program).unwrap();
    let again = parsed(&*text);
    assert_eq!(again.modules, ["a_b"], "{text}");
    for x in 0..=3 {
        assert_eq!(successors(&again, &[x]), successors(&program, &[x]), "{text}");
    }
}
