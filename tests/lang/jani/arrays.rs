//! Arrays: a variable per element, and an index as a case distinction.

use super::{around, bounded, load};
use crate::common::prelude::*;

fn array(base: Json) -> Json {
    json!({"kind": "array", "base": base})
}

fn at(array: Json, index: Json) -> Json {
    json!({"op": "aa", "exp": array, "index": index})
}

fn op(name: &str, left: Json, right: Json) -> Json {
    json!({"op": name, "left": left, "right": right})
}

/// An edge with a guard and assignments, each a target with a value.
fn edge(guard: Json, assignments: &[(Json, Json)]) -> Json {
    let all: Vec<Json> = assignments.iter().map(|(to, value)| json!({"ref": to, "value": value})).collect();
    json!({"location": "l", "guard": {"exp": guard}, "destinations": [{"location": "l", "assignments": all}]})
}

/// The model with `x` from 0 to 3, and an array `a`.
fn with_array(ty: Json, initial: Json, edges: Json) -> Json {
    let mut model = around(edges);
    let declared = json!({"name": "a", "type": array(ty), "initial-value": initial});
    model["variables"].as_array_mut().unwrap().push(declared);
    model["features"] = json!(["arrays", "functions"]);
    model
}

fn values(elements: Json) -> Json {
    json!({"op": "av", "elements": elements})
}

/// Returns the names of the variables and the reachable states, which both engines find.
fn reached(model: &Json) -> (Vec<String>, Vec<Vec<i64>>) {
    let program = Arc::new(load(model).unwrap_or_else(|e| panic!("{e}")).program);
    let all = [Storage::Explicit, Storage::Symbolic].map(|storage| {
        let engine = AnyEngine::new(program.clone(), Settings { storage, ..Settings::default() }).unwrap();
        engine.list_states(&engine.all_states(), 99).unwrap()
    });
    assert_eq!(all[0], all[1]);
    (program.variables.iter().map(|v| v.name.clone()).collect(), all[0].clone())
}

/// Returns the message of both engines for a fault in some state.
fn fault(model: &Json) -> String {
    let program = Arc::new(load(model).unwrap_or_else(|e| panic!("{e}")).program);
    let messages = [Storage::Explicit, Storage::Symbolic].map(|storage| {
        match AnyEngine::new(program.clone(), Settings { storage, ..Settings::default() }) {
            Err(Error::Input(all)) => format!("{} {}", all[0].message, all[0].label),
            Err(other) => panic!("{other}"),
            Ok(_) => panic!("no fault"),
        }
    });
    assert_eq!(messages[0], messages[1]);
    messages[0].clone()
}

fn message(model: &Json) -> String {
    let Err(Error::Input(all)) = load(model) else { panic!("no error") };
    all[0].message.clone()
}

#[test]
fn elements_are_read_and_assigned_at_an_index() {
    // x counts up; a[x] becomes a[x] + a[2-x].
    let step = edge(
        op("<", json!("x"), json!(3)),
        &[
            (
                at(json!("a"), json!("x")),
                op("+", at(json!("a"), json!("x")), at(json!("a"), op("-", json!(2), json!("x")))),
            ),
            (json!("x"), op("+", json!("x"), json!(1))),
        ],
    );
    let model = with_array(bounded(0, 9), values(json!([1, 0, 2])), json!([step]));
    let (names, states) = reached(&model);
    assert_eq!(names, ["x", "a_0", "a_1", "a_2"]);
    assert_eq!(states, [[0, 1, 0, 2], [1, 3, 0, 2], [2, 3, 0, 2], [3, 3, 0, 5]]);
}

#[test]
fn an_index_outside_of_the_array_is_an_error_with_a_state() {
    let next = (json!("x"), op("+", json!("x"), json!(1)));
    let reads = edge(op("=", at(json!("a"), json!("x")), json!(0)), std::slice::from_ref(&next));
    let writes = edge(op("<", json!("x"), json!(3)), &[(at(json!("a"), json!("x")), json!(1)), next]);
    for edge in [reads, writes] {
        for (initial, state) in [(json!([0]), "x=1,a_0="), (json!([0, 0]), "x=2,a_0=")] {
            let found = fault(&with_array(bounded(0, 9), values(initial), json!([edge])));
            assert!(found.contains(state) && found.contains("outside of the array"), "{found}");
        }
    }
}

#[test]
fn two_elements_are_exchanged_at_the_same_time_but_one_is_not_assigned_twice() {
    let (first, second) = (at(json!("a"), json!("x")), at(json!("a"), op("-", json!(2), json!("x"))));
    let next = (json!("x"), op("+", json!("x"), json!(1)));
    let swap = |most: i64| {
        let guard = op("<", json!("x"), json!(most));
        edge(guard, &[(first.clone(), second.clone()), (second.clone(), first.clone()), next.clone()])
    };
    let model = |most| with_array(bounded(0, 2), values(json!([0, 1, 2])), json!([swap(most)]));
    assert_eq!(reached(&model(1)).1, [[0, 0, 1, 2], [1, 2, 1, 0]]);
    let found = fault(&model(2));
    assert!(found.contains("x=1,") && found.contains("the same element"), "{found}");
    let twice =
        edge(json!(true), &[(at(json!("a"), json!(1)), json!(0)), (at(json!("a"), json!(1)), json!(1))]);
    let found = message(&with_array(bounded(0, 2), values(json!([0, 1, 2])), json!([twice])));
    assert_eq!(found, "`a` is assigned twice with the index 0");
}

#[test]
fn arrays_nest_are_made_by_a_rule_and_are_arguments_of_functions() {
    // a[i][j] = i < j; a row is assigned as a whole.
    let row = |body: Json| json!({"op": "ac", "var": "j", "length": 2, "exp": body});
    let rule = json!({"op": "ac", "var": "i", "length": 3, "exp": row(op("<", json!("i"), json!("j")))});
    let sure = json!({"op": "call", "function": "some", "args": [at(json!("a"), json!("x"))]});
    let empty = edge(sure, &[(at(json!("a"), json!("x")), row(json!(false)))]);
    let next = edge(op("<", json!("x"), json!(2)), &[(json!("x"), op("+", json!("x"), json!(1)))]);
    let mut model = with_array(array(json!("bool")), rule, json!([empty, next]));
    model["functions"] = json!([{
        "name": "some", "type": "bool", "parameters": [{"name": "r", "type": array(json!("bool"))}],
        "body": op("∨", at(json!("r"), json!(0)), at(json!("r"), json!(1))),
    }]);
    let (names, states) = reached(&model);
    assert_eq!(names, ["x", "a_0_0", "a_0_1", "a_1_0", "a_1_1", "a_2_0", "a_2_1"]);
    let expected = [0, 1, 2].into_iter().flat_map(|x| [0, 1].map(|one| vec![x, 0, one, 0, 0, 0, 0]));
    assert_eq!(states, expected.collect::<Vec<_>>());
}

#[test]
fn what_is_no_array_has_no_elements() {
    let sets = |value: Json| edge(json!(true), &[(json!("x"), value)]);
    let of = |edge: Json| message(&with_array(bounded(0, 2), values(json!([0, 1])), json!([edge])));
    assert_eq!(of(sets(json!("a"))), "type error: the new value of `x` must be no array");
    assert_eq!(
        of(sets(op("+", json!("a"), json!(1)))),
        "an array cannot stand here: a number or a Boolean is needed"
    );
    assert_eq!(of(sets(at(json!("x"), json!(0)))), "only an array has elements");
    assert_eq!(of(sets(at(json!("a"), json!(2)))), "this expression has no value");
    assert_eq!(
        of(edge(json!(true), &[(json!("a"), values(json!([0])))])),
        "type error: the new value of `a` must be an array of the same length"
    );
    let mut model = with_array(bounded(0, 2), values(json!([0, 1])), json!([]));
    model["variables"][1].as_object_mut().unwrap().remove("initial-value");
    assert!(message(&model).contains("which gives its length, is not supported"));
}

/// Edges use a transient array between their assignments; every state has its initial value again.
#[test]
fn the_elements_of_a_transient_array_begin_every_edge_with_their_initial_values() {
    let assigned = |to: Json, value: Json, index: u8| json!({"ref": to, "value": value, "index": index});
    // a = [5, 1]; a[x mod 2] becomes 2; x grows by a[0] - a[1]: by 2 - 1 for even x, and by 5 - 2 for odd ones.
    let here = at(json!("a"), op("%", json!("x"), json!(2)));
    let moved = op("-", at(json!("a"), json!(0)), at(json!("a"), json!(1)));
    let assignments =
        json!([assigned(here, json!(2), 0), assigned(json!("x"), op("+", json!("x"), moved), 1)]);
    let step = json!({"location": "l", "guard": {"exp": op("<", json!("x"), json!(3))},
        "destinations": [{"location": "l", "assignments": assignments}]});
    let model = |ty: Json| {
        let mut model = with_array(ty, values(json!([5, 1])), json!([step]));
        let variables = model["variables"].as_array_mut().unwrap();
        variables.iter_mut().for_each(|v| {
            if v["name"] == "x" {
                v["type"]["upper-bound"] = json!(9);
            } else {
                v["transient"] = json!(true);
            }
        });
        model
    };
    for ty in [bounded(0, 9), json!("int")] {
        let (names, states) = reached(&model(ty));
        assert_eq!((names, states), (vec!["x".to_owned()], vec![vec![0], vec![1], vec![4]]));
    }
    let mut given = model(bounded(0, 9));
    given["automata"][0]["locations"][0]["transient-values"] =
        json!([{"ref": "a", "value": values(json!([1, 1]))}]);
    assert_eq!(message(&given), "values that locations give to transient arrays are not supported");
}
