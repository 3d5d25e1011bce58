//! Games on the command line: what honours the players, and that everything else refuses them.

use serde_json::json;

use crate::common::{Finished, Scratch, meliora, run};

/// We choose in x=0, the opponent in x=1; x=2 is a deadlock.
const GAME: &str = "smg\nplayer us [a], [b] endplayer\nplayer them [c], [d] endplayer\nmodule m\n x : [0..3] init 0;\n\
    [a] x=0 -> (x'=1);\n [b] x=0 -> 1/2:(x'=2)+1/2:(x'=3);\n [c] x=1 -> (x'=2);\n [d] x=1 -> (x'=0);\n\
    [a] x=3 -> true;\nendmodule\n";

const PREFS: &str = "objective Two = F x=2; objective Three = F (x=3);\nprefer Two > Three;\n";

fn scratch() -> Scratch {
    Scratch::new(&[("g.prism", GAME), ("g.pref", PREFS), ("them.pref", &format!("{PREFS}coalition them;\n"))])
}

/// Runs the command in which `@` stands for the directory.
fn at(scratch: &Scratch, arguments: &[&str]) -> Finished {
    let of = |a: &&str| a.strip_prefix('@').map_or((*a).to_owned(), |name| scratch.show(name));
    Finished::of(meliora().args(arguments.iter().map(of)))
}

#[test]
fn commands_for_one_player_refuse_a_game_by_name() {
    let scratch = scratch();
    for (name, more) in [
        ("strategy", &["@g.pref", "--kind", "sasi"][..]),
        ("simulate", &["@g.pref", "--kind", "sasi"]),
        ("values", &["@g.pref"]),
        ("report", &["@g.pref", "--out", "@page.html"]),
        ("export", &["@g.pref", "--out", "@dump"]),
        ("export", &["@g.pref", "--out", "@dump", "--format", "explicit"]),
        ("export", &["@g.pref", "--out", "@dump", "--format", "umb"]),
        ("export", &["@g.pref", "--out", "@dump", "--format", "drn"]),
    ] {
        let refused = at(&scratch, &[&[name, "@g.prism"], more].concat()).expect(3);
        let expected = format!("`{name}` of a game is not supported");
        assert!(refused.stderr.contains(&expected), "{more:?}: {}", refused.stderr);
        assert!(refused.stderr.contains("g.prism:1:1"), "{}", refused.stderr);
        assert!(!scratch.path("dump").exists() && !scratch.path("page.html").exists());
    }
    let refused = at(&scratch, &["info", "@g.prism", "--flat"]).expect(3);
    assert!(refused.stderr.contains("the flat program of a game is not supported"), "{}", refused.stderr);
}

#[test]
fn a_certificate_of_another_model_does_not_verify_a_game() {
    let scratch = scratch();
    let mdp = GAME
        .replace("smg", "mdp")
        .replace("player us [a], [b] endplayer\nplayer them [c], [d] endplayer\n", "");
    std::fs::write(scratch.path("m.prism"), mdp).unwrap();
    at(&scratch, &["export", "@m.prism", "@g.pref", "--out", "@dump"]).expect(0);
    let refused = at(&scratch, &["verify", "@dump", "@g.prism", "@g.pref"]).expect(3);
    assert!(refused.stderr.contains("`verify` of a game is not supported"), "{}", refused.stderr);
}

#[test]
fn options_that_games_do_not_have_are_refused_by_name() {
    let scratch = scratch();
    std::fs::write(scratch.path("play.pref"), "objective A = (G F (x=2)) | (F G (x=1));").unwrap();
    std::fs::write(scratch.path("safe.pref"), "objective A = F (x=2); require x=0 W (x=2);").unwrap();
    for (arguments, status, expected) in [
        (
            &["check", "@g.prism", "@g.pref", "--safety", "transition"][..],
            2,
            "`--safety transition` of a game",
        ),
        (&["compare", "@g.prism", "@g.pref", "--safety", "transition"], 2, "`--safety transition` of a game"),
        (&["check", "@g.prism", "@g.pref", "--jointly"], 2, "`--jointly` of a game"),
        (&["check", "@g.prism", "@play.pref"], 3, "combines recurrence and persistence"),
        (&["check", "@g.prism", "@safe.pref"], 3, "`G condition`"),
        (
            &["reach", "@g.prism", "--property", "<<us>> P>=1 [ (G F x=2) => (G F x=1) ]"],
            3,
            "combines recurrence and persistence",
        ),
        (&["reach", "@g.prism", "--property", "P>=1 [ F x=2 ]"], 3, "names the players"),
        (&["reach", "@g.prism", "--property", "<<us>> Pmax>=1 [ F x=2 ]"], 3, "`<<p1>> P>=1"),
        (&["reach", "@g.prism", "--property", "<<us,you>> P>=1 [ F x=2 ]"], 3, "unknown player `you`"),
        (
            &["reach", "@g.prism", "--property", "<<us>> R{\"r\"}min=? [ F x=2 ]"],
            3,
            "rewards of a game are not",
        ),
        (
            &["reach", "@g.prism", "--property", "<<us>> Pmax=? [ F x=2 ]"],
            2,
            "other than 0 and 1 are not supported",
        ),
        (
            &["reach", "@g.prism", "--property", "<<us>> P>=0.3 [ F x=2 ]"],
            2,
            "other than 0 and 1 are not supported",
        ),
        (&["check", "@g.prism", "@g.pref", "--coalition", "us,you"], 3, "unknown player `you`"),
        (
            &["reach", "models/toy.prism", "--target", "s=3", "--coalition", "us"],
            3,
            "only a game has players",
        ),
        (&["reach", "models/toy.prism", "--property", "<<us>> P>=1 [ F s=3 ]"], 3, "only a game has players"),
        (&["check", "models/toy.prism", "@them.pref"], 3, "only a game has players"),
    ] {
        let refused = at(&scratch, arguments).expect(status);
        assert!(refused.stderr.contains(expected), "{arguments:?}: {}", refused.stderr);
    }
}

#[test]
fn reach_answers_for_each_coalition() {
    let scratch = scratch();
    let sizes = |more: &[&str]| {
        let all = [&["reach", "@g.prism", "--target", "x=2", "--json"], more].concat();
        let json = at(&scratch, &all).expect(0).json();
        ["pmax_one", "pmax_positive", "pmin_one", "pmin_positive"]
            .map(|name| json[name].as_str().unwrap().to_owned())
    };
    for engine in ["symbolic", "explicit"] {
        assert_eq!(sizes(&["--engine", engine]), ["1", "3", "2", "3"]);
        assert_eq!(sizes(&["--engine", engine, "--coalition", "them"]), ["2", "3", "1", "3"]);
        assert_eq!(sizes(&["--engine", engine, "--coalition", "us,2"]), ["3", "3", "1", "1"]);
        for (property, status) in [
            ("<<us>> P>=1 [ F x=2 ]", 1),
            ("<<us>> P>0 [ F x=2 ]", 0),
            ("<<us,them>> P>=1 [ F x=2 ]", 0),
            ("<<*>> P>=1 [ F x=2 ]", 0),
            ("<<>> P>0 [ F x=2 ]", 1),
            ("<<1>> P<1 [ F x=2 ]", 0),
            ("<<them>> P<=0 [ F x=3 ]", 1),
            ("<<them>> P<1 [ F x=3 ]", 0),
            ("<<us>> P>=0.1 [ F x=1 ]", 0),
        ] {
            let found = at(&scratch, &["reach", "@g.prism", "--property", property, "--engine", engine]);
            assert_eq!(found.status, status, "{property}: {found:?}");
        }
        for (property, value) in [
            ("<<us,them>> Pmax=? [ F x=2 ]", 1.0),
            ("<<us>> Pmin=? [ F x=1 ]", 0.0),
            ("<<them>> Pmax=? [ F x=1 ]", 0.0),
        ] {
            let all = ["reach", "@g.prism", "--property", property, "--engine", engine, "--json"];
            let json = at(&scratch, &all).expect(0).json();
            assert_eq!(json["properties"][0]["value"], json!({"lower": value, "upper": value}), "{property}");
        }
    }
}

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
        assert!(refused.stderr.contains(expected), "{}", refused.stderr);
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
    std::fs::write(scratch.path("play.pref"), prefs).unwrap();
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

#[test]
fn a_property_file_has_a_coalition_per_property() {
    let scratch = scratch();
    let file = "\"a\": <<us>> P>=1 [ F x=2 ];\n\"b\": <<us,them>> P>=1 [ F x=2 ];\n\"c\": <<us>> Pmax=? [ F x=2 ];\n\
        \"d\": P>=1 [ F x=2 ];\n\"e\": <<us>> P>0 [ F x=2 ];\n";
    std::fs::write(scratch.path("g.props"), file).unwrap();
    let json = at(&scratch, &["reach", "@g.prism", "--properties", "@g.props", "--json"]).json();
    let holds: Vec<_> = json["properties"].as_array().unwrap().iter().map(|p| p["holds"].clone()).collect();
    assert_eq!(json!(holds), json!([false, true, null, null, true]), "{json}");
}

#[test]
fn check_reports_the_players() {
    let scratch = scratch();
    let check = |prefs: &str, more: &[&str]| {
        at(&scratch, &[&["check", "@g.prism", prefs, "--json"], more].concat()).expect(0).json()
    };
    for engine in ["symbolic", "explicit"] {
        let us = check("@g.pref", &["--engine", engine]);
        let players = json!([
            {"name": "us", "ours": true, "states": "2"}, {"name": "them", "ours": false, "states": "1"}
        ]);
        assert_eq!((&us["players"], &us["model"]["type"]), (&players, &json!("smg")));
        assert_eq!(
            (&us["initial"][0]["owner"], &us["objectives"][0]["almost_sure"]),
            (&json!(null), &json!("1"))
        );
        let them = check("@them.pref", &["--engine", engine]);
        assert_eq!(them["players"][1], json!({"name": "them", "ours": true, "states": "1"}));
        assert_eq!(them["initial"][0]["owner"], json!("opponent"));
        assert_eq!(them["initial"][0]["sasi_actions"], json!([]));
        assert_eq!(check("@them.pref", &["--engine", engine, "--coalition", "us"])["players"], players);
    }
    let text = at(&scratch, &["check", "@g.prism", "@them.pref"]).expect(0).stdout;
    assert!(text.contains("Players") && text.contains("to move: the opponent"), "{text}");
    at(&scratch, &["compare", "@g.prism", "@g.pref"]).expect(0);
    at(&scratch, &["compare", "@g.prism", "@g.pref", "--safety", "prefix", "--coalition", "them"]).expect(0);
    let info = at(&scratch, &["info", "@g.prism", "--json"]).expect(0).json();
    assert_eq!(info["players"].as_array().unwrap().len(), 2);
}

#[test]
fn a_sweep_of_a_game_plays_as_the_coalition() {
    let scratch = scratch();
    std::fs::write(scratch.path("n.prism"), format!("{GAME}const int N;\n")).unwrap();
    let all = ["reach", "@n.prism", "--target", "x=2", "-c", "N=1:2", "--coalition", "them", "--json"];
    let runs = at(&scratch, &all).expect(0).json();
    for run in runs["runs"].as_array().unwrap() {
        assert_eq!(run["result"]["pmax_one"], json!("2"), "{run}");
    }
}

#[test]
fn the_pursuit_is_a_game() {
    for engine in ["symbolic", "explicit"] {
        let arguments =
            format!("check models/pursuit.prism models/pursuit.pref -c N=4 --engine {engine} --json");
        let json = run(&arguments).expect(0).json();
        assert_eq!(json["initial"][0]["sasi_rank"], json!(1));
        assert_eq!(json["initial"][0]["most_preferred"], json!(["Outside"]));
    }
}
