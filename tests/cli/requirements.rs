//! `reach --require`: questions about the strategies that keep requirements.

use crate::common::prelude::*;

/// `quick` reaches the goal surely, but may step onto ice first; `safe` succeeds half of the time.
const MODEL: &str = "mdp\nmodule m\n x : [0..6] init START;\n\
     [quick] x=0 -> 1/2: (x'=1) + 1/2: (x'=4);\n [safe] x=0 -> 1/2: (x'=4) + 1/2: (x'=5);\n\
     [on] x=1 -> (x'=2);\n [on] x=2 -> (x'=4);\n [try] x=5 -> true;\n [out] x=6 -> (x'=1);\n [stay] x=4 -> true;\n\
     endmodule\nlabel \"ice\" = x=2;\nrewards \"cost\" [quick] true : 1; [safe] true : 3; endrewards\n";

fn asked(start: &str, more: &[&str]) -> Finished {
    let model = MODEL.replace("START", start);
    let scratch =
        Scratch::new(&[("m.prism", &model), ("m.props", "Pmax>=1 [ F x=4 ];\nPmax=? [ F x=4 ];\n")]);
    let file = scratch.show("m.props");
    let more = more.iter().map(|word| if *word == "FILE" { &file } else { *word });
    scratch.ask("reach m.prism --json", more)
}

/// Returns whether bounds contain 1/2 and little more.
fn is_half(value: &Json) -> bool {
    let [lower, upper] = ["lower", "upper"].map(|bound| value[bound].as_f64().unwrap());
    lower <= 0.5 && upper >= 0.5 && upper - lower < 1e-9
}

#[test]
fn a_requirement_about_one_state_is_refused_with_what_to_write() {
    let refused = asked("0", &["--target", "x=4", "--require", "!\"ice\""]).expect(3);
    refused.says("not over one state");
    refused.says("write `G (!\"ice\")`");
}

const DRY: &[&str] = &["--require", "G !\"ice\""];

#[test]
fn forbidden_choices_do_not_count() {
    for engine in ["symbolic", "explicit"] {
        let ask = |more: &[&str], status| {
            let more = [more, &["--scope", "all", "--engine", engine]].concat();
            asked("0", &more).expect(status).json()
        };
        let free = ask(&["--property", "Pmax=? [ F x=4 ]"], 0);
        assert_eq!(free["properties"][0]["value"], json!({"lower": 1.0, "upper": 1.0}));
        let bound = ask(&[&["--property", "Pmax=? [ F x=4 ]"], DRY].concat(), 0);
        assert!(is_half(&bound["properties"][0]["value"]), "{bound}");
        let least = ask(&[&["--property", "Pmin=? [ F x=4 ]"], DRY].concat(), 0);
        assert!(is_half(&least["properties"][0]["value"]), "{least}");
        let regions = ask(&[&["--target", "x=4"], DRY].concat(), 0);
        assert_eq!(regions["counts"]["unsafe"], "3", "1, 2 and 6");
        let sizes: Vec<&Json> = ["pmax_one", "pmax_positive", "pmin_one", "pmin_positive"]
            .iter()
            .map(|name| &regions[name])
            .collect();
        assert_eq!(sizes, [&json!("1"), &json!("2"), &json!("1"), &json!("2")]);
        let formula = ask(&[&["--property", "Pmax>=1 [ G F x=4 ]"], DRY].concat(), 1);
        assert_eq!((&formula["holds"], &formula["pmax_positive"]), (&json!(false), &json!("2")));
        let both = ask(&["--properties", "FILE", "--require", "G !\"ice\"", "--require", "G x<6"], 1);
        assert_eq!(both["properties"][0]["holds"], json!(false));
        assert!(is_half(&both["properties"][1]["value"]), "{both}");
    }
}

#[test]
fn a_target_is_counted_once_whatever_monitors_say() {
    for engine in ["symbolic", "explicit"] {
        let options = ["--target", "x=4", "--require", "!\"ice\" W x=4", "--engine", engine];
        assert_eq!(asked("0", &options).expect(0).json()["target"], "1", "{engine}");
    }
}

#[test]
fn rewards_are_checked_in_the_model_with_the_monitors_of_requirements() {
    // Monitors and the conditions on rewards are both expressions next to the model.
    let items: String = (0..60).map(|i| format!("[a] x<{} : x+{i};\n", i % 5)).collect();
    let model = |reward: &str| {
        format!(
            "mdp module m x : [0..4] init 0; [a] x<4 -> 1/2: (x'=x+1) + 1/2: true; [b] x<4 -> (x'=x+1);\n\
             [c] x=4 -> true; endmodule rewards \"cost\"\n{items}[b] true : {reward};\n endrewards"
        )
    };
    let scratch = Scratch::new(&[("right.prism", &model("1")), ("wrong.prism", &model("x-2"))]);
    for engine in ["symbolic", "explicit"] {
        let ask = |name: &str, status| {
            let more = ["--property", "R{\"cost\"}min=? [ F x=4 ]", "--require", "G (x=0 => X X x!=1)"];
            let options = ["reach", &scratch.show(name), "--json", "--engine", engine];
            Finished::of(executable().args(options).args(more)).expect(status).json()
        };
        let found = ask("right.prism", 0);
        // Taking `b` each time costs 1 per step.
        assert_eq!(found["properties"][0]["value"], json!({"lower": 4.0, "upper": 4.0}), "{engine}");
        let wrong = ask("wrong.prism", 3);
        assert!(wrong["message"].as_str().unwrap().contains("earns -2 in the state x=0"), "{wrong}");
    }
}

#[test]
fn a_safe_formula_is_kept_along_the_whole_path() {
    // The same as `G !"ice"`, for paths that begin in 0, 4 or 5; from 1 it says nothing.
    let never_quick = "G (x=0 => (X x!=1))";
    for engine in ["symbolic", "explicit", "auto"] {
        let ask = |start, more: &[&str], status| {
            let more = [more, &["--scope", "all", "--engine", engine, "--require", never_quick]].concat();
            asked(start, &more).expect(status).json()
        };
        let regions = ask("0", &["--target", "x=4"], 0);
        assert_eq!(regions["counts"]["unsafe"], "0");
        let sizes = ["pmax_one", "pmax_positive", "pmin_one", "pmin_positive"].map(|name| &regions[name]);
        assert_eq!(sizes, [&json!("4"), &json!("5"), &json!("4"), &json!("5")], "all but 0 and 5; all but 5");
        for (start, property, half) in [
            ("0", "Pmax=? [ F x=4 ]", true),
            ("0", "Pmin=? [ F x=4 ]", true),
            ("0", "Pmax=? [ (x<4) U (x=4) ]", true),
            ("6", "Pmin=? [ F x=4 ]", false),
        ] {
            let found = ask(start, &["--property", property], 0);
            let value = &found["properties"][0]["value"];
            assert!(is_half(value) == half, "{start} {property}: {value}");
            assert!(half || value["lower"] == json!(1.0), "{start} {property}: {value}");
        }
        let reward = ask("0", &["--property", "R{\"cost\"}min=? [ F x>=4 ]"], 0);
        assert_eq!(reward["properties"][0]["value"], json!({"lower": 3.0, "upper": 3.0}));
        let both = ask("0", &["--properties", "FILE"], 1);
        assert_eq!(both["properties"][0]["holds"], json!(false));
        assert!(is_half(&both["properties"][1]["value"]), "{both}");
        let unsafe_start = ask("0", &["--property", "P>=1 [ F x=4 ]", "--require", "(x=0) W (x=4)"], 1);
        let both = "((x=0) W (x=4)) & (G (x=0 => (X x!=1)))";
        assert_eq!(unsafe_start["unsafe"]["violated"], both, "the requirements are one formula");
    }
}

#[test]
fn an_unsafe_initial_state_is_shown_and_no_property_holds() {
    for engine in ["symbolic", "explicit"] {
        for property in ["P>=1 [ F x=4 ]", "Pmax>=0.5 [ F x=4 ]", "P<1 [ F x=5 ]"] {
            let more = [&["--property", property, "--engine", engine], DRY].concat();
            let found = asked("6", &more).expect(1).json();
            assert_eq!(found["holds"], json!(false), "{property}");
            assert_eq!(found["unsafe"]["violated"], "G !\"ice\"");
            let path = found["unsafe"]["path"].as_array().unwrap();
            let actions: Vec<&Json> = path.iter().map(|step| &step["action"]).collect();
            assert_eq!(actions, [&json!("out"), &json!("on"), &Json::Null]);
        }
    }
}

#[test]
fn a_quantity_from_an_unsafe_initial_state_has_no_value_and_says_why() {
    let reason = "no strategy keeps the requirements from some initial state";
    for engine in ["symbolic", "explicit"] {
        for property in ["Pmax=? [ F x=4 ]", "Pmin=? [ G F x=4 ]", "R{\"cost\"}min=? [ F x=4 ]"] {
            let more = [&["--property", property, "--engine", engine], DRY].concat();
            let found = asked("6", &more).expect(0).json();
            assert_eq!(found.get("holds"), None, "{property}");
            let answer = found["properties"][0].as_object().unwrap();
            assert_eq!((&answer["value"], &answer["reason"]), (&Json::Null, &json!(reason)), "{property}");
        }
        let both = [&["--properties", "FILE", "--engine", engine], DRY].concat();
        let found = asked("6", &both).expect(1).json();
        assert_eq!(
            (&found["properties"][0]["holds"], &found["properties"][1]["reason"]),
            (&json!(false), &json!(reason))
        );
    }
}

#[test]
fn other_formulas_are_refused_by_name() {
    for (formula, word) in [("F x=4", "it is not a safe formula"), ("G y=1", "unknown name `y`")] {
        asked("0", &["--target", "x=4", "--require", formula]).prints(3, word);
    }
}

#[test]
fn a_report_begins_with_an_unsafe_initial_state() {
    let shown = run("check models/pond.prism models/pond.pref").expect(0).stdout;
    let first = shown.find("No strategy keeps the requirements from at=3").expect("the path");
    assert!(first < shown.find("Model").expect("the sizes"), "{shown}");
    assert!(shown.contains("at=3  by slide") && shown.contains("at=4  violated"), "{shown}");
    assert!(shown.contains("unsafe: no strategy keeps the requirements"), "{shown}");
    run("reach models/pond.prism --target at=5 --require G(!at=4)")
        .prints(0, "No strategy keeps the requirements from at=3");
}

#[test]
fn the_text_of_a_quantity_without_a_value_gives_the_reason() {
    let shown = run("reach models/pond.prism --property Pmax=?[F(at=5)] --require G(!at=4)").expect(0).stdout;
    let line = "The property has no value: no strategy keeps the requirements from some initial state.";
    assert!(shown.contains(line), "{shown}");
}

#[test]
fn a_step_between_unsafe_states_is_not_called_improving() {
    let shown = run("strategy models/pond.prism models/pond.pref --at at=3 --kind spi").expect(0).stdout;
    assert!(shown.contains("unsafe") && !shown.contains("improving"), "{shown}");
}

#[test]
fn a_report_names_unsafe_cells_counts_them_and_says_first_that_the_start_is_unsafe() {
    let scratch = Scratch::new(&[]);
    let out = scratch.show("page.html");
    let shown = run!("report models/pond.prism models/pond.pref --out {out}").expect(0).stdout;
    let first = shown.find("No strategy keeps the requirements from at=3").expect("the path");
    assert!(
        shown.find("No strategy keeps the requirements.").is_some_and(|verdict| first < verdict),
        "{shown}"
    );
    let page = std::fs::read_to_string(out).unwrap();
    assert!(page.contains("× unsafe") && page.contains("data-value=\"×\""), "{page}");
    assert!(page.contains("unsafe: no strategy keeps the requirements"), "{page}");
    assert!(page.contains("<p class=\"headline\">No strategy keeps the requirements.</p>"), "{page}");
    run("report models/pond.prism models/pond.pref --format svg --picture spi")
        .prints(0, "× unsafe")
        .shows("data-value=\"×\"");
}

#[test]
fn the_values_of_all_states_name_the_unsafe_ones() {
    let found = run("values models/pond.prism models/pond.pref --all --json").expect(0).json();
    let states = found["states"].as_array().unwrap();
    assert_eq!(states.len().to_string(), found["counts"]["states"]);
    let is_unsafe = |state: &&Json| state["unsafe"] == json!(true);
    assert_eq!(states.iter().filter(is_unsafe).count().to_string(), found["counts"]["unsafe"]);
    for state in states.iter().filter(is_unsafe) {
        assert_eq!((&state["levels"], &state["number"]), (&json!([]), &Json::Null));
    }
    let scratch = Scratch::new(&[]);
    let out = scratch.show("values.csv");
    run!("values models/pond.prism models/pond.pref --all --csv {out}").expect(0);
    let csv = std::fs::read_to_string(out).unwrap();
    let mut lines = csv.lines();
    assert!(lines.next().unwrap().ends_with(",unsafe"), "{csv}");
    let unsafe_lines = lines.filter(|line| line.ends_with(",true")).count();
    assert_eq!(unsafe_lines.to_string(), found["counts"]["unsafe"]);
}
