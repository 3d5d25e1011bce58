//! The models in `models/`: both engines report the same results for each.

use crate::common::prelude::*;

/// The models with constants for which every command takes little time.
pub(crate) const MODELS: [(&str, &str); 18] = [
    ("chain", "N=6"),
    ("counter", ""),
    ("courier", ""),
    ("drone", ""),
    ("fleet", "L=1"),
    ("hospital", ""),
    ("lake", ""),
    ("lateral", ""),
    ("lateral_prefix", ""),
    // Under `prefix`, one component needs both methods for its numbers of improvements.
    ("line", "K=1"),
    ("network", "K=5,M=2"),
    ("patrol", "N=2"),
    ("pond", ""),
    ("rescue", "H=1"),
    ("ring", "N=8,T=4"),
    ("robot5x5", ""),
    ("scramble", "cells=29"),
    ("toy", ""),
];

/// The games, which have no `--safety transition`.
const GAMES: [(&str, &str); 2] = [("pursuit", "N=4"), ("pursuit_items", "N=3")];

/// The option that gives constants their values, where there are any.
pub(crate) fn given(constants: &str) -> String {
    if constants.is_empty() { String::new() } else { format!("-c {constants}") }
}

#[test]
fn every_model_of_the_folder_is_in_the_list() {
    let folder = std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/models")).unwrap();
    let files = folder.map(|file| file.unwrap().path());
    let mut names: Vec<String> = files
        .filter(|path| path.extension().is_some_and(|e| e == "prism"))
        .map(|path| path.file_stem().unwrap().to_string_lossy().into_owned())
        .collect();
    names.sort();
    let mut listed: Vec<&str> = MODELS.iter().chain(&GAMES).map(|(name, _)| *name).collect();
    listed.sort();
    assert_eq!(names, listed);
}

#[test]
fn both_engines_say_the_same_of_every_model_in_every_mode() {
    const MODES: [&str; 3] = ["action", "prefix", "transition"];
    let games = GAMES.map(|model| (model, &MODES[..2]));
    let models = MODELS.map(|model| (model, &MODES[..])).into_iter().chain(games);
    for (at, ((name, constants), modes)) in models.enumerate() {
        // By default, each mode is tested with one scope, which differs from model to model.
        for (place, scope) in ["reachable", "all"].into_iter().enumerate() {
            for (_, safety) in modes.iter().enumerate().filter(|(mode, _)| takes_one_of(2, at + place + mode))
            {
                let inputs = format!("models/{name}.prism models/{name}.pref {}", given(constants));
                let arguments = format!("compare {inputs} --json --scope {scope} --safety {safety}");
                let report = run(&arguments).expect(0).json();
                assert_eq!(report["equal"], true, "{arguments}");
                assert_eq!(report["membership"], report["counts"]["states"], "{arguments}");
            }
        }
    }
}
