//! Strategies of games, and runs under them.

use super::at;
use crate::common::prelude::*;

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
        let all = [&all[..], &["--safety", "action"]].concat();
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

/// Under `prefix`, the reason only said that a weakening could not be ruled out.
#[test]
fn reasons_name_the_way_to_weaken_under_prefix_too() {
    let scratch = risky();
    for engine in ["symbolic", "explicit"] {
        let json = at(&scratch, &["strategy", "@g.prism", "@g.pref", "--engine", engine, "--json"]);
        let action = json.expect(0).json()["states"][0]["actions"][0].clone();
        assert_eq!(action["verdict"], json!("unsafe"));
        assert_eq!(
            action["reason"],
            json!("not kept: after x=1, them may take d, which weakens: Start lost")
        );
    }
}

/// In an unsafe state, an action of the opponent was said to do nothing.
#[test]
fn an_action_of_the_opponent_in_an_unsafe_state_exposes() {
    let model = "smg player us m endplayer player them [c], [d] endplayer module m x : [0..4]; [c] x=0 -> (x'=4); \
                 [d] x=0 -> (x'=1); [c] x=1 -> (x'=2); endmodule";
    let wishes = "objective High = F x=1; objective Low = F x=2; prefer High > Low; require G x!=4;";
    let scratch = Scratch::new(&[("g.prism", model), ("g.pref", wishes)]);
    for engine in ["symbolic", "explicit"] {
        let json = at(
            &scratch,
            &["strategy", "@g.prism", "@g.pref", "--safety", "action", "--engine", engine, "--json"],
        )
        .expect(0)
        .json();
        let state = &json["states"][0];
        assert!(state.get("unsafe").is_some(), "{state}");
        let verdicts = state["actions"].as_array().unwrap().iter().map(|action| action["verdict"].clone());
        assert_eq!(verdicts.collect::<Vec<_>>(), [json!("violates"), json!("exposes")]);
    }
}

#[test]
fn the_graph_of_a_strategy_draws_the_states_of_the_opponent_differently() {
    let start = "x=1,y=0,g=0,robots_turn=false";
    let dot = run!("strategy models/pursuit.prism models/pursuit.pref -c N=4 --at {start} --dot");
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
        run!("simulate models/pursuit.prism models/pursuit.pref -c N=4 --kind sasi --runs 50 {more}")
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
    simulate("--opponent worst").shows("Steps of all runs: robot (ours)").shows("guard (opponent)");
    let csv = simulate("--statistics -").stdout;
    assert!(csv.lines().count() == 3 && csv.contains(",rank,improvements,runs,"), "{csv}");
}

#[test]
fn a_reason_names_the_players_who_can_weaken_together() {
    let model = "smg\nplayer us [a], [b] endplayer\nplayer p2 [c] endplayer\nplayer p3 [d] endplayer\nmodule m\n \
        x : [0..5] init 0;\n [a] x=0 -> (x'=1);\n [b] x=0 -> (x'=3);\n [c] x=1 | x=3 -> (x'=x+1);\n \
        [d] x=2 | x=4 -> (x'=x+1);\n [a] x=5 -> true;\nendmodule\n";
    let scratch = Scratch::new(&[("g.prism", model), ("g.pref", "objective Start = F x<=4;")]);
    let by_step = ["strategy", "@g.prism", "@g.pref", "--safety", "action"];
    let json = at(&scratch, &[&by_step[..], &["--json"]].concat()).expect(0).json();
    let actions = json["states"][0]["actions"].as_array().unwrap();
    let reasons: Vec<&str> = actions.iter().map(|action| action["reason"].as_str().unwrap()).collect();
    let expected = [
        "after x=1, p2 may take c, then 2 more steps and p3 may take d, which weakens: Start lost",
        "after x=3, p2 may take c, then p3 may take d, which weakens: Start lost",
    ];
    assert_eq!(reasons, expected);
    let text = at(&scratch, &[&by_step[..], &["--coalition", "us,p3"]].concat()).expect(0).stdout;
    let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(text.contains("To move: us (ours)") && text.contains("whatever the opponent does"), "{text}");
}
