//! Both engines report the same results for every model in `models/`.

use crate::common::run;

/// The models with constants for sizes that take little time.
const MODELS: [(&str, &str); 17] = [
    ("chain", "N=9"),
    ("counter", ""),
    ("courier", ""),
    ("drone", ""),
    ("fleet", "L=1"),
    ("lateral", ""),
    ("lateral_prefix", ""),
    ("line", "K=1"),
    ("network", "K=8,M=3"),
    ("patrol", "N=3"),
    ("pond", ""),
    ("pursuit", "N=4"),
    ("rescue", "H=1"),
    ("ring", "N=8,T=4"),
    ("robot5x5", ""),
    ("scramble", "cells=29"),
    ("toy", ""),
];

#[test]
fn both_engines_say_the_same_of_every_model_in_every_mode() {
    for (name, constants) in MODELS {
        for scope in ["reachable", "all"] {
            for safety in ["action", "transition", "prefix"] {
                // Games have no `transition`.
                if (name, safety) == ("pursuit", "transition") {
                    continue;
                }
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
        assert!(!is_model || MODELS.iter().any(|(known, _)| *known == name), "{name}");
    }
}
