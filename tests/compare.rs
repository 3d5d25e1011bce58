//! Both engines say the same of every model that comes with the program.

mod common;

use common::run;

/// The models with constants for sizes that take little time, and the scopes that are small enough.
const MODELS: [(&str, &str, &[&str]); 11] = [
    ("chain", "N=9", &["reachable", "all"]),
    ("fleet", "L=1", &["reachable"]),
    ("lateral", "", &["reachable", "all"]),
    ("lateral_prefix", "", &["reachable", "all"]),
    ("line", "K=1", &["reachable"]),
    ("network", "K=8,M=3", &["reachable", "all"]),
    ("rescue", "H=1", &["reachable", "all"]),
    ("ring", "N=8,T=4", &["reachable", "all"]),
    ("robot5x5", "", &["reachable", "all"]),
    ("scramble", "cells=29", &["reachable", "all"]),
    ("toy", "", &["reachable", "all"]),
];

#[test]
fn both_engines_say_the_same_of_every_model_in_every_mode() {
    for (name, constants, scopes) in MODELS {
        for scope in scopes {
            for safety in ["action", "transition", "prefix"] {
                let mut arguments = format!("compare models/{name}.prism models/{name}.pref --json");
                arguments += &format!(" --scope {scope} --safety {safety}");
                if !constants.is_empty() {
                    arguments += &format!(" --const {constants}");
                }
                let report = run(&arguments).expect(0).json();
                assert_eq!(report["equal"], true, "{arguments}");
                assert_eq!(report["membership"], report["counts"]["states"], "{arguments}");
            }
        }
    }
}

#[test]
fn every_model_is_compared() {
    let folder = std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/models")).unwrap();
    for path in folder.map(|entry| entry.unwrap().path()) {
        let name = path.file_stem().unwrap().to_str().unwrap();
        let is_model = path.extension().is_some_and(|e| e == "prism");
        assert!(!is_model || MODELS.iter().any(|(known, ..)| *known == name), "{name}");
    }
}
