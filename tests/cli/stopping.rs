//! `reach --stop-at-target`: the states behind those that decide the question are not explored.

use crate::common::prelude::*;

/// Each step before 3 may go wrong and lead to 5. From both, a long way leads to 20.
const MODEL: &str = "mdp\nmodule m\n x : [0..20] init START;\n\
     [go] x<3 -> 1/2: (x'=x+1) + 1/2: (x'=5);\n [slow] x<3 -> (x'=x+1);\n\
     [on] x>=3 & x<20 -> (x'=x+1);\n endmodule\n\
     rewards \"cost\" [slow] true : 2; [go] true : 1; x>5 : 100; endrewards\n";

fn asked(model: &str, more: &[&str]) -> Finished {
    let scratch = Scratch::new(&[("m.prism", model), ("m.props", "P>=1 [ F x=4 ];\n")]);
    let file = scratch.show("m.props");
    let more = more.iter().map(|word| if *word == "FILE" { &file } else { *word });
    scratch.ask("reach m.prism", more)
}

fn stopped(model: &str, more: &[&str], status: i32) -> Json {
    asked(model, &[more, &["--json", "--stop-at-target"]].concat()).expect(status).json()
}

fn model(start: &str) -> String {
    MODEL.replace("START", start)
}

#[test]
fn the_states_behind_the_target_are_not_counted() {
    for engine in ["symbolic", "explicit"] {
        let whole =
            asked(&model("0"), &["--target", "x=3 | x=5", "--json", "--engine", engine]).expect(0).json();
        assert_eq!(whole["counts"]["states"], "21");
        assert!(whole.get("stops_at_target").is_none());
        let found = stopped(&model("0"), &["--target", "x=3 | x=5", "--engine", engine], 0);
        let counts = &found["counts"];
        assert_eq!((&counts["states"], &counts["deadlocks"]), (&json!("5"), &json!("0")), "{found}");
        assert_eq!((&counts["choices"], &counts["transitions"]), (&json!("8"), &json!("11")));
        assert_eq!((&found["stops_at_target"], &found["target"]), (&json!(true), &json!("2")));
        assert_eq!(found["initial"], whole["initial"]);
        assert_eq!(found["pmin_one"], "5");
        let value = stopped(&model("0"), &["--property", "Pmin=? [ x<2 U x=3 ]", "--engine", engine], 0);
        assert_eq!(value["counts"]["states"], "4", "0, 1, 2 and 5");
        assert_eq!(value["properties"][0]["value"], json!({"lower": 0.0, "upper": 0.0}));
        let cost =
            stopped(&model("0"), &["--property", "R{\"cost\"}max=? [ F x>=3 ]", "--engine", engine], 0);
        assert_eq!(cost["counts"]["states"], "5");
        assert_eq!(cost["properties"][0]["value"], json!({"lower": 6.0, "upper": 6.0}));
    }
}

#[test]
fn the_text_says_that_counts_are_those_of_a_part() {
    let text = asked(&model("0"), &["--target", "x=3", "--stop-at-target"]).expect(0).stdout;
    let line = "The states behind those that decide the question are not explored, nor counted.";
    assert!(text.contains(line), "{text}");
    assert!(!asked(&model("0"), &["--target", "x=3"]).expect(0).stdout.contains(line));
}

#[test]
fn deadlocks_are_those_of_the_part_and_the_label_keeps_its_meaning() {
    // Alone, 20 is a deadlock; where paths stop, it is not.
    for (target, deadlocks, states) in [("x=20", "0", "21"), ("x=3", "1", "20"), ("\"deadlock\"", "0", "21")]
    {
        let found = stopped(&model("0"), &["--target", target], 0);
        assert_eq!(
            (&found["counts"]["deadlocks"], &found["counts"]["states"]),
            (&json!(deadlocks), &json!(states))
        );
        assert_eq!(found["initial"]["pmax_one"], "all", "{target}");
    }
    let never = stopped(&model("0"), &["--property", "P>=1 [ !\"deadlock\" U x=19 ]"], 0);
    assert_eq!((&never["holds"], &never["counts"]["states"]), (&json!(true), &json!("20")));
}

#[test]
fn what_lies_behind_the_target_may_be_wrong() {
    let wrong = model("0").replace("x<20 -> (x'=x+1)", "x<=20 -> (x'=x+1)");
    let error = asked(&wrong, &["--target", "x=4 | x=5", "--json"]).expect(3).json();
    assert!(error["message"].as_str().unwrap().contains("sets `x` to 21"), "{error}");
    stopped(&wrong, &["--target", "x=4 | x=5"], 0);
}

#[test]
fn a_target_without_a_value_is_named() {
    for engine in ["symbolic", "explicit"] {
        let words = ["--target", "mod(8, max(3-x, 0)) = 1", "--engine", engine];
        let error = stopped(&model("0"), &words, 3);
        let message = error["message"].as_str().unwrap();
        let place = "the condition of the states where paths stop has no value in the state x=";
        assert!(message.contains(place), "{message}");
    }
}

#[test]
fn games_stop_too() {
    let game = "smg\nplayer p1 [a] endplayer player p2 [b] endplayer\nmodule m\n x : [0..9] init 0;\n\
        [a] x=0 -> 1/2: (x'=1) + 1/2: (x'=2);\n [b] x=1 -> (x'=2);\n [b] x=1 -> (x'=3);\n\
        [a] x>1 & x<9 -> (x'=x+1);\n endmodule\n";
    for engine in ["symbolic", "explicit"] {
        let found = stopped(game, &["--target", "x=2 | x=3", "--engine", engine], 0);
        assert_eq!((&found["counts"]["states"], &found["pmax_one"]), (&json!("4"), &json!("4")));
        let property = ["--property", "<<p2>> P>=1 [ F x=3 ]", "--engine", engine];
        let found = stopped(game, &property, 0);
        assert_eq!((&found["counts"]["states"], &found["holds"]), (&json!("4"), &json!(true)));
    }
}

#[test]
fn a_question_that_no_state_decides_is_refused() {
    for formula in ["X x=3", "F (x=2 & X x=3)", "G F x=3", "F>=2 x=3", "(F x=3) & (G x<9)"] {
        let error = stopped(&model("0"), &["--property", &format!("Pmax=? [ {formula} ]")], 3);
        let message = error["message"].as_str().unwrap();
        assert!(message.contains("no state alone decides this formula"), "{formula}: {message}");
    }
}

#[test]
fn options_that_ask_for_more_are_refused() {
    let cases: [(&[&str], &str); 5] = [
        (&["--property", "P>=1 [ F x=3 ]", "--property", "P>0 [ F x=4 ]"], "needs one `--target`"),
        (&["--properties", "FILE"], "needs one `--target`"),
        (&["--all-properties"], "needs one `--target`"),
        (&["--target", "x=3", "--require", "G x<9"], "cannot be used with `--require`"),
        (&["--target", "x=3", "--scope", "all"], "cannot be used with `--scope all`"),
    ];
    for (words, message) in cases {
        let error = stopped(&model("0"), words, 2);
        assert!(error["message"].as_str().unwrap().contains(message), "{error}");
    }
}

#[test]
fn sweeps_pass_it_on() {
    let swept = model("0").replace("mdp", "mdp\nconst int N;");
    let found = stopped(&swept, &["--target", "x=N", "-c", "N=1:3"], 0);
    let states = |run: usize| found["runs"][run]["result"]["counts"]["states"].clone();
    assert_eq!([states(0), states(1), states(2)], [json!("18"), json!("19"), json!("20")], "{found}");
    assert_eq!(found["runs"][0]["result"]["stops_at_target"], true);
}
