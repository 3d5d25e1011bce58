//! Archives in UMB through the command: what is written is read as the same model.

use serde_json::Value as Json;

use crate::common::{Finished, Scratch, meliora};

/// Models with values for their constants.
const MODELS: &[(&str, &str)] = &[
    ("chain", "N=2"),
    ("counter", ""),
    ("courier", ""),
    ("drone", ""),
    ("fleet", "L=1"),
    ("lateral", ""),
    ("lateral_prefix", ""),
    ("line", "K=1"),
    ("network", "K=2,M=2"),
    ("patrol", "N=3"),
    ("rescue", "H=2"),
    ("ring", "N=8,T=4"),
    ("robot5x5", ""),
    ("scramble", "cells=5"),
    ("toy", ""),
    ("workshop", "N=2"),
];

fn json(arguments: &[&str], constants: &str) -> Json {
    let mut command = meliora();
    command.args(arguments).arg("--json");
    if !constants.is_empty() {
        command.args(["--const", constants]);
    }
    Finished::of(&mut command).expect(0).json()
}

/// The preferences of a model over the targets in its archive.
fn renamed(text: &str) -> String {
    let mut out = String::new();
    for statement in text.lines().flat_map(|line| line.split("//").next()).collect::<String>().split(';') {
        match statement.split_once('=') {
            Some((left, _)) if left.trim().starts_with("objective") => {
                let name = left.trim().trim_start_matches("objective").trim();
                out += &format!("objective {name} = F \"target_{name}\";\n");
            }
            _ if statement.trim().is_empty() => {}
            _ => out += &format!("{statement};\n"),
        }
    }
    out
}

#[test]
fn every_model_is_the_same_after_writing_and_reading() {
    for (name, constants) in MODELS {
        let scratch = Scratch::new(&[]);
        let extension = if *name == "workshop" { "jani" } else { "prism" };
        let (model, prefs) = (format!("models/{name}.{extension}"), format!("models/{name}.pref"));
        let out = scratch.show("out");
        json(&["export", &model, &prefs, "--format", "umb", "--out", &out], constants);
        let archive = format!("{out}/model.umb");
        let expected = json(&["check", &model, &prefs], constants);
        let text = std::fs::read_to_string(&prefs).unwrap();
        // Temporal objectives have no target. Their monitors are part of the written model, where they
        // also move in deadlocks.
        let is_temporal = expected["counts"].get("model_states").is_some();
        let (own, renamed) = (format!("{out}/own.pref"), renamed(&text));
        std::fs::write(&own, if is_temporal { text } else { renamed }).unwrap();
        let found = json(&["check", &archive, &own], "");
        let counts = ["states", "choices", "transitions", "initial", "deadlocks"];
        for count in &counts[..if is_temporal { 4 } else { 5 }] {
            assert_eq!(found["counts"][count], expected["counts"][count], "{name} {count}");
        }
        for key in ["objectives", "classes", "sasi", "spi"] {
            assert_eq!(found[key], expected[key], "{name} {key}");
        }
    }
}

#[test]
fn a_strategy_in_an_archive_is_the_model_that_it_induces() {
    let scratch = Scratch::new(&[]);
    let out = scratch.show("out");
    for (strategy, kind) in [("sasi:progress", "dtmc"), ("sasi:permissive", "mdp")] {
        let files = ["models/robot5x5.prism", "models/robot5x5.pref", "--out", &out];
        let written =
            json(&[&["export"], &files[..], &["--format", "umb", "--strategy", strategy]].concat(), "");
        let archive = format!("{out}/{}.umb", strategy.replace(':', "-"));
        let read = json(&["info", &archive], "");
        assert_eq!(read["model"]["type"], kind);
        for count in ["states", "choices", "transitions"] {
            assert_eq!(read["counts"][count], written[count], "{strategy} {count}");
        }
    }
}

#[test]
fn rewards_and_labels_survive_the_round_trip() {
    let model = "mdp\nmodule m x:[0..3] init 0;\n[a] x<3 -> 1/3:(x'=x+1) + 2/3:true;\n[b] x=0 -> (x'=3);\n\
        endmodule\nlabel \"far\" = x=3;\nrewards \"cost\" x>0 : 1/7; [b] true : 5; endrewards\n";
    let scratch = Scratch::new(&[("m.prism", model), ("p.pref", "objective A = F \"far\";")]);
    let (model, prefs, out) = (scratch.show("m.prism"), scratch.show("p.pref"), scratch.show("out"));
    json(&["export", &model, &prefs, "--format", "umb", "--out", &out], "");
    let archive = format!("{out}/model.umb");
    let question = ["--property", "R{\"cost\"}max=? [ F \"far\" ]"];
    let asked = |file: &str| json(&[&["reach", file], &question[..]].concat(), "")["properties"].clone();
    assert_eq!(asked(&archive), asked(&model));
}
