//! The JSON of some commands. [`crate::cli::json_page`] checks names, order and types of all fields.

use crate::common::prelude::*;

const ROBOT: &str = "models/robot5x5.prism models/robot5x5.pref --scope all";

#[test]
fn a_report_says_what_the_work_took() {
    let report = run!("check {ROBOT} --safety transition --json").expect(0).json();
    assert!(report["time"].as_object().unwrap().values().all(Json::is_f64), "{}", report["time"]);
    assert!(report["memory"]["peak_rss_bytes"].as_u64().unwrap() > 1 << 20);
}

#[test]
fn the_robot_has_the_numbers_of_the_paper() {
    for engine in ["symbolic", "explicit"] {
        let report = run!("check {ROBOT} --safety transition --json --engine {engine}").expect(0).json();
        assert_eq!(report["engine"], engine);
        assert_eq!(
            (&report["scope"], &report["safety"], &report["empty"]),
            (&json!("all"), &json!("transition"), &json!("gain"))
        );
        assert_eq!(report["counts"]["states"], "3600");
        assert_eq!(report["counts"]["choices"], "13888");
        assert_eq!(report["counts"]["transitions"], "18496");
        assert_eq!(
            report["improvement"],
            json!({"states": "7200", "transitions": "35524", "dropped": "734"})
        );
        assert_eq!(report["sasi"], json!({"levels": ["768", "98"], "unbounded": "0"}));
        assert_eq!(
            report["spi"],
            json!({"levels": ["1946", "1477", "1165", "1010", "1004"], "unbounded": "1004"})
        );
        let initial = &report["initial"][0];
        assert_eq!((&initial["sasi_rank"], &initial["sasi_actions"]), (&json!(2), &json!(["N"])));
        assert_eq!(report["initial"].as_array().unwrap().len(), 1);
    }
}

#[test]
fn prefix_has_no_one_improvement_mdp() {
    let report = run("check models/toy.prism models/toy.pref --safety prefix --json").expect(0).json();
    assert_eq!(report["improvement"], Json::Null);
    assert_eq!(report["safety"], "prefix");
}

#[test]
fn a_search_cut_short_does_not_claim_to_know_the_fixpoint() {
    let report = run!("check {ROBOT} --safety transition --max-level 1 --json").expect(0).json();
    assert_eq!(report["sasi"], json!({"levels": ["768"], "unbounded": null}));
    assert_eq!(report["spi"]["levels"], json!(["1946"]));
    assert!(report.get("complete").is_none());
}

#[test]
fn reach_counts_the_states_of_each_region() {
    let report = run("reach models/toy.prism --target s=3 --json").expect(0).json();
    assert_eq!(report["target"], "1");
    assert_eq!(report["pmax_positive"], "2");
    assert_eq!(report["initial"]["pmax_positive"], "all");
    assert_eq!(report["initial"]["pmax_one"], "none");
}

#[test]
fn info_tells_of_order_and_nodes_where_there_are_diagrams() {
    let report = run("info models/toy.prism --json").expect(0).json();
    assert_eq!(report["order"], json!(["s.2", "s.1", "s.0"]));
    assert!(report["nodes"]["transition"].as_u64().unwrap() > 0);
    assert!(report["nodes"]["reachable"].as_u64().unwrap() > 0);
    let explicit = run("info models/toy.prism --json --engine explicit").expect(0).json();
    assert_eq!(explicit["counts"], report["counts"]);
    assert_eq!((&explicit["order"], &explicit["nodes"]), (&Json::Null, &Json::Null));
}

#[test]
fn compare_agrees_and_says_what_it_took() {
    let report = run!("compare {ROBOT} --json").expect(0).json();
    assert_eq!(report["schema"], "meliora.compare/1");
    assert_eq!((&report["equal"], &report["difference"]), (&json!(true), &Json::Null));
    assert_eq!(report["membership"], "3600");
    assert_eq!(report["engines"].as_array().unwrap().len(), 2);
    assert!(["symbolic", "explicit"].contains(&report["prefer"]["engine"].as_str().unwrap()));
    let report = run!("compare {ROBOT} --json --membership 10").expect(0).json();
    assert_eq!(report["membership"], Json::Null);
}

#[test]
fn errors_name_their_kind_and_place() {
    let scratch =
        Scratch::new(&[("m.prism", "mdp\nmodule m\n  x : [0..2] init 0;\n  [] x<2 -> (x'=y);\nendmodule\n")]);
    let path = scratch.show("m.prism");
    let error = run!("info {path} --json").expect(3).json();
    assert_eq!((&error["schema"], &error["kind"]), (&json!("meliora.error/1"), &json!("input")));
    assert_eq!((&error["file"], &error["line"]), (&json!(path), &json!(4)));
    assert_eq!(run("info missing --json").expect(3).json()["file"], "missing");
    assert_eq!(run("info --json").expect(2).json()["kind"], "usage");
    let refused = run("info models/toy.prism --engine explicit --order declared --json").expect(2).json();
    assert_eq!(refused["kind"], "usage");
}
