//! Names that a model in PRISM's language cannot have: blanks, orders to a terminal or a spreadsheet,
//! quotes, signs of other languages.

use crate::common::prelude::*;

/// Actions as the model has them, and as words of a `.drn`.
const ACTIONS: [(&str, &str); 9] = [
    ("go left", "go%20left"),
    ("x\u{1b}[2J\u{9b}31m", "x%1B%5B2J%C2%9B31m"),
    ("two\nlines", "two%0Alines"),
    ("\u{202e}tfel", "%E2%80%AEtfel"),
    ("=cmd|'/C calc'!A0", "=cmd|'/C%20calc'!A0"),
    ("-go", "-go"),
    ("a,\"b\"}<script>", "a,\"b\"}<script>"),
    ("100%", "100%25"),
    ("back\\slash]", "back\\slash%5D"),
];

/// A model with one choice per action in state 0.
fn drn() -> String {
    let count = ACTIONS.len();
    let mut text = format!("@type: MDP\n@nr_states\n3\n@nr_choices\n{}\n@model\nstate 0 init\n", count + 2);
    for (number, (_, word)) in ACTIONS.iter().enumerate() {
        text += &format!("\taction {word}\n\t\t{} : 1\n", 1 + number % 2);
    }
    text + "state 1 \"at home\"\n\taction stay\n\t\t1 : 1\nstate 2\n\taction stay\n\t\t2 : 1\n"
}

const PREFS: &str = "objective A = F state=1; objective B = F state=2; prefer A > B;";

fn scratch() -> Scratch {
    let jani = r#"{"jani-version": 1, "name": "m", "type": "mdp", "actions": [{"name": "go \u001b[2J\n"}],
        "automata": [{"name": "M\u202e", "locations": [{"name": "\u001b[2J\u202e\n\"a\",<b>"}, {"name": "b"}],
        "initial-locations": ["\u001b[2J\u202e\n\"a\",<b>"], "edges": [{"location": "\u001b[2J\u202e\n\"a\",<b>",
        "action": "go \u001b[2J\n", "destinations": [{"location": "b"}]},
        {"location": "b", "destinations": [{"location": "b"}]}]}],
        "properties": [], "system": {"elements": [{"automaton": "M\u202e"}]}}"#;
    let scratch = Scratch::new(&[("m.drn", &drn()), ("m.pref", PREFS), ("m.jani", jani)]);
    let info = executable().args(["info", &scratch.show("m.jani"), "--json"]).output().unwrap();
    let info: Json = serde_json::from_slice(&info.stdout).unwrap();
    let name = info["model"]["variables"][0]["name"].as_str().unwrap();
    scratch.write("j.pref", format!("objective A = F {name}=1;"));
    scratch
}

/// Returns a name as the program shows it.
fn displayed(name: &str) -> String {
    meliora::advanced::escape::line(name).into_owned()
}

/// Runs a command, and requires that it ends well and writes no order to a terminal.
#[track_caller]
fn harmless(arguments: &[&str]) -> Finished {
    let finished = Finished::of(executable().args(arguments)).expect(0);
    for text in [&finished.stdout, &finished.stderr] {
        let plain = ["1", "2", "32", "1;33", "1;31", "0", "33", "1m\u{1b}[33", "1m\u{1b}[94", "94", "96"];
        let plain =
            plain.iter().fold(text.clone(), |text, code| text.replace(&format!("\u{1b}[{code}m"), ""));
        let order = plain.chars().find(|&c| c != '\n' && !meliora::advanced::escape::is_shown(c));
        assert_eq!(order, None, "{arguments:?}: {plain:?}");
    }
    finished
}

/// Every command shows names of every origin, with and without colours.
#[test]
fn names_from_outside_are_no_orders_to_a_terminal() {
    let scratch = scratch();
    let [dump, page, explicit] = ["dump", "page.html", "explicit"].map(|name| scratch.show(name));
    for (model, prefs) in [("m.drn", "m.pref"), ("m.jani", "j.pref")] {
        let (model, prefs) = (scratch.show(model), scratch.show(prefs));
        let both = [model.as_str(), prefs.as_str()];
        let commands: [&[&str]; 12] = [
            &["check"],
            &["strategy", "--kind", "spi"],
            &["strategy", "--kind", "spi", "--csv", "-"],
            &["strategy", "--kind", "spi", "--dot"],
            &["simulate", "--kind", "spi", "--runs", "10"],
            &["simulate", "--kind", "spi", "--runs", "10", "--csv", "-"],
            &["values"],
            &["values", "--csv", "-"],
            &["export", "--format", "explicit", "--out", &explicit],
            &["export", "--format", "dot", "--out", &dump],
            &["report", "--format", "html", "--out", &page],
            &["report", "--format", "dot"],
        ];
        for command in commands {
            let arguments = [&command[..1], &both, &command[1..]].concat();
            harmless(&arguments);
            harmless(&[&arguments[..], &["--color", "always"]].concat());
            if !["-", "--dot", "dot"].iter().any(|text| command.contains(text)) || command[0] == "export" {
                harmless(&[&arguments[..], &["--json"]].concat());
            }
        }
        harmless(&["verify", &dump, &model, &prefs]);
        for more in [&["--list", "20"][..], &["--csv", "-"], &["--list", "20", "--json"]] {
            let listed = harmless(&[&["query", &dump, "choices"], more].concat()).stdout;
            assert!(listed.contains("go") || listed.contains("\\\\u{1b}"), "{listed}");
        }
        harmless(&["info", &model, "--flat"]);
        harmless(&["reach", &model, "--target", "true"]);
        for file in [&page, &scratch.show("dump/manifest.json")] {
            let text = std::fs::read_to_string(file).unwrap();
            let order = text.chars().find(|&c| c != '\n' && !meliora::advanced::escape::is_shown(c));
            assert_eq!(order, None, "{file}");
        }
        assert!(!std::fs::read_to_string(&page).unwrap().contains("}<script>"));
    }
}

/// The actions of state 0 in the JSON of `strategy`.
fn actions(model: &str, prefs: &str) -> BTreeSet<String> {
    let found = harmless(&["strategy", model, prefs, "--kind", "spi", "--at", "state=0", "--json"]).json();
    let actions = found["states"][0]["actions"].as_array().unwrap();
    actions.iter().map(|action| action["name"].as_str().unwrap().to_owned()).collect()
}

/// A blank made a `.tra` that was refused, a line break one more choice of a `.drn`.
#[test]
fn exported_files_have_the_choices_and_names_of_the_model() {
    let scratch = scratch();
    let [model, prefs] = ["m.drn", "m.pref"].map(|name| scratch.show(name));
    let expected: BTreeSet<String> = ACTIONS.iter().map(|(name, _)| displayed(name)).collect();
    assert_eq!(actions(&model, &prefs), expected);
    let choices = |model: &str| harmless(&["info", model, "--json"]).json()["counts"]["choices"].clone();
    for (format, file) in [("drn", "model.drn"), ("explicit", "model.tra"), ("umb", "model.umb")] {
        let out = scratch.show(format);
        harmless(&["export", &model, &prefs, "--format", format, "--out", &out]);
        let written = format!("{out}/{file}");
        assert_eq!(choices(&written), choices(&model), "{format}");
        assert_eq!(actions(&written, &prefs), expected, "{format}");
    }
}

/// A spreadsheet ran the names of actions, and negative numbers must stay numbers.
#[test]
fn names_are_texts_and_numbers_are_numbers_in_csv() {
    let scratch = scratch();
    let [model, prefs] = ["m.drn", "m.pref"].map(|name| scratch.show(name));
    let text = harmless(&["strategy", &model, &prefs, "--kind", "spi", "--csv", "-"]).stdout;
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let column = reader.headers().unwrap().iter().position(|name| name == "action").unwrap();
    let cells: BTreeSet<String> = reader.records().map(|row| row.unwrap()[column].to_owned()).collect();
    let guard = |name: &str| if name.starts_with(['=', '-']) { format!("'{name}") } else { name.to_owned() };
    let expected: BTreeSet<String> = ACTIONS.iter().map(|(name, _)| guard(&displayed(name))).collect();
    assert_eq!(cells, expected);
    let model = "mdp module m x : [-2..0] init -2; [a] x<0 -> (x'=x+1); [b] x=0 -> true; endmodule";
    let other = Scratch::new(&[("m.prism", model), ("m.pref", "objective A = F x=0;")]);
    let (model, prefs) = (other.show("m.prism"), other.show("m.pref"));
    let rows = harmless(&["strategy", &model, &prefs, "--kind", "spi", "--csv", "-"]).stdout;
    assert!(rows.lines().nth(1).unwrap().starts_with("-2,"), "{rows}");
}
