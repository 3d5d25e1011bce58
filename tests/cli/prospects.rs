//! The present state in `check` and `strategy`: sure and possible objectives, advice, and the cycles behind
//! unbounded ranks.

use crate::common::prelude::*;

/// From 0, B is possible and A is sure; from 1, which is initial too, nothing is sure.
const SPLIT: &str = "mdp\nmodule m\n x : [0..3] init 0;\n [a] x=0 -> 0.5: (x'=2) + 0.5: (x'=3);\n\
    [b] x=1 -> 0.5: (x'=3) + 0.5: (x'=1);\n [c] x=1 -> true;\nendmodule\ninit x<2 endinit\n";
const SPLIT_PREFS: &str = "objective A = F x>=2; objective B = F x=2; objective C = F x>3; prefer A > B;";

/// After a try that may fail, the first gain can be given up and made again.
const AGAIN: &str = "mdp\nmodule m\n x : [0..4] init 0;\n [try] x=0 -> 0.5: (x'=1) + 0.5: (x'=2);\n\
    [take] x=1 -> (x'=3);\n [back] x=1 -> (x'=4);\n [home] x=4 -> (x'=0);\n [stay] x=2 | x=3 -> true;\nendmodule\n";
const AGAIN_PREFS: &str = "objective B = F x=3; empty = gain;";

fn scratch(model: &str, prefs: &str) -> (Scratch, String) {
    let scratch = Scratch::new(&[("m.prism", &model.replace(" init 0", "")), ("m.pref", prefs)]);
    if !model.contains("endinit") {
        scratch.write("m.prism", model);
    }
    let files = format!("{} {}", scratch.show("m.prism"), scratch.show("m.pref"));
    (scratch, files)
}

#[test]
fn check_says_which_objectives_are_sure_and_possible_in_the_initial_states() {
    let (_scratch, files) = scratch(SPLIT, SPLIT_PREFS);
    for engine in ["symbolic", "explicit"] {
        let report = run!("check {files} --engine {engine} --json -q").expect(0).json();
        let shares = |entry: &Json| (entry["name"].clone(), entry["sure"].clone(), entry["possible"].clone());
        let found: Vec<_> = report["objectives"].as_array().unwrap().iter().map(shares).collect();
        let expected = [("A", "all", "all"), ("B", "none", "some"), ("C", "none", "none")];
        let expected = expected.map(|(name, sure, possible)| (json!(name), json!(sure), json!(possible)));
        assert_eq!(found, expected);
        let initial = &report["initial"];
        assert_eq!((&initial[0]["sure"], &initial[0]["possible"]), (&json!(["A"]), &json!(["A", "B"])));
        assert_eq!((&initial[1]["sure"], &initial[1]["possible"]), (&json!(["A"]), &json!(["A"])));
    }
    let text = run!("check {files} -q").expect(0).stdout;
    let lines: Vec<&str> = text.lines().map(str::trim_end).collect();
    assert!(lines.iter().any(|line| line.ends_with("initially sure  possible")), "{text}");
    let first = lines.iter().position(|line| line.starts_with("Initial state x=0")).unwrap();
    assert_eq!(lines[first + 1..first + 3], ["  sure: A", "  possible: B"]);
}

#[test]
fn sure_objectives_that_are_not_most_preferred_are_listed() {
    let (_scratch, files) = scratch(SPLIT, "objective A = F x>=2; objective B = F x>=0; prefer A > B;");
    run!("check {files} -q").prints(0, "  sure: A, B\n  most preferred: A\n");
    // A requirement that cannot be kept leaves nothing.
    let (_scratch, files) = scratch(SPLIT, "objective A = F x>=2; require G x!=3;");
    let initial = &run!("check {files} -q --json").expect(0).json()["initial"][0];
    assert_eq!((&initial["sure"], &initial["possible"]), (&json!([]), &json!([])));
}

#[test]
fn strategy_names_spi_where_only_possible_improvements_are_left() {
    let (_scratch, files) = scratch(AGAIN, AGAIN_PREFS);
    let tip = "No improvement is guaranteed here; `--kind spi` shows how to try the possible ones.";
    run!("strategy {files}").prints(0, tip);
    assert!(!run!("strategy {files} --kind spi").expect(0).stdout.contains("--kind spi"));
    let trap = run!("strategy {files} --at x=2").expect(0).stdout;
    assert!(!trap.contains("--kind spi"), "{trap}");
    run!("strategy {files} --kind plan").prints(0, "`--choose likely` tries the possible ones.");
}

#[test]
fn an_unbounded_rank_is_explained_by_a_cycle_that_improves() {
    let (scratch, files) = scratch(AGAIN, AGAIN_PREFS);
    let files = format!("{files} --safety action");
    let state = &run!("strategy {files} --kind spi --json").expect(0).json()["states"][0];
    let actions: Vec<&Json> =
        state["cycle"]["steps"].as_array().unwrap().iter().map(|step| &step["action"]).collect();
    assert_eq!(actions, ["try", "back", "home"]);
    assert_eq!(state["cycle"]["repeats_from"], 0);
    let shown = "    1  try   to x=1  with 0.5, B gained\n    2  back  to x=4\n    3  home  to x=0\n    then again from step 1\n";
    let title = "Any number of improvements is possible, because these steps can repeat";
    for command in ["strategy", "check"] {
        let options = if command == "check" { "-v" } else { "--kind spi" };
        run!("{command} {files} {options}").prints(0, title).shows(shown);
    }
    assert!(!run!("check {files}").expect(0).stdout.contains(title));
    let page = scratch.show("page.html");
    run!("report {files} -q --out {page}").expect(0);
    let page = std::fs::read_to_string(page).unwrap();
    assert!(page.contains(title) && page.contains("<b>home</b>"), "no cycle in the page");
    // A finite rank has no cycle, in the page neither.
    let drone = "models/drone.prism models/drone.pref";
    let state = &run!("strategy {drone} --json").expect(0).json()["states"][0];
    assert!(state.get("cycle").is_none(), "{state}");
}

#[test]
fn a_long_cycle_is_shown_by_its_improvements() {
    // From each end to the other takes N steps.
    let model = "mdp\nconst int N;\nmodule m\n x : [0..N] init 0; lost : bool init false;\n\
        [up] !lost & x<N -> 0.5: (x'=x+1) + 0.5: (lost'=true);\n [down] !lost & x=N -> (x'=0);\n\
        [stay] x=N | lost -> true;\nendmodule\n";
    let (_scratch, files) = scratch(model, "objective B = F (x=N & !lost); empty = gain;");
    let spi =
        |n: u32, more: &str| run!("strategy {files} --safety action --kind spi -c N={n} {more}").expect(0);
    let text = spi(40, "").stdout;
    assert!(text.contains("1–39  up …  to x=39,lost=false"), "{text}");
    assert!(text.contains("40    up    to x=40") && text.contains("then again from step 1"), "{text}");
    // Past the limit there is none.
    assert!(spi(1200, "--json").json()["states"][0].get("cycle").is_none());
}
