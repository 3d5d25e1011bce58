//! A JANI model with most of the format, compared with its PRISM version under both engines.

use crate::common::prelude::*;

/// The model that comes with the program.
fn workshop() -> &'static str {
    include_str!("../../models/workshop.jani")
}

const TWIN: &str = "mdp
const int N;
module left
  l : [0..1]; p : [0..N];
  [] l=0 & p<N -> 1/4: true + 3/4: (l'=1) & (p'=p+1);
  [] l=1 -> (l'=0);
  [press] l=0 & p>0 -> (p'=p-1);
  [give] l=0 & p>0 -> (p'=p-1);
endmodule
module right = left [l=m, p=q, give=never] endmodule
module press
  made : [0..2]; broken : bool;
  [press] !broken -> 0.9: (made'=min(2,made+1)) + 0.1: (broken'=true);
  [never] false -> true;
endmodule";

const PREFERENCES: &str = include_str!("../../models/workshop.pref");

fn answer(arguments: &[&str]) -> Json {
    Finished::of(executable().args(arguments).args(["--json", "--const", "N=2"])).expect(0).json()
}

#[test]
fn a_document_is_the_same_model_as_its_text_in_the_modelling_language() {
    let document = format!("\u{feff}{}", workshop());
    let scratch = Scratch::new(&[("m", &document), ("twin.prism", TWIN)]);
    for engine in ["symbolic", "explicit"] {
        let ask = |model: &str, target: &str| {
            let mut found = answer(&["reach", &scratch.show(model), "--target", target, "--engine", engine]);
            let kept = ["counts", "pmax_one", "pmax_positive", "pmin_one", "pmin_positive"];
            kept.map(|key| found[key].take())
        };
        for target in ["made=2", "broken", "made=1 & !broken"] {
            assert_eq!(ask("m", target), ask("twin.prism", target), "{target} {engine}");
        }
        assert_eq!(ask("m", "\"all made\""), ask("twin.prism", "made=2"), "{engine}");
        assert_ne!(ask("m", "made=2")[1], json!("0"));
    }
}

#[test]
fn a_dump_is_verified_and_asked_by_the_names_of_locations() {
    let scratch = Scratch::new(&[("m.jani", workshop()), ("m.pref", PREFERENCES)]);
    let (model, prefs, out) = (scratch.show("m.jani"), scratch.show("m.pref"), scratch.show("dump"));
    answer(&["export", &model, &prefs, "--out", &out]);
    scratch.run("verify dump m.jani m.pref").expect(0);
    let state = "made=1,broken=false,left_loc=busy,left_parts=1,right_loc=idle,right_parts=0";
    let asked = scratch.run(format!("query dump positive:All --contains '{state}' --json"));
    assert_eq!(asked.expect(0).json()["contains"][0]["state"]["left_loc"], "busy");
}

#[test]
fn properties_are_asked_by_their_names() {
    let scratch = Scratch::new(&[("m.jani", workshop())]);
    let model = scratch.show("m.jani");
    let regions = answer(&["reach", &model, "--property", "all made"]);
    let value = &regions["properties"][0]["value"];
    assert!(
        value["lower"].as_f64() <= value["upper"].as_f64() && value["upper"].as_f64() <= Some(1.0),
        "{value}"
    );
    assert_eq!(regions["pmax_one"], answer(&["reach", &model, "--target", "made=2"])["pmax_one"]);
    let surely = ["reach", &model, "--const", "N=2", "--property", "surely", "--json"];
    assert_eq!(Finished::of(executable().args(surely)).json()["holds"], false);
    let time = ["reach", &model, "--const", "N=2", "--property", "time"];
    Finished::of(executable().args(time)).ends(3, "expected value");
}

#[test]
fn a_model_is_read_from_standard_input_too() {
    let mut command = executable();
    command.args(["info", "-", "--json", "--const", "N=1"]);
    let found = Finished::reading(&mut command, workshop()).expect(0).json();
    let scratch = Scratch::new(&[("m.jani", workshop())]);
    let file = scratch.run("info m.jani --json --const N=1");
    assert_eq!(found["counts"], file.expect(0).json()["counts"]);
}

/// Formulas on paths in both languages.
fn formulas() -> Vec<(Json, &'static str)> {
    let made = |n: u8| json!({"op": "=", "left": "made", "right": n});
    let one = |op: &str, exp: Json| json!({"op": op, "exp": exp});
    let two = |op: &str, left: Json, right: Json| json!({"op": op, "left": left, "right": right});
    let within = |mut formula: Json, bounds: Json| {
        formula["step-bounds"] = bounds;
        formula
    };
    let intact = || one("¬", json!("broken"));
    let eventually = || one("F", made(2));
    let until = || two("U", intact(), made(1));
    vec![
        (until(), "!broken U made=1"),
        (within(until(), json!({"upper": 6})), "!broken U<=6 made=1"),
        (
            within(until(), json!({"lower": 2, "upper": {"op": "*", "left": "N", "right": 4}})),
            "!broken U[2,8] made=1",
        ),
        (within(eventually(), json!({"lower": 3, "lower-exclusive": true})), "F>3 made=2"),
        (within(two("U", json!(true), made(2)), json!({"upper": 9, "upper-exclusive": true})), "F<9 made=2"),
        (one("G", intact()), "G !broken"),
        (within(one("G", intact()), json!({"upper": 5})), "G<=5 !broken"),
        (one("X", made(1)), "X made=1"),
        (two("W", made(0), json!("broken")), "made=0 W broken"),
        (two("R", json!("broken"), made(0)), "broken R made=0"),
        (two("∧", one("F", made(1)), one("G", intact())), "(F made=1) & (G !broken)"),
        (two("∨", made(2), one("X", json!("broken"))), "made=2 | (X broken)"),
        (two("⇒", one("F", json!("broken")), one("F", made(1))), "(F broken) => (F made=1)"),
        (one("¬", two("U", made(0), two("∧", made(1), intact()))), "!(made=0 U (made=1 & !broken))"),
        (one("F", one("G", two("∨", json!("broken"), made(2)))), "F (G (broken | made=2))"),
        (one("G", one("F", made(1))), "G (F made=1)"),
    ]
}

/// Returns the model with properties that ask for the maximal probability of formulas.
fn asking(formulas: impl Iterator<Item = Json>) -> Scratch {
    let mut model: Json = serde_json::from_str(workshop()).unwrap();
    let asked = |(n, formula)| json!({"name": format!("p{n}"), "expression": {"op": "Pmax", "exp": formula}});
    model["properties"] = formulas.enumerate().map(asked).collect();
    Scratch::new(&[("m.jani", &model.to_string())])
}

#[test]
fn properties_may_have_any_formula_on_paths() {
    let formulas = formulas();
    let scratch = asking(formulas.iter().map(|(formula, _)| formula.clone()));
    let model = scratch.show("m.jani");
    for engine in ["symbolic", "explicit"] {
        for (n, (_, text)) in formulas.iter().enumerate() {
            let ask = |property: &str| {
                let mut found = answer(&["reach", &model, "--engine", engine, "--property", property]);
                let kept = ["properties", "pmax_one", "pmax_positive", "pmin_one", "pmin_positive"];
                found["properties"][0]["property"].take();
                kept.map(|key| found[key].take())
            };
            let by_name = ask(&format!("p{n}"));
            assert_eq!(by_name, ask(&format!("Pmax=? [ {text} ]")), "{text} {engine}");
            assert!(by_name[0][0]["value"]["lower"].is_number(), "{text}: {by_name:?}");
        }
    }
}

#[test]
fn formulas_that_are_not_supported_are_refused_by_name() {
    let eventually = |key: &str, bounds: Json| json!({"op": "F", "exp": "broken", key: bounds});
    let nested = json!({"op": "F", "exp": {"op": "Pmax", "exp": eventually("comment", json!(""))}});
    let weak = json!({"op": "W", "left": true, "right": "broken", "step-bounds": {"upper": 1}});
    let long = (0..1001).fold(json!("broken"), |inner, _| json!({"op": "X", "exp": inner}));
    let cases = [
        (eventually("reward-bounds", json!([])), "it has reward-bounds"),
        (eventually("time-bounds", json!({"upper": 1})), "it has time-bounds"),
        (weak, "it has \"W\" with step-bounds"),
        (nested, "expected a condition"),
        (long, "its formula has more than 1000 operators"),
        (
            eventually("step-bounds", json!({"upper": {"op": "-", "left": 0, "right": 1}})),
            "cannot be negative",
        ),
        (
            eventually("step-bounds", json!({"lower": 2, "upper": 1})),
            "no number of steps is within these bounds",
        ),
    ];
    let scratch = asking(cases.iter().map(|(formula, _)| formula.clone()));
    for (n, (_, reason)) in cases.iter().enumerate() {
        let property = format!("p{n}");
        scratch.run(format!("reach m.jani --const N=2 --property '{property}'")).ends(3, reason);
    }
}

#[test]
fn a_model_that_names_properties_lists_them_and_answers_all() {
    let model = ["reach", "models/workshop.jani"];
    let missing = Finished::of(executable().args(model).args(["-c", "N=2"])).expect(2).stderr;
    for word in ["`all made`", "`surely`", "`time`", "`--all-properties`"] {
        assert!(missing.contains(word), "{word}: {missing}");
    }
    let all =
        Finished::of(executable().args(model).args(["-c", "N=2", "--all-properties", "--json"])).expect(1);
    let all = all.json();
    let entries = all["properties"].as_array().unwrap();
    assert_eq!((entries.len(), &entries[2]["property"]), (3, &json!("time")));
    assert!(entries[2]["reason"].as_str().unwrap().contains("without accumulating"), "{}", entries[2]);
    for entry in &entries[..2] {
        let name = entry["property"].as_str().unwrap();
        let one = ["-c", "N=2", "--json", "--property", name];
        let one = Finished::of(executable().args(model).args(one)).json();
        for field in ["holds", "value"] {
            assert_eq!(one["properties"][0].get(field), entry.get(field), "{name}");
        }
    }
    let swept = ["-c", "N=1:2", "--all-properties", "--csv", "-"];
    let rows = Finished::of(executable().args(model).args(swept)).expect(1).stdout;
    assert!(rows.lines().next().unwrap().contains(",all made,surely,time,"), "{rows}");
    assert!(
        rows.lines().skip(1).all(|row| row.contains(",false,not answered,") && row.ends_with(",done")),
        "{rows}"
    );
}
