//! Properties of JANI models: filters, and properties that cannot be read.

use crate::common::prelude::*;

fn unary(op: &str, exp: &Json) -> Json {
    json!({"op": op, "exp": exp})
}

fn binary(op: &str, left: &Json, right: &Json) -> Json {
    json!({"op": op, "left": left, "right": right})
}

fn filter(fun: &str, values: &Json, states: &Json) -> Json {
    json!({"op": "filter", "fun": fun, "values": values, "states": states})
}

fn initial() -> Json {
    json!({"op": "initial"})
}

/// The probability of reaching x=2, which is 1/2 from x=0, 0 from x=1, and 1 from x=2.
fn reaches(op: &str) -> Json {
    unary(op, &unary("F", &binary("=", &json!("x"), &json!(2))))
}

/// A walk from x=0 to x=1 or x=2. Without `from`, all three states are initial.
fn model(from: Option<u8>, properties: &[(&str, Json)]) -> Json {
    let mut x =
        json!({"name": "x", "type": {"kind": "bounded", "base": "int", "lower-bound": 0, "upper-bound": 2}});
    if let Some(from) = from {
        x["initial-value"] = json!(from);
    }
    let to = |value: u8| json!({"location": "l", "probability": {"exp": 0.5}, "assignments": [{"ref": "x", "value": value}]});
    let guard = |op: &str| json!({"exp": binary(op, &json!("x"), &json!(0))});
    let named = |(name, expression): &(&str, Json)| json!({"name": name, "expression": expression});
    json!({
        "jani-version": 1, "name": "walk", "type": "mdp", "features": ["derived-operators"],
        "variables": [x, {"name": "late", "type": "real", "transient": true, "initial-value": 2}],
        "properties": properties.iter().map(named).collect::<Vec<_>>(),
        "automata": [{"name": "m", "locations": [{"name": "l"}], "initial-locations": ["l"], "edges": [
            {"location": "l", "guard": guard("="), "destinations": [to(1), to(2)]},
            {"location": "l", "guard": guard(">"), "destinations": [{"location": "l"}]}]}],
        "system": {"elements": [{"automaton": "m"}]}
    })
}

/// Answers all properties of a model.
fn all(model: &Json, status: i32) -> Vec<Json> {
    let scratch = Scratch::new(&[("m.jani", &model.to_string())]);
    let found = scratch.run("reach m.jani --all-properties --json");
    found.expect(status).json()["properties"].as_array().unwrap().clone()
}

fn reason(property: &Json) -> &str {
    assert!(property.get("value").is_none() && property["holds"].is_null(), "{property}");
    property["reason"].as_str().unwrap_or_else(|| panic!("{property}"))
}

/// Checks verdicts, values and words of reasons.
fn expect(found: &[Json], expected: &[(&str, Json)]) {
    assert_eq!(found.len(), expected.len());
    for (property, (name, expected)) in found.iter().zip(expected) {
        match expected {
            Json::Bool(_) => assert_eq!(property["holds"], *expected, "{name}: {property}"),
            Json::String(words) if words == "inf" => assert_eq!(property["value"]["lower"], "inf", "{name}"),
            Json::String(words) => assert!(reason(property).contains(words), "{name}: {property}"),
            number => {
                let [lower, upper] =
                    ["lower", "upper"].map(|side| property["value"][side].as_f64().unwrap_or(f64::NAN));
                let value = number.as_f64().unwrap();
                assert!(lower <= value && value <= upper && upper - lower < 1e-5, "{name}: {property}");
            }
        }
    }
}

/// Answers properties of the walk, and checks what `expect` says.
fn answered(from: Option<u8>, status: i32) -> impl Fn(&[(&str, Json, Json)]) {
    move |all_of| {
        let properties: Vec<(&str, Json)> =
            all_of.iter().map(|(name, asked, _)| (*name, asked.clone())).collect();
        let expected: Vec<(&str, Json)> =
            all_of.iter().map(|(name, _, value)| (*name, value.clone())).collect();
        expect(&all(&model(from, &properties), status), &expected);
    }
}

#[test]
fn a_filter_over_other_states_than_the_initial_ones_is_about_these() {
    let sure = binary("≥", &reaches("Pmin"), &json!(1));
    let somewhere = binary("=", &json!("x"), &json!(1));
    answered(Some(0), 1)(&[
        // It holds in x=2, and was answered for x=0.
        ("there is one", filter("∃", &sure, &json!(true)), json!(true)),
        // The value is 0, that in x=0 is 1/2.
        ("from one", filter("max", &reaches("Pmax"), &somewhere), json!(0)),
        ("least", filter("min", &reaches("Pmax"), &json!(true)), json!(0)),
        ("sum", filter("sum", &reaches("Pmax"), &json!(true)), json!(1.5)),
        ("how many", filter("count", &sure, &json!(true)), json!(1)),
        ("where", filter("argmax", &reaches("Pmax"), &initial()), json!(true)),
        ("not there", filter("argmax", &reaches("Pmax"), &json!(true)), json!(false)),
        ("twice", filter("∀", &filter("∀", &sure, &initial()), &initial()), json!(false)),
        ("where it is sure", filter("∀", &sure, &sure), json!(true)),
        ("of numbers", filter("∀", &reaches("Pmax"), &initial()), json!("expected a condition")),
        ("of verdicts", filter("max", &sure, &initial()), json!("expected a number")),
        ("misspelt", filter("exists", &sure, &initial()), json!("unknown function \"exists\" of a filter")),
    ]);
}

#[test]
fn filters_over_initial_states_have_the_values_of_their_functions() {
    let possible = binary(">", &reaches("Pmax"), &json!(0));
    let properties = |values: [Json; 7]| {
        let fun = ["∀", "∃", "count", "min", "max", "sum", "avg"].into_iter();
        let asked = |fun: &'static str| match fun {
            "∀" | "∃" | "count" => filter(fun, &possible, &initial()),
            _ => filter(fun, &reaches("Pmax"), &initial()),
        };
        fun.zip(values).map(|(fun, value)| (fun, asked(fun), value)).collect::<Vec<_>>()
    };
    let half = json!(0.5);
    let one = [json!(true), json!(true), json!(1), half.clone(), half.clone(), half.clone(), half.clone()];
    answered(Some(0), 0)(&properties(one));
    // From x=1, x=2 is not reached: of all three initial states, the property holds in two.
    let three = [json!(false), json!(true), json!(2), json!(0), json!(1), json!(1.5), half];
    answered(None, 1)(&properties(three));
    let list = all(&model(None, &[("list", filter("values", &reaches("Pmax"), &initial()))]), 0);
    assert_eq!(list[0]["values"].as_array().map(Vec::len), Some(3), "{list:?}");
}

#[test]
fn properties_nest_compute_and_are_joined() {
    let sure = binary("≥", &reaches("Pmin"), &json!(1));
    let likely = binary(">", &reaches("Pmin"), &json!(0.4));
    let steps = |more: &Json| {
        let mut all =
            json!({"op": "Emax", "exp": binary("+", &json!("x"), &json!(1)), "accumulate": ["exit"]});
        all.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        all
    };
    answered(Some(0), 1)(&[
        ("nested", unary("Pmax", &unary("G", &likely)), json!(0.5)),
        ("below X", unary("Pmax", &unary("X", &sure)), json!(0.5)),
        ("of a label", unary("Pmax", &unary("F", &json!({"op": "deadlock"}))), json!(0)),
        ("of starts", unary("Pmax", &unary("X", &unary("¬", &initial()))), json!(1)),
        ("every path", unary("∀", &unary("F", &binary("=", &json!("x"), &json!(2)))), json!(false)),
        ("some path", unary("∃", &unary("F", &binary("=", &json!("x"), &json!(2)))), json!(true)),
        ("equal", binary("=", &reaches("Pmax"), &json!(0.5)), json!(true)),
        ("unequal", binary("≠", &json!(0.5), &reaches("Pmax")), json!(false)),
        ("two", binary("≤", &reaches("Pmin"), &reaches("Pmax")), json!(true)),
        ("both", binary("∧", &sure, &likely), json!(false)),
        ("either", binary("∨", &sure, &likely), json!(true)),
        ("implied", binary("⇒", &json!(true), &sure), json!(false)),
        ("rest", binary("≥", &binary("-", &json!(1), &reaches("Pmax")), &json!(0.5)), json!(true)),
        ("number", binary("+", &reaches("Pmax"), &json!(1)), json!(1.5)),
        ("negated filter", unary("¬", &filter("∀", &sure, &initial())), json!(true)),
        ("steps", steps(&json!({"step-instant": 2})), json!(3.5)),
        ("until", steps(&json!({"reach": sure})), json!("inf")),
        (
            "not accumulated",
            json!({"op": "Emax", "exp": "x", "reach": sure}),
            json!("without accumulating it"),
        ),
        ("in the first state", unary("Pmax", &binary("=", &json!("x"), &json!(0))), json!(1)),
        ("at a step", json!({"op": "Emax", "exp": "x", "step-instant": 1}), json!(1.5)),
        ("not a condition", unary("¬", &reaches("Pmax")), json!("expected a condition")),
        ("no property", binary("≥", &json!("x"), &json!(1)), json!("does not ask for a probability")),
        ("long run", unary("Smax", &binary("=", &json!("x"), &json!(2))), json!(0.5)),
        ("path", unary("F", &json!(true)), json!("the operator \"F\" cannot stand here")),
    ]);
}

#[test]
fn a_property_that_cannot_be_read_leaves_the_model_and_the_other_properties() {
    let unknown = unary("Pmax", &unary("F", &json!("nowhere")));
    let step = json!({"op": "Emax", "exp": "late", "accumulate": ["steps"], "reach": true});
    let moment = json!({"op": "Emax", "exp": "late", "accumulate": ["stpes"], "reach": true});
    let mut forgotten = reaches("Pmax");
    forgotten["exp"]["step-bound"] = json!({"upper": 3});
    let mut key = filter("max", &reaches("Pmax"), &initial());
    key["state"] = json!(true);
    let mut bound = binary("≥", &reaches("Pmax"), &json!(1));
    bound["strict"] = json!(true);
    let mut found = model(
        Some(0),
        &[
            ("unknown", unknown),
            ("reward of steps", step),
            ("moment", moment),
            ("key of a formula", forgotten),
            ("key of a filter", key),
            ("key of a comparison", bound),
            ("twice", reaches("Pmax")),
            ("twice", reaches("Pmin")),
            ("plain", reaches("Pmax")),
        ],
    );
    found["properties"].as_array_mut().unwrap().push(json!({"expression": reaches("Pmax")}));
    let words = [
        "unknown name `nowhere`",
        "the reward `late` has an initial value other than 0",
        "unknown moment \"stpes\"",
        "unknown key \"step-bound\"",
        "unknown key \"state\" in a filter",
        "unknown key \"strict\"",
        "several properties have the name \"twice\"",
        "several properties have the name \"twice\"",
    ];
    let answers = all(&found, 0);
    for (answer, words) in answers.iter().zip(words) {
        assert!(reason(answer).contains(words), "{words}: {answer}");
    }
    assert!(answers[0]["line"] == json!(1) && answers[0]["column"].is_number(), "{}", answers[0]);
    assert!(answers[8]["value"]["lower"].is_number(), "{}", answers[8]);
    assert_eq!(answers[9]["property"], json!("properties[9]"));
    assert!(reason(&answers[9]).contains("a property has no \"name\""), "{}", answers[9]);
    let prefs = "objective A = F \"plain\"; objective B = F x=1; prefer A > B;";
    let scratch = Scratch::new(&[("m.jani", &found.to_string()), ("m.pref", prefs)]);
    scratch.run("info m.jani").expect(0);
    scratch.run("check m.jani m.pref").expect(0);
    scratch
        .run("reach m.jani --property unknown")
        .ends(3, "the property \"unknown\" of the model cannot be answered: unknown name");
}

#[test]
fn the_target_of_a_property_is_a_label_whatever_its_filter_asks() {
    let goal = filter("max", &reaches("Pmax"), &json!(true));
    let mut walk = model(Some(0), &[("goal", goal.clone())]);
    let target = |walk: &Json| {
        let scratch = Scratch::new(&[("m.jani", &walk.to_string())]);
        scratch.run("reach m.jani --target \"goal\" --json")
    };
    assert_eq!(target(&walk).expect(0).json()["target"], json!("1"));
    // A variable of this name that means another set: neither is the label.
    let variable = json!({"name": "goal", "type": "bool", "transient": true, "initial-value": false});
    walk["variables"].as_array_mut().unwrap().push(variable);
    let given = json!([{"ref": "goal", "value": binary("=", &json!("x"), &json!(1))}]);
    walk["automata"][0]["locations"][0]["transient-values"] = given;
    let found = target(&walk).expect(3).stderr;
    assert!(found.contains("\"goal\" is not a label of the model: a property and this variable"), "{found}");
    assert!(found.contains("unknown label \"goal\""), "{found}");
}

#[test]
fn the_bound_of_a_property_may_be_an_expression() {
    let half = json!({"op": "/", "left": 1, "right": 2});
    let more = json!({"op": "+", "left": half, "right": 1e-9});
    let found = all(
        &model(
            Some(0),
            &[
                ("equal", binary("≥", &reaches("Pmax"), &half)),
                ("above", binary("≥", &reaches("Pmax"), &more)),
                ("variable", binary("≥", &reaches("Pmax"), &json!("x"))),
                ("infinite", binary("≤", &reaches("Pmax"), &json!({"op": "/", "left": 1, "right": 0}))),
                ("verdict", binary("≤", &reaches("Pmax"), &json!(true))),
            ],
        ),
        1,
    );
    assert_eq!((&found[0]["holds"], &found[1]["holds"]), (&json!(true), &json!(false)));
    // As in a part of a property, it may depend on the state.
    assert_eq!(found[2]["holds"], true);
    reason(&found[3]);
    assert!(reason(&found[4]).contains("a number"), "{}", found[4]);
}

#[test]
fn a_property_with_the_name_of_a_label_of_all_models_is_not_taken_for_it() {
    // `F "init"` is about the initial states, whatever a property of this name asks.
    let walk = model(Some(0), &[("init", reaches("Pmax")), ("deadlock", reaches("Pmax"))]);
    let found = all(&walk, 0);
    assert!(found.iter().all(|p| p["value"]["lower"].as_f64() > Some(0.4)), "{found:?}");
    let scratch = Scratch::new(&[("m.jani", &walk.to_string())]);
    scratch.run("info m.jani").ends(0, "\"init\" is not a label of the model").says("\"deadlock\" is not");
}

/// `0.5 ≤ Pmax` was said to ask for no probability.
#[test]
fn comparisons_may_stand_in_either_order_and_be_negated() {
    let value = |op: &str, number: f64| binary(op, &reaches("Pmax"), &json!(number));
    let mirrored = |op: &str, number: f64| binary(op, &json!(number), &reaches("Pmax"));
    // The probability is 1/2.
    let all_of = [
        ("a", mirrored("≤", 0.5), true),
        ("b", mirrored("<", 0.5), false),
        ("c", mirrored("≥", 0.5), true),
        ("d", mirrored(">", 0.5), false),
        ("e", mirrored(">", 0.75), true),
        ("f", mirrored("≤", 0.75), false),
        ("g", unary("¬", &value("≥", 0.5)), false),
        ("h", unary("¬", &value(">", 0.5)), true),
        ("i", unary("¬", &value("≤", 0.25)), true),
        ("j", unary("¬", &value("<", 0.5)), true),
        ("k", unary("¬", &unary("¬", &mirrored("<", 0.25))), true),
        ("l", filter("∀", &unary("¬", &mirrored("≥", 0.25)), &initial()), true),
    ];
    let properties: Vec<(&str, Json)> =
        all_of.iter().map(|(name, asked, _)| (*name, asked.clone())).collect();
    let found = all(&model(Some(0), &properties), 1);
    for ((name, _, holds), property) in all_of.iter().zip(&found) {
        assert_eq!(property["holds"], json!(holds), "{name}: {property}");
    }
}

/// If `reach` is a formula on paths, rewards are accumulated until it is satisfied.
#[test]
fn rewards_until_a_formula_are_not_those_until_a_set() {
    let until = |target: &Json| json!({"op": "Emax", "exp": "late", "accumulate": ["exit"], "reach": target});
    let left = binary("≥", &json!("x"), &json!(1));
    let mut soon = unary("F", &left);
    soon["step-bounds"] = json!({"upper": 0});
    answered(Some(0), 0)(&[
        ("set", until(&left), json!(2)),
        ("formula", until(&unary("F", &left)), json!(2)),
        ("next", until(&unary("X", &left)), json!(2)),
        ("too late", until(&soon), json!("inf")),
        ("always", until(&unary("G", &left)), json!("no finite part of a path satisfies this one")),
        ("compared", unary("¬", &binary("<", &until(&unary("X", &left)), &json!(2))), json!(true)),
    ]);
}
