//! Games on the command line: players and coalitions, regions and levels.

mod files;
mod refused;
mod strategies;
mod temporal;

use crate::common::prelude::*;

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
    Finished::of(executable().args(arguments.iter().map(of)))
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
fn a_property_file_has_a_coalition_per_property() {
    let scratch = scratch();
    let file = "\"a\": <<us>> P>=1 [ F x=2 ];\n\"b\": <<us,them>> P>=1 [ F x=2 ];\n\"c\": <<us>> Pmax=? [ F x=2 ];\n\
        \"d\": P>=1 [ F x=2 ];\n\"e\": <<us>> P>0 [ F x=2 ];\n";
    scratch.write("g.props", file);
    let json = at(&scratch, &["reach", "@g.prism", "--properties", "@g.props", "--json"]).json();
    let holds: Vec<_> = json["properties"].as_array().unwrap().iter().map(|p| p["holds"].clone()).collect();
    // Without players, all choose together and the formula is to hold for each of their strategies, as in an mdp.
    assert_eq!(json!(holds), json!([false, true, null, false, true]), "{json}");
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
    at(&scratch, &["check", "@g.prism", "@them.pref"]).prints(0, "Players").shows("to move: the opponent");
    at(&scratch, &["compare", "@g.prism", "@g.pref"]).expect(0);
    at(&scratch, &["compare", "@g.prism", "@g.pref", "--safety", "prefix", "--coalition", "them"]).expect(0);
    let info = at(&scratch, &["info", "@g.prism", "--json"]).expect(0).json();
    assert_eq!(info["players"].as_array().unwrap().len(), 2);
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

/// A requirement of ours rules out choices of ours, also where the opponent wants to reach a target.
#[test]
fn a_requirement_binds_us_in_every_region() {
    let game = "smg\nplayer us m, [c] endplayer\nplayer them [a] endplayer\nmodule m\n x : [0..3] init 0;\n\
        [] x=0 -> 1/2:(x'=1)+1/2:(x'=2);\n [c] x=0 -> (x'=3);\n [a] x=1 -> 1/3:(x'=3)+2/3:(x'=2);\nendmodule\n";
    let scratch = Scratch::new(&[("r.prism", game)]);
    for engine in ["symbolic", "explicit"] {
        let all =
            ["reach", "@r.prism", "--target", "x>=2", "--require", "G !(x=2)", "--engine", engine, "--json"];
        let json = at(&scratch, &all).expect(0).json();
        for region in ["pmax_one", "pmax_positive", "pmin_one", "pmin_positive"] {
            assert_eq!(json[region], "2", "{region} with the {engine} engine");
        }
    }
}
