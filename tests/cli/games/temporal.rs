//! Temporal formulas in games.

use serde_json::json;

use super::{at, scratch};

#[test]
fn a_formula_that_is_refused_is_shown_with_both_parts() {
    let property = "<<us>> P>=1 [ (G F x=2) & (F G x<2) & F x=1 ]";
    let refused = at(&scratch(), &["reach", "@g.prism", "--property", property]).expect(3);
    for expected in [
        "recurrence: something",
        "persistence: something",
        "a finite part of a path decides",
        "G F x=2",
        "F G x<2",
    ] {
        refused.says(expected);
    }
}

/// From x=0 we can go to x=1, from where the opponent may always return us or let us go to x=2.
#[test]
fn temporal_formulas_are_answered_for_each_coalition() {
    let scratch = scratch();
    for engine in ["symbolic", "explicit"] {
        for (property, status) in [
            ("<<us>> P>=1 [ G F x<2 ]", 1),
            ("<<us>> P>=1 [ F G x!=1 ]", 0),
            ("<<us>> P>=1 [ (F x=1) & (F x=0) ]", 0),
            ("<<us>> P>=1 [ F (x=1 & X x=0) ]", 1),
            ("<<us,them>> P>=1 [ G F x<2 ]", 0),
            ("<<us>> P>=1 [ (G F x=2) | (G F x=0) ]", 0),
            ("<<us>> P>=1 [ (G F x=2) & (G F x=0) ]", 1),
            ("<<us>> P>0 [ F G x=3 ]", 0),
            ("<<them>> P>0 [ F G x=3 ]", 1),
            ("<<them>> P<=0 [ G F x=1 ]", 0),
            ("<<them>> P<1 [ (G x<2) | F x=2 ]", 1),
        ] {
            let found = at(&scratch, &["reach", "@g.prism", "--property", property, "--engine", engine]);
            assert_eq!(found.status, status, "{property}: {found:?}");
        }
        for (property, value) in [("<<us>> Pmax=? [ F G x!=1 ]", 1.0), ("<<us>> Pmin=? [ G F x=1 ]", 0.0)] {
            let all = ["reach", "@g.prism", "--property", property, "--engine", engine, "--json"];
            let json = at(&scratch, &all).expect(0).json();
            assert_eq!(json["properties"][0]["value"], json!({"lower": value, "upper": value}), "{property}");
        }
    }
}

#[test]
fn objectives_over_whole_paths_are_judged_against_the_opponent() {
    let scratch = scratch();
    let prefs = "objective Settle = F G x!=1; objective Visit = F (x=1 & F x=0); objective Three = F x=3;\n\
        prefer Settle > Three; prefer Visit > Three; require (x<2) W (x=2 | x=3);\n";
    scratch.write("play.pref", prefs);
    for engine in ["symbolic", "explicit"] {
        let json =
            at(&scratch, &["check", "@g.prism", "@play.pref", "--engine", engine, "--json"]).expect(0).json();
        assert_eq!(json["initial"][0]["most_preferred"], json!(["Settle"]), "{json}");
        let other =
            ["check", "@g.prism", "@play.pref", "--coalition", "us,them", "--engine", engine, "--json"];
        let json = at(&scratch, &other).expect(0).json();
        assert_eq!(json["initial"][0]["most_preferred"], json!(["Settle", "Visit"]), "{json}");
    }
    let compared = at(&scratch, &["compare", "@g.prism", "@play.pref", "--json"]).expect(0).json();
    assert_eq!(compared["equal"], json!(true), "{compared}");
    at(&scratch, &["compare", "@g.prism", "@play.pref", "--safety", "prefix", "--coalition", "them"])
        .expect(0);
}
