//! Names that occur twice where each must have one meaning are refused, with their place.

use crate::common::prelude::*;
use crate::dumps::exchange::{index, none, two_states};

/// The line and column of the error of some files, the first of which is the model, and its message.
#[track_caller]
fn refused(files: &[(&str, &str)]) -> ((usize, usize), String) {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    match Document::open(&folder.path().join(files[0].0)).unwrap().load(&none(), &NoProgress) {
        Err(Error::Input(found)) => (found[0].position(), found[0].message.clone()),
        other => panic!("{:?}", other.map(|_| ())),
    }
}

const TRA: &str = "2 2 3\n0 0 0 0.5 a\n0 0 1 0.5 a\n1 0 1 1 b\n";
const STA: &str = "(x,y)\n0:(0,0)\n1:(1,0)\n";
const LAB: &str = "0=\"init\" 1=\"goal\"\n0: 0\n1: 1\n";

#[test]
fn a_label_of_prism_that_is_declared_twice_is_refused() {
    let (place, message) =
        refused(&[("m.tra", TRA), ("m.lab", &LAB.replace("1=\"goal\"", "1=\"goal\" 2=\"goal\""))]);
    assert_eq!((place, message.as_str()), ((1, 22), "the label `goal` occurs twice"));
    let (place, _) = refused(&[("m.tra", TRA), ("m.lab", &LAB.replace("goal", "init"))]);
    assert_eq!(place, (1, 13));
}

#[test]
fn a_variable_of_prism_that_is_declared_twice_is_refused() {
    let (place, message) = refused(&[("m.tra", TRA), ("m.sta", &STA.replace("y", "x")), ("m.lab", LAB)]);
    assert_eq!((place, message.as_str()), ((1, 4), "the variable `x` occurs twice"));
}

#[test]
fn a_choice_with_two_actions_is_refused() {
    let (place, message) = refused(&[("m.tra", &TRA.replace("0 0 1 0.5 a", "0 0 1 0.5 b"))]);
    let said = "choice 0 of state 0 has the action `b` here, and the action `a` in the lines before";
    assert_eq!((place, message.as_str()), ((3, 11), said));
    let (place, message) = refused(&[("m.tra", &TRA.replace("0 0 1 0.5 a", "0 0 1 0.5"))]);
    let said = "choice 0 of state 0 has no action here, and the action `a` in the lines before";
    assert_eq!((place, message.as_str()), ((3, 1), said));
}

#[test]
fn a_reward_model_of_drn_that_is_declared_twice_is_refused() {
    let drn = "@type: MDP\n@reward_models\ncost time cost\n@model\nstate 0 init\n\taction a\n\t\t0 : 1\n";
    let (place, message) = refused(&[("m.drn", drn)]);
    assert_eq!((place, message.as_str()), ((3, 11), "the reward model `cost` occurs twice"));
}

#[test]
fn a_state_that_is_initial_twice_is_one_initial_state() {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in [("m.tra", TRA), ("m.sta", STA), ("m.lab", &LAB.replace("0: 0", "0: 0 0\n0: 0"))] {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    let model = Document::open(&folder.path().join("m.tra")).unwrap().load(&none(), &NoProgress).unwrap();
    assert_eq!(model.program.variables[0].initial, Some(0));
}

#[test]
fn names_of_an_archive_that_occur_twice_are_refused() {
    let bool_of_states = r#"{"applies-to": ["states"], "type": {"type": "bool"}"#;
    let labels = |first: &str, second: &str| {
        format!(r#", "annotations": {{"aps": {{{first}{bool_of_states}}}, {second}{bool_of_states}}}}}}}"#)
    };
    let refused = |rest: &str| two_states(&index("", rest), &[]).map(|_| ()).unwrap_err();
    assert!(two_states(&index("", &labels(r#""a": "#, r#""b": "#)), &[]).is_ok());
    let found = refused(&labels(r#""a": "#, r#""a": "#));
    assert!(found.contains("`a` occurs twice at line"), "{found}");
    let named = labels(r#""a": "#, r#""b": "#).replace(r#""b": {"#, r#""b": {"alias": "a", "#);
    let found = refused(&named);
    assert!(found.contains("`a` and `b` of \"aps\" have the same name `a`"), "{found}");
    let group = r#", "annotations": {"aps": {}, "aps": {}}"#;
    assert!(refused(group).contains("`aps` occurs twice"));
    let valuations = r#", "valuations": {"states": {"unique": true, "classes": [{"variables": [
        {"name": "v", "type": {"type": "uint", "size": 8}}, {"name": "v", "type": {"type": "uint", "size": 8}}]}]}}"#;
    assert!(refused(valuations).contains("the variable `v` occurs twice in a class"));
}
