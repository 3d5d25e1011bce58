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
    for (name, more) in [("values", &["@g.pref"][..]), ("export", &["@g.pref", "--out", "@dump", "--values"])]
    {
        let refused = at(&scratch, &[&[name, "@g.prism"], more].concat()).expect(3);
        let name = if name == "export" { "--values" } else { name };
        let expected = format!("`{name}` of a game is not supported");
        assert!(refused.stderr.contains(&expected), "{more:?}: {}", refused.stderr);
        assert!(refused.stderr.contains("g.prism:1:1"), "{}", refused.stderr);
        assert!(!scratch.path("dump").exists());
    }
    let refused = at(&scratch, &["info", "@g.prism", "--flat"]).expect(3);
    assert!(refused.stderr.contains("the flat program of a game is not supported"), "{}", refused.stderr);
}

#[test]
fn a_game_is_the_same_after_writing_and_reading() {
    let scratch = scratch();
    let facts = |model: &str, coalition: &str| {
        let json =
            at(&scratch, &["check", model, "@g.pref", "--json", "--coalition", coalition]).expect(0).json();
        let deadlocks = json["counts"]["deadlocks"].clone();
        let players = json["players"].as_array().unwrap().iter();
        let players: Vec<_> = players.map(|p| json!([p["ours"], p["states"]])).collect();
        let of = ["objectives", "classes", "improvement", "sasi", "spi"].map(|name| json[name].clone());
        let owner = json["initial"][0]["owner"].clone();
        (players, deadlocks, of, owner, json["initial"][0]["sasi_actions"].clone())
    };
    for coalition in ["1", "2", "1,2"] {
        for (format, file) in [("umb", "@dump/model.umb"), ("explicit", "@dump/model.tra")] {
            let arguments = ["--format", format, "--out", "@dump", "--coalition", coalition];
            at(&scratch, &[&["export", "@g.prism", "@g.pref"], &arguments[..]].concat()).expect(0);
            assert_eq!(facts(file, coalition), facts("@g.prism", coalition), "{format} {coalition}");
        }
    }
    let info = at(&scratch, &["info", "@dump/model.umb", "--json"]).expect(0).json();
    assert_eq!(info["players"][1]["name"], json!("them"));
    let tra = std::fs::read_to_string(scratch.path("dump/model.tra")).unwrap();
    assert!(tra.starts_with("4:2 6 7\n0:0 0 1 1 a\n"), "{tra}");
    at(&scratch, &["reach", "@dump/model.umb", "--property", "<<them>> P<1 [ F x=3 ]"]).expect(0);
    at(&scratch, &["compare", "@dump/model.tra", "@g.pref", "--coalition", "p2"]).expect(0);
}

/// Our strategy leaves an mdp of the opponent's choices, or a game with fewer choices of ours.
#[test]
fn the_model_that_a_strategy_of_a_game_induces_is_written() {
    let scratch = Scratch::new(&[]);
    let export = |more: &[&str]| {
        let files = ["export", "models/pursuit.prism", "models/pursuit.pref", "-c", "N=3", "--kind", "sasi"];
        at(&scratch, &[&files, more, &["--out", "@out", "--json"]].concat()).expect(0).json()
    };
    for (scheduler, kind) in [("progress", "mdp"), ("permissive", "smg")] {
        let written = export(&["--format", "umb", "--scheduler", scheduler]);
        let archive = format!("@out/sasi-{scheduler}.umb");
        let read = at(&scratch, &["info", &archive, "--json"]).expect(0).json();
        assert_eq!(read["model"]["type"], kind);
        assert_eq!(read["counts"]["states"], written["states"], "{scheduler}");
        // Every path improves, and ends: whatever the opponent does.
        let question = match kind {
            "mdp" => "Pmin>=1 [ F \"settled\" ]",
            _ => "<<robot>> P>=1 [ F \"improved\" ]",
        };
        at(&scratch, &["reach", &archive, "--property", question]).expect(0);
    }
    export(&["--format", "drn", "--scheduler", "progress"]);
    let drn = at(&scratch, &["info", "@out/sasi-progress.drn", "--json"]).expect(0).json();
    assert_eq!(drn["model"]["type"], "mdp");
}

#[test]
fn what_a_game_cannot_be_written_with_is_refused_by_name() {
    let scratch = scratch();
    for (more, name) in [
        (&["--format", "drn"][..], "`--format drn`"),
        (&["--format", "umb", "--values"], "`--values`"),
        (&["--format", "drn", "--kind", "sasi"], "`--format drn`"),
    ] {
        let all = [&["export", "@g.prism", "@g.pref", "--out", "@dump"], more].concat();
        let refused = at(&scratch, &all).expect(3);
        assert!(refused.stderr.contains(&format!("{name} of a game is not supported")), "{}", refused.stderr);
        assert!(refused.stderr.contains("g.prism:1:1"), "{}", refused.stderr);
        assert!(!scratch.path("dump").exists());
    }
}

#[test]
fn a_certificate_of_another_model_does_not_verify_a_game() {
    let scratch = scratch();
    let mdp = GAME
        .replace("smg", "mdp")
        .replace("player us [a], [b] endplayer\nplayer them [c], [d] endplayer\n", "");
    std::fs::write(scratch.path("m.prism"), mdp).unwrap();
    at(&scratch, &["export", "@m.prism", "@g.pref", "--out", "@dump"]).expect(0);
    let refused = at(&scratch, &["verify", "@dump", "@g.prism", "@g.pref"]).expect(1);
    assert!(refused.stdout.contains("the SHA-256 of the model"), "{}", refused.stdout);
}

#[test]
fn a_dump_is_verified_for_its_coalition() {
    let scratch = scratch();
    let accepted = |preferences: &str, more: &[&str]| {
        let all = [&["verify", "@dump", "@g.prism", preferences], more].concat();
        at(&scratch, &all).expect(0);
    };
    let refused = |preferences: &str, more: &[&str], said: &str| {
        let all = [&["verify", "@dump", "@g.prism", preferences], more].concat();
        let refused = at(&scratch, &all).expect(1).stdout;
        assert!(refused.contains(said), "{refused}");
    };
    at(&scratch, &["export", "@g.prism", "@g.pref", "--out", "@dump"]).expect(0);
    accepted("@g.pref", &[]);
    accepted("@g.pref", &["--coalition", "us"]);
    refused("@g.pref", &["--coalition", "them"], "the coalition is `them`: the dump was made for `us`");
    at(&scratch, &["export", "@g.prism", "@g.pref", "--out", "@dump", "--coalition", "them"]).expect(0);
    accepted("@g.pref", &["--coalition", "them"]);
    refused("@g.pref", &[], "`--coalition them` checks it for these players");
    at(&scratch, &["export", "@g.prism", "@them.pref", "--out", "@dump", "--format", "dot"]).expect(0);
    accepted("@them.pref", &[]);
    refused("@them.pref", &["--coalition", "us,them"], "the dump was made for `them`");
    at(&scratch, &["export", "@g.prism", "@g.pref", "--out", "@dump", "--safety", "prefix"]).expect(0);
    accepted("@g.pref", &[]);
}

#[test]
fn query_knows_the_players_and_their_states() {
    let scratch = scratch();
    at(&scratch, &["export", "@g.prism", "@g.pref", "--out", "@dump"]).expect(0);
    for (region, condition, count) in [
        ("player:us", "true", "2"),
        ("player:them", "true", "1"),
        ("player:us | player:them | deadlock", "true", "4"),
        ("player:us & positive:Two", "x<2", "1"),
        ("player:them & strategy:almost-sure:Two", "true", "0"),
        ("bad", "true", "0"),
    ] {
        let found = at(&scratch, &["query", "@dump", region, "--where", condition, "--count"]).expect(0);
        assert_eq!(found.stdout.trim(), count, "{region}");
    }
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
        (
            &["strategy", "@g.prism", "@g.pref", "--safety", "transition"],
            2,
            "`--safety transition` of a game",
        ),
        (&["strategy", "@g.prism", "@g.pref", "--choose", "likely"], 3, "`--choose likely` of a game"),
        (
            &["simulate", "@g.prism", "@g.pref", "--kind", "sasi", "--choose", "cheap"],
            3,
            "`--choose cheap` of a game",
        ),
        (
            &["simulate", "models/toy.prism", "models/toy.pref", "--opponent", "worst"],
            2,
            "only a game (`smg`) has",
        ),
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

/// From x=0, [b] is safe, and [a] leads to x=1, where the opponent can improve by [c] and weaken by [d].
const RISKY: &str = "smg\nplayer us [a], [b] endplayer\nplayer them [c], [d] endplayer\nmodule m\n x : [0..4] init 0;\n\
    [a] x=0 -> (x'=1);\n [b] x=0 -> true;\n [c] x=1 -> (x'=2);\n [d] x=1 -> (x'=3);\n\
    [a] x=2 -> true;\n [a] x=3 -> true;\nendmodule\n";
const RISKY_PREFS: &str = "objective Start = F x<=1; objective End = F x=2;\nprefer End > Start;\n";

fn risky() -> Scratch {
    Scratch::new(&[("g.prism", RISKY), ("g.pref", RISKY_PREFS)])
}

#[test]
fn strategy_tells_who_moves_and_what_the_opponent_can_do() {
    let scratch = risky();
    for engine in ["symbolic", "explicit"] {
        let all =
            ["strategy", "@g.prism", "@g.pref", "--at", "x=0", "--at", "x=1", "--engine", engine, "--json"];
        let json = at(&scratch, &all).expect(0).json();
        let [ours, theirs] = [&json["states"][0], &json["states"][1]];
        assert_eq!(
            (ours.get("owner"), &ours["player"], &ours["chosen_action"]),
            (None, &json!("us"), &json!(null))
        );
        assert_eq!(theirs["owner"], json!("opponent"));
        assert_eq!(theirs["player"], json!("them"));
        assert!(theirs.get("chosen_action").is_none() && theirs.get("progress_action").is_none());
        let verdicts = |state: &serde_json::Value| {
            let actions = state["actions"].as_array().unwrap();
            let of =
                |action: &serde_json::Value| (action["verdict"].clone(), action.get("permitted").cloned());
            actions.iter().map(of).collect::<Vec<_>>()
        };
        let no = Some(json!(false));
        assert_eq!(verdicts(ours), [(json!("exposes"), no.clone()), (json!("nothing-ahead"), no)]);
        assert_eq!(verdicts(theirs), [(json!("improves"), None), (json!("weakens"), None)]);
        let reason = ours["actions"][0]["reason"].as_str().unwrap();
        assert_eq!(reason, "after x=1, them may take d, which weakens: Start lost");
    }
    let csv =
        at(&scratch, &["strategy", "@g.prism", "@g.pref", "--at", "x=*", "--csv", "-"]).expect(0).stdout;
    let lines: Vec<&str> = csv.lines().collect();
    assert!(lines[0].ends_with("reason,owner,player"), "{csv}");
    assert!(
        lines.iter().any(|line| line.starts_with("1,Start,0,0,d,,,,,") && line.ends_with(",opponent,them")),
        "{csv}"
    );
}

#[test]
fn the_graph_of_a_strategy_draws_the_states_of_the_opponent_differently() {
    let start = "x=1,y=0,g=0,robots_turn=false";
    let dot = run(&format!("strategy models/pursuit.prism models/pursuit.pref -c N=4 --at {start} --dot"));
    let dot = dot.expect(0).stdout;
    let line = |name: &str| {
        dot.lines().find(|line| line.contains(name)).unwrap_or_else(|| panic!("{dot}")).to_owned()
    };
    assert!(line("s0 [").contains("guard: ") && line("s0 [").contains("shape=hexagon"), "{dot}");
    assert!(!line("robot: ").contains("hexagon"), "{dot}");
    let moves = dot.lines().filter(|line| line.starts_with("  s0 ->") && line.contains("style=dashed"));
    assert_eq!(moves.count(), 3, "{dot}");
}

#[test]
fn simulate_says_who_moved() {
    let simulate = |more: &str| {
        run(&format!("simulate models/pursuit.prism models/pursuit.pref -c N=4 --kind sasi --runs 50 {more}"))
            .expect(0)
    };
    for engine in ["symbolic", "explicit"] {
        for opponent in ["random", "worst"] {
            let json = simulate(&format!("--engine {engine} --opponent {opponent} --json")).json();
            assert_eq!(json["opponent"], json!(opponent));
            let play = &json["plays"][0];
            assert_eq!((&play["fewer_than_rank"], &play["weakened_step"]), (&json!(0), &json!(0)), "{play}");
            let turns = play["trace"]["turns"].as_array().unwrap();
            for (turn, player) in turns.iter().zip(["robot", "guard"].iter().cycle()) {
                assert_eq!(turn["player"], json!(player));
                assert_eq!(turn.get("owner"), (*player == "guard").then_some(&json!("opponent")));
            }
            let players = play["players"].as_array().unwrap();
            let names: Vec<_> = players.iter().map(|player| (&player["name"], &player["ours"])).collect();
            assert_eq!(names, [(&json!("robot"), &json!(true)), (&json!("guard"), &json!(false))]);
            let steps = |at: usize| players[at]["steps"].as_u64().unwrap();
            assert!(steps(0) >= steps(1) && steps(1) > 0, "{play}");
        }
    }
    assert_eq!(simulate("--json").json()["opponent"], json!("random"));
    let text = simulate("--opponent worst").stdout;
    assert!(text.contains("Steps of all runs: robot (ours)") && text.contains("guard (opponent)"), "{text}");
    let csv = simulate("--csv -").stdout;
    assert!(csv.lines().count() == 3 && csv.contains(",rank,improvements,runs,"), "{csv}");
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

#[test]
fn a_reason_names_the_players_who_can_weaken_together() {
    let model = "smg\nplayer us [a], [b] endplayer\nplayer p2 [c] endplayer\nplayer p3 [d] endplayer\nmodule m\n \
        x : [0..5] init 0;\n [a] x=0 -> (x'=1);\n [b] x=0 -> (x'=3);\n [c] x=1 | x=3 -> (x'=x+1);\n \
        [d] x=2 | x=4 -> (x'=x+1);\n [a] x=5 -> true;\nendmodule\n";
    let scratch = Scratch::new(&[("g.prism", model), ("g.pref", "objective Start = F x<=4;")]);
    let json = at(&scratch, &["strategy", "@g.prism", "@g.pref", "--json"]).expect(0).json();
    let actions = json["states"][0]["actions"].as_array().unwrap();
    let reasons: Vec<&str> = actions.iter().map(|action| action["reason"].as_str().unwrap()).collect();
    let expected = [
        "after x=1, p2 may take c, then 2 more steps and p3 may take d, which weakens: Start lost",
        "after x=3, p2 may take c, then p3 may take d, which weakens: Start lost",
    ];
    assert_eq!(reasons, expected);
    let text = at(&scratch, &["strategy", "@g.prism", "@g.pref", "--coalition", "us,p3"]).expect(0).stdout;
    assert!(text.contains("To move: us (ours)") && text.contains("whatever the opponent does"), "{text}");
}
