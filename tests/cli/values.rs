//! `meliora values`: every model under both engines and all safety modes, limits and files.

use crate::common::prelude::*;

#[test]
fn the_drone_has_the_values_that_its_page_derives() {
    let report =
        run("values models/drone.prism models/drone.pref --json --exact --within 2").expect(0).json();
    assert_eq!(report["schema"], "meliora.values/1");
    let state = &report["states"][0];
    assert_eq!(state["number"]["exact"], "7/6");
    assert_eq!(state["levels"][0]["cost"]["exact"], "1");
    assert_eq!(state["levels"][1]["probability"]["exact"], "1/6");
    assert_eq!(state["levels"][1]["cost"], Json::Null);
    let actions = state["levels"][0]["actions"].as_array().unwrap();
    let names: Vec<_> = actions.iter().map(|a| a["action"].as_str().unwrap()).collect();
    assert_eq!(names, ["survey", "shore"]);
    assert_eq!(state["within"].as_array().unwrap().len(), 3);
}

#[test]
fn all_values_are_written_as_a_table() {
    let scratch = Scratch::new(&[]);
    let file = scratch.show("values.csv");
    run!("values models/drone.prism models/drone.pref --safety action --all --csv {file}").expect(0);
    let text = scratch.read("values.csv");
    let mut lines = text.lines();
    let heading = "at,most_preferred,sasi_rank,spi_rank,improvements,action,probability_lower,\
                   probability_upper,cost_lower,cost_upper";
    assert_eq!(lines.next(), Some(heading));
    assert_eq!(lines.next(), Some("0,Shore,1,2,1,,1,1,1,1"));
    assert_eq!(lines.next(), Some("0,Shore,1,2,1,survey,1,1,1,1"));
}

#[test]
fn the_text_shows_the_first_states_if_a_file_has_all() {
    let scratch = Scratch::new(&[]);
    let file = scratch.show("values.csv");
    let inputs = "values models/ring.prism models/ring.pref -c N=8,T=6 --all";
    let report = run!("{inputs} --csv {file}").expect(0);
    let states = |text: &str| text.lines().filter(|line| line.starts_with("State ")).count();
    let listed = states(&run(inputs).expect(0).stdout);
    assert!(listed > 100, "{listed}");
    assert_eq!(states(&report.stdout), 100);
    let rest = listed - 100;
    report.shows(format!("The file has {rest} more states."));
    let all = run!("{inputs} --csv {file} --json").expect(0).json();
    assert_eq!(all["states"].as_array().unwrap().len(), listed);
}

#[test]
fn a_limit_gives_bounds_and_status_4() {
    let inputs = "models/scramble.prism models/scramble.pref -c cells=10007 --engine explicit";
    let report = run!("values {inputs} --memory 4MiB --json").expect(4).json();
    assert_eq!(report["complete"], false);
    assert_eq!(report["error"]["kind"], "resource");
}

#[test]
fn a_branch_that_only_doubles_see_has_no_value() {
    let model =
        "mdp module m x:[0..2] init 0; [] x=0 -> 1/2:(x'=1) + 1/2:(x'=2) + (0.1+0.2-0.3):(x'=0); endmodule";
    let scratch = Scratch::new(&[("m.prism", model), ("m.pref", "objective A = F x=1; empty = gain;")]);
    let inputs = format!("{} {}", scratch.show("m.prism"), scratch.show("m.pref"));
    let counts = &run!("check {inputs} --json").expect(0).json()["counts"];
    assert_eq!(counts["transitions"], "4");
    run!("values {inputs}").expect(0);
}

#[test]
fn an_unknown_reward_is_refused_by_name() {
    run("values models/toy.prism models/toy.pref --reward fuel").ends(2, "fuel");
}

#[test]
fn a_reward_structure_called_steps_does_not_replace_the_number_of_steps() {
    let model = std::fs::read_to_string("models/toy.prism").unwrap();
    let model = model + "rewards \"steps\" true : 5; endrewards";
    let scratch = Scratch::new(&[("m.prism", &model)]);
    let (model, prefs) = (scratch.show("m.prism"), "models/toy.pref");
    for option in ["", "--reward steps"] {
        let found = run!("values {model} {prefs} --safety action --json {option}").expect(0);
        found.says("not the reward structure \"steps\" of the model");
        assert_eq!(found.json()["states"][0]["levels"][0]["cost"]["upper"], 1.0);
    }
    let (dump, options) = (scratch.show("dump"), "--values --levels 1 -q");
    run!("export {model} {prefs} --out {dump} {options}").expect(0);
    run!("verify {dump} {model} {prefs}").expect(0);
}
