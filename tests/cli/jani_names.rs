//! Names of JANI models in everything that is written: they are those of the author, quoted as the target
//! needs it, and read back.

use crate::common::prelude::*;

fn model() -> String {
    let x = json!({"name": "a b", "type": {"kind": "bounded", "base": "int", "lower-bound": 0, "upper-bound": 3}, "initial-value": 0});
    let go = json!({"location": "lo c", "action": "go left", "guard": {"exp": {"op": "<", "left": "a b", "right": 3}},
        "destinations": [{"location": "lo c", "assignments": [
            {"ref": "a b", "value": {"op": "+", "left": "a b", "right": 1}}, {"ref": "my cost", "value": 1}]}]});
    let to =
        |from: &str, to: &str| json!({"location": from, "action": "b", "destinations": [{"location": to}]});
    json!({
        "jani-version": 1, "name": "m", "type": "mdp", "actions": [{"name": "go left"}, {"name": "b"}],
        "variables": [x, {"name": "at goal", "type": "bool", "transient": true, "initial-value": false},
            {"name": "my cost", "type": "real", "transient": true, "initial-value": 0}],
        "automata": [{
            "name": "auto maton", "initial-locations": ["lo c"],
            "locations": [{"name": "lo c", "transient-values":
                [{"ref": "at goal", "value": {"op": "=", "left": "a b", "right": 3}}]}, {"name": "2"}, {"name": "0,\"x\""}],
            "edges": [go, to("lo c", "2"), to("2", "0,\"x\""), to("0,\"x\"", "lo c")]}],
        "system": {"elements": [{"automaton": "auto maton"}]}
    })
    .to_string()
}

fn scratch() -> Scratch {
    Scratch::new(&[("m.jani", &model()), ("m.pref", "objective A = F \"at goal\";")])
}

#[track_caller]
fn run(arguments: &[&str]) -> Finished {
    Finished::of(executable().args(arguments)).expect(0)
}

fn rows(text: &str) -> Vec<Vec<String>> {
    let mut reader = csv::ReaderBuilder::new().from_reader(text.as_bytes());
    reader.records().map(|row| row.unwrap().iter().map(str::to_owned).collect()).collect()
}

/// `a b` became `a_b` in labels and actions of every file.
#[test]
fn exported_models_have_the_names_of_the_author() {
    let scratch = scratch();
    let [model, prefs] = ["m.jani", "m.pref"].map(|name| scratch.show(name));
    for (format, file) in [("drn", "model.drn"), ("explicit", "model.tra"), ("umb", "model.umb")] {
        let out = scratch.show(format);
        run(&["export", &model, &prefs, "--format", format, "--out", &out]);
        let written = scratch.show(&format!("{format}/{file}"));
        let reached = run(&["reach", &written, "--target", "\"at goal\"", "--json"]).json();
        assert_eq!(
            (&reached["target"], &reached["counts"]["states"]),
            (&json!("1"), &json!("12")),
            "{format}"
        );
        let own = scratch.show("own.pref");
        std::fs::write(&own, "objective A = F \"at goal\";").unwrap();
        let found = run(&["strategy", &written, &own, "--kind", "spi", "--json"]).json();
        let actions = found["states"][0]["actions"].as_array().unwrap();
        assert!(actions.iter().any(|action| action["name"] == "go left"), "{format}: {found}");
        if format != "explicit" {
            let asked = ["reach", &written, "--property", "R{\"my cost\"}min=? [ F \"at goal\" ]", "--json"];
            let value = run(&asked).json()["properties"][0]["value"].clone();
            let [lower, upper] = ["lower", "upper"].map(|side| value[side].as_f64().unwrap());
            assert!(lower <= 3.0 && 3.0 <= upper && upper - lower < 1e-6, "{format}: {value}");
        }
    }
}

/// Named values had quotes of JSON in cells, and actions were escaped as in `.tra` files.
#[test]
fn cells_have_names_as_they_are_and_states_are_read_back() {
    let scratch = scratch();
    let [model, prefs, dump] = ["m.jani", "m.pref", "dump"].map(|name| scratch.show(name));
    run(&["export", &model, &prefs, "--out", &dump]);
    let listed = rows(&run(&["query", &dump, "choices", "--csv", "-"]).stdout);
    assert!(listed.contains(&["0", "lo c", "go left | b"].map(str::to_owned).to_vec()), "{listed:?}");
    assert!(listed.contains(&["0", "0,\"x\"", "b"].map(str::to_owned).to_vec()), "{listed:?}");
    for command in [&["strategy", "--all"][..], &["simulate", "--runs", "2"]] {
        let more = [&command[1..], &["--kind", "spi", "--csv", "-"]].concat();
        let written = run(&[&[command[0], &model, &prefs], &more[..]].concat()).stdout;
        let cells: Vec<String> = rows(&written).into_iter().flatten().collect();
        assert!(cells.iter().any(|cell| cell == "lo c"), "{command:?}: {written}");
        assert!(!cells.iter().any(|cell| cell.starts_with('"')), "{command:?}: {written}");
    }
    let states = run(&["query", &dump, "reachable", "--list", "20"]).stdout;
    assert!(
        states.contains("a_b=1,auto_maton_loc=\"2\"") && states.contains("auto_maton_loc=\"0,\"\"x\"\"\""),
        "{states}"
    );
    for state in states.lines() {
        let found = run(&["query", &dump, "reachable", "--contains", state]).stdout;
        assert_eq!(found, format!("{state}: yes\n"));
        let found = run(&["strategy", &model, &prefs, "--kind", "spi", "--at", state, "--json"]).json();
        let [x, location] = ["a_b", "auto_maton_loc"].map(|name| &found["states"][0]["state"][name]);
        let name = location.as_str().unwrap();
        let name =
            if name == "lo c" { name.to_owned() } else { format!("\"{}\"", name.replace('"', "\"\"")) };
        assert_eq!(format!("a_b={x},auto_maton_loc={name}"), state);
    }
}

#[test]
fn the_number_of_a_value_is_not_taken_for_its_name() {
    let scratch = scratch();
    let at = |state: &str| scratch.run(format!("strategy m.jani m.pref --kind spi --at '{state}' --json"));
    let found = at("auto_maton_loc=2").expect(0).json();
    assert_eq!(found["states"][0]["state"]["auto_maton_loc"], Json::from("2"));
    let refused = at("auto_maton_loc=1").expect(3).json();
    assert!(refused["message"].as_str().unwrap().contains("`auto_maton_loc` has no value `1`"), "{refused}");
}

/// Commas in names got a blank after them, as those between the values of a state did.
#[test]
fn graphs_of_strategies_keep_commas_in_names() {
    let scratch = scratch();
    let [model, prefs] = ["m.jani", "m.pref"].map(|name| scratch.show(name));
    run(&["strategy", &model, &prefs, "--kind", "achieve", "--objective", "A", "--dot"])
        .shows(r#"a_b=0, auto_maton_loc=\"0,\"\"x\"\"\"\n"#);
}
