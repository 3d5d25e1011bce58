//! `--choose`: strategies that attain the values, and simulations that measure them.

use serde_json::{Value as Json, json};

use crate::cli::common::{Finished, Scratch, executable, keys, run};

/// Simulates under both engines and returns what both found.
fn simulated(arguments: &str) -> Json {
    let [symbolic, explicit] = ["symbolic", "explicit"]
        .map(|engine| run!("simulate {arguments} --json -q --engine {engine}").expect(0).json());
    assert_eq!(symbolic["plays"], explicit["plays"], "{arguments}");
    symbolic["plays"][0].clone()
}

fn agrees(play: &Json) -> bool {
    let value = &play["value"];
    let inside = |computed: &str, interval: &str| {
        let [lower, upper] = ["lower", "upper"].map(|bound| value[interval][bound].as_f64().unwrap());
        let x = value[computed]["lower"].as_f64().unwrap();
        lower - 1e-9 <= x && x <= upper + 1e-9
    };
    inside("probability", "probability_interval")
        && (value["cost_interval"].is_null() || inside("cost", "cost_interval"))
        && value["agrees"] == true
}

/// Returns whether bounds contain a number, and are close.
fn is(bounds: &Json, x: f64) -> bool {
    let [lower, upper] = ["lower", "upper"].map(|bound| bounds[bound].as_f64().unwrap());
    lower <= x && x <= upper && upper - lower < 1e-9
}

/// The first permitted action succeeds with 0.06, the second with 0.26.
const WORSE: &str = "mdp module m x : [0..3] init 0;
    [rash] x=0 -> 0.06 : (x'=1) + 0.94 : (x'=3);
    [careful] x=0 -> 0.26 : (x'=1) + 0.74 : (x'=3);
    [] x>0 -> true; endmodule";

/// All actions in 0 and 1 are equally good, but only one of them is not part of a cycle.
const TIES: &str = "mdp module m x : [0..4] init 0;
    [wait] x<2 -> true;
    [there] x=0 -> (x'=1);
    [back] x=1 -> (x'=0);
    [go] x=1 -> 1/2 : (x'=2) + 1/2 : (x'=3);
    [] x>1 -> true; endmodule";

/// Both ways end in 3 or 4. The short way costs 9, the long way 1/2 per step and 6 steps on average.
const WAYS: &str = "mdp module m x : [0..4] init 0;
    [fast] x=0 -> 1/2 : (x'=3) + 1/2 : (x'=4);
    [slow] x=0 -> (x'=1);
    [slow] x=1 -> 1/4 : (x'=2) + 3/4 : true;
    [slow] x=2 -> 1/2 : (x'=3) + 1/2 : (x'=4);
    [] x>2 -> true; endmodule
    rewards \"fuel\" [fast] true : 9; [slow] true : 1/2; endrewards
    rewards \"wrong\" [fast] true : 1; x=3 : -1; endrewards";

fn scratch() -> Scratch {
    let goal = |x: usize| format!("objective Goal = F x={x};");
    Scratch::new(&[
        ("worse.prism", WORSE),
        ("worse.pref", &goal(1)),
        ("ties.prism", TIES),
        ("ties.pref", &goal(2)),
        ("ways.prism", WAYS),
        ("ways.pref", "objective One = F x=3; objective Other = F x=4;"),
    ])
}

fn files(scratch: &Scratch, name: &str) -> String {
    format!("{} {}", scratch.show(&format!("{name}.prism")), scratch.show(&format!("{name}.pref")))
}

#[test]
fn likely_takes_the_better_action_although_it_is_not_the_first() {
    let scratch = scratch();
    let files = files(&scratch, "worse");
    let first = simulated(&format!("{files} --kind spi --seed 3"));
    let likely = simulated(&format!("{files} --choose likely --seed 3"));
    assert_eq!(first["value"], Json::Null);
    assert!(first["improvements"][1]["plays"].as_u64().unwrap() < 100);
    assert!(is(&likely["value"]["probability"], 0.26));
    assert!(agrees(&likely), "{likely}");
    let state = &run!("strategy {files} --choose likely --json").expect(0).json()["states"][0];
    assert_eq!((&state["progress_action"], &state["chosen_action"]), (&json!("rash"), &json!("careful")));
    assert_eq!(state["attains"]["improvements"], 1);
}

#[test]
fn ties_do_not_form_a_cycle() {
    let scratch = scratch();
    let play = simulated(&format!("{} --choose likely --runs 2000", files(&scratch, "ties")));
    assert!(is(&play["value"]["probability"], 0.5));
    assert!(agrees(&play) && play["given_up"] == 0, "{play}");
}

/// Only the last place matters, and the battery suffices for detours, which do not change the probability.
const CORRIDOR: &str = "mdp module robot x : [0..3] init 0; b : [0..9] init 9; got : [0..2] init 0;
    [left] x>0 & b>0 -> (x'=x-1) & (b'=b-1);
    [right] x<3 & b>0 -> (x'=x+1) & (b'=b-1);
    [charge] x=0 -> (b'=9);
    [pick] x=3 & got=0 -> 0.9 : (got'=1) + 0.1 : (got'=2);
    [wait] true -> true; endmodule";

/// The robot went right, left, right, left, …
#[test]
fn of_the_likeliest_strategies_the_one_with_the_fewest_steps_is_taken() {
    let wishes = "objective Home = F x=0; objective Item = F got=1; prefer Item > Home;";
    let scratch = Scratch::new(&[("corridor.prism", CORRIDOR), ("corridor.pref", wishes)]);
    let files = files(&scratch, "corridor");
    for options in [
        "--choose likely",
        "--choose likely --safety prefix",
        "--choose likely --safety transition",
        "--kind plan --choose likely",
        "--kind achieve --objective Item --choose likely",
    ] {
        let play = simulated(&format!("{files} {options} --runs 200"));
        let trace = play["trace"]["turns"].as_array().unwrap();
        let actions: Vec<&str> = trace.iter().map(|turn| turn["action"].as_str().unwrap()).collect();
        assert_eq!(actions[..4], ["right", "right", "right", "pick"], "{options}");
        assert!(is(&play["value"]["probability"], 0.9) && agrees(&play), "{options}: {play}");
    }
}

#[test]
fn the_cheapest_way_depends_on_the_reward_structure() {
    let scratch = scratch();
    let files = files(&scratch, "ways");
    for (options, action, cost) in [("", "fast", 1.0), ("--reward fuel", "slow", 3.0)] {
        let arguments = format!("{files} --choose cheap {options}");
        let report = run!("strategy {arguments} --json").expect(0).json();
        assert_eq!(report["states"][0]["chosen_action"], action);
        let play = simulated(&arguments);
        assert!(is(&play["value"]["cost"], cost) && agrees(&play), "{options}: {play}");
    }
    let report = run!("strategy {files} --choose cheap --reward fuel --json").expect(0).json();
    assert_eq!((&report["choose"], &report["reward"]), (&json!("cheap"), &json!("fuel")));
}

#[test]
fn the_choice_keeps_requirements() {
    let scratch = scratch();
    let wishes = "objective One = F x=3; objective Other = F x=4; require G !(x=1);";
    scratch.write("ways.pref", wishes);
    scratch.write("worse.pref", "objective Goal = F x=1; require G !(x=3);");
    // The cheaper way is forbidden.
    let arguments = format!("{} --choose cheap --reward fuel", files(&scratch, "ways"));
    for engine in ["symbolic", "explicit"] {
        let report = run!("strategy {arguments} --json --engine {engine}").expect(0).json();
        assert_eq!(report["states"][0]["chosen_action"], "fast");
    }
    let play = simulated(&arguments);
    assert!(is(&play["value"]["cost"], 9.0) && agrees(&play), "{play}");
    // Both actions may violate the requirement: nothing is left to choose.
    let unsafe_start = run!("values {} --json", files(&scratch, "worse")).expect(0).json();
    assert_eq!(unsafe_start["states"][0]["unsafe"], true, "{unsafe_start}");
    assert_eq!(unsafe_start["states"][0]["levels"], json!([]));
    // All states are listed, the unsafe ones too.
    let all = run!("values {} --all --json", files(&scratch, "worse")).expect(0).json();
    assert_eq!(all["states"].as_array().unwrap().len().to_string(), all["counts"]["states"]);
    assert!(all["states"].as_array().unwrap().contains(&unsafe_start["states"][0]), "{all}");
    // As many states as the analysis has, but not all of them.
    let twice = run!("values {} --at x=0 --at x=0 --json", files(&scratch, "worse")).expect(0).json();
    assert_eq!(twice["states"], json!([unsafe_start["states"][0], unsafe_start["states"][0]]));
}

#[test]
fn a_wrong_reward_in_any_state_of_the_scope_is_an_error() {
    let scratch = scratch();
    for command in ["values", "strategy --choose cheap", "simulate --choose cheap"] {
        for engine in ["symbolic", "explicit"] {
            let (name, options) = command.split_once(' ').unwrap_or((command, ""));
            let options = format!("{options} --reward wrong --at x=2 --engine {engine} --json");
            let found = run!("{name} {} {options}", files(&scratch, "ways")).expect(3).json();
            assert_eq!(found["message"], "the reward structure \"wrong\" earns -1 in the state x=3");
            assert_eq!(found["line"], 8);
        }
    }
}

#[test]
fn the_text_shows_both_numbers() {
    let drone = "models/drone.prism models/drone.pref";
    let text = run!("simulate {drone} --choose likely").expect(0).stdout;
    let value = "  Probability of 2 improvements: 0.166667 computed,\n    \
                 0.167 measured (99 % interval 0.138835 to 0.199555).\n";
    assert!(text.contains(value) && text.contains("· choose likely ·"), "{text}");
    let text = run!("strategy {drone} --choose likely").expect(0).stdout;
    assert!(text.contains("Attains: 2 improvements with probability 0.166667"), "{text}");
    assert!(text.contains("survey  permitted, most likely to improve"), "{text}");
    run!("strategy {drone} --choose cheap")
        .prints(0, "Attains: 1 improvement with probability 1, 1 step expected");
    let table = run!("strategy {drone} --choose likely --csv -").expect(0).stdout;
    assert!(table.lines().any(|line| line.contains("survey,true,true,true,true")), "{table}");
}

#[test]
fn whole_paths_are_judged_under_history_play() {
    let text = std::fs::read_to_string("models/drone.pref").unwrap();
    let scratch = Scratch::new(&[("play.pref", &format!("history = play;\n{text}"))]);
    let play = simulated(&format!("models/drone.prism {} --choose likely", scratch.show("play.pref")));
    assert!(agrees(&play) && play["value"]["improvements"] == 2, "{play}");
}

#[test]
fn runs_that_are_given_up_widen_the_interval() {
    let scratch = scratch();
    let play = simulated(&format!("{} --choose cheap --reward fuel --steps 4", files(&scratch, "ways")));
    let value = &play["value"];
    assert!(value["open"].as_u64().unwrap() > 0 && value["measured_cost"].is_null(), "{value}");
    assert_eq!(value["probability_interval"]["upper"], 1.0);
}

#[test]
fn all_fields_are_there_without_values_too() {
    let names = ["choose", "reward"];
    let report = run("strategy models/toy.prism models/toy.pref --json").expect(0).json();
    assert!(names.iter().all(|name| keys(&report).contains(name)));
    assert_eq!((&report["choose"], &report["reward"]), (&json!("first"), &Json::Null));
}

#[test]
fn combinations_without_a_meaning_are_refused_by_name() {
    let refused = |options: &str| {
        let all = format!("simulate models/toy.prism models/toy.pref {options}");
        Finished::of(executable().args(all.split_whitespace())).expect(2).stderr
    };
    for (options, message) in [
        ("--choose likely --kind sasi", "with `--kind sasi`, use `--choose cheap`"),
        ("--choose cheap --kind spi", "with `--kind spi`, use `--choose likely`"),
        ("--choose cheap --scheduler permissive", "`--scheduler permissive` takes all permitted actions"),
        ("--reward fuel", "`--reward` needs computed values"),
        ("--levels 2", "`--levels` needs computed values"),
        ("--choose cheap --reward fuel", "no such reward structure; there are steps"),
        ("--choose likely --levels 3 --max-level 1", "the analysis ended at level 1; quantities need 3"),
    ] {
        let stderr = refused(options);
        assert!(stderr.contains(message), "{options}: {stderr}");
    }
}

/// The values of the start need few of the states.
#[test]
fn values_of_a_large_model_are_found_near_the_start() {
    let model = "mdp module m x:[0..12] init 9; y:[0..9999]; [] x=2 -> 0.5:(x'=0) + 0.5:(x'=1);
        [] x>2 -> 0.7:(x'=x-1) + 0.3:true; [] x>2 -> (y'=9999-y); [] x>2 -> (y'=mod(7*y+1, 10000)); endmodule";
    let wishes = "objective A = F x=0; objective B = F x=1;";
    let scratch = Scratch::new(&[("m.prism", model), ("m.pref", wishes)]);
    let report = scratch.run("values m.prism m.pref --json").expect(0).json();
    let level = &report["states"][0]["levels"][0];
    for cost in [&level["cost"], &level["actions"][0]["cost"]] {
        let [lower, upper] = ["lower", "upper"].map(|bound| cost[bound].as_f64().unwrap());
        assert!(lower <= 11.0 && 11.0 <= upper && upper - lower < 1e-6, "{report}");
    }
}
