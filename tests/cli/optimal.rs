//! Strategies of properties of one operator: written, verified, changed and run.

use serde_json::{Value as Json, json};

use super::common::{Finished, Scratch, executable};

const MODEL: &str = "mdp
module walk
  x : [0..4] init 0;
  [left] x=0 -> 1/4:(x'=1) + 3/4:(x'=3);
  [right] x=0 -> 1/2:(x'=2) + 1/2:(x'=0);
  [wait] x=0 -> true;
  [a] x=2 -> 3/10:(x'=1) + 7/10:(x'=0);
  [b] x=2 -> 1/2:(x'=3) + 1/2:(x'=4);
  [stay] x=1 -> true;
  [back] x=1 -> (x'=0);
  [end] x>2 -> true;
endmodule
rewards \"c\"
  [left] true : 1;
  [right] true : 2;
  x=2 : 3;
  [back] true : 1/2;
endrewards
label \"far\" = x>2;
";

const GAME: &str = "smg
player us [a], [b] endplayer
player them [c], [d] endplayer
module m
  x : [0..4] init 0;
  [a] x=0 -> 1/2:(x'=1) + 1/2:(x'=2);
  [b] x=0 -> (x'=1);
  [c] x=1 -> 1/3:(x'=3) + 2/3:(x'=4);
  [d] x=1 -> 3/4:(x'=3) + 1/4:(x'=0);
  [a] x>1 -> true;
endmodule
";

/// Asks for the strategy of a property; returns the report and the file.
fn written(scratch: &Scratch, property: &str, option: &str) -> (Json, Json) {
    let found = scratch
        .run(format!("reach m.prism --property '{property}' '{option}' policy.json --json"))
        .expect(0)
        .json();
    let file = scratch.read("policy.json");
    (found, serde_json::from_str(&file).unwrap())
}

fn verified(scratch: &Scratch, file: &Json) -> Finished {
    scratch.write("policy.json", file.to_string());
    scratch.run("verify policy.json m.prism --json")
}

fn nodes(file: &Json) -> &Vec<Json> {
    file["strategies"][0]["nodes"].as_array().unwrap()
}

/// Returns the action of the node of a state.
fn action(file: &Json, x: i64) -> String {
    let node = nodes(file).iter().find(|node| node["state"]["x"] == json!(x)).unwrap();
    node["actions"][0]["action"].as_str().unwrap().to_owned()
}

/// Only almost-sure targets, planning problems and `multi` had a strategy.
#[test]
fn each_kind_of_operator_has_a_strategy_that_attains_its_value() {
    let scratch = Scratch::new(&[("m.prism", MODEL)]);
    let kinds = [
        ("Pmax=? [ F x=4 ]", 0.5),
        ("Pmin=? [ F x=1 | x=3 ]", 0.0),
        ("Pmax=? [ x<3 U x=1 ]", 1.0),
        ("Pmax=? [ F<=2 x=1 ]", 0.275),
        ("Pmax=? [ F<=5 x=4 ]", 0.46875),
        ("Pmax=? [ F[2,4] x=2 ]", 0.875),
        ("Pmin=? [ G<=3 x<3 ]", 0.0625),
        ("Pmax=? [ X x=3 ]", 0.75),
        ("Pmax=? [ (G F x=1) & (G F x=2) ]", 1.0),
        ("Pmax=? [ (F x=1) & (F x=4) ]", 0.5),
        ("Pmin=? [ (F G x=3) | (G F x=1) ]", 0.0),
        ("R{\"c\"}min=? [ F x>2 ]", 1.5),
        ("R{\"c\"}min=? [ F (x=1 & X x=0) ]", 143.0 / 6.0),
        ("R{\"c\"}max=? [ C<=6 ]", 13.048125),
        ("R{\"c\"}max=? [ I=3 ]", 1.5),
        ("R{\"c\"}max=? [ S ]", 13.0 / 6.0),
        ("Smax=? [ x=2 ]", 10.0 / 33.0),
        ("Pmax>=0.4 [ F x=4 ]", 0.5),
        ("Pmax=? [ F Pmax>=0.6 [ X x=0 ] ]", 1.0),
    ];
    for (property, value) in kinds {
        let (found, file) = written(&scratch, property, "--policy");
        let claimed = file["strategies"][0]["values"][0].as_f64().unwrap();
        assert!((claimed - value).abs() < 1e-5, "{property}: {claimed} {value}");
        if let Some(answer) = found["properties"][0]["value"]["lower"].as_f64() {
            assert!((claimed - answer).abs() < 1e-5, "{property}: {claimed} {answer}");
        }
        let report = verified(&scratch, &file).expect(0).json();
        assert_eq!(report["accepted"], true, "{property}");
    }
}

/// An infinite reward is a claim like others, and no strategy has the least one.
#[test]
fn infinite_rewards_have_a_strategy_where_they_are_wanted() {
    let scratch = Scratch::new(&[("m.prism", MODEL)]);
    for property in ["R{\"c\"}max=? [ F x=3 ]", "R{\"c\"}max=? [ C ]"] {
        let (_, file) = written(&scratch, property, "--policy");
        assert_eq!(file["strategies"][0]["values"], json!(["infinity"]), "{property}");
        verified(&scratch, &file).expect(0);
    }
    let mut lie = written(&scratch, "R{\"c\"}max=? [ C<=9 ]", "--policy").1;
    lie["strategies"][0]["values"] = json!(["infinity"]);
    verified(&scratch, &lie).expect(1);
    let unreached = "R{\"c\"}min=? [ F x=9 ]";
    let found = scratch.run(format!("reach m.prism --property '{unreached}' --policy none.json"));
    found.ends(0, "no strategy is written");
    assert!(!scratch.path("none.json").exists());
}

/// A choice that only keeps the value may turn in circles without end.
#[test]
fn where_values_tie_the_strategy_makes_progress() {
    let scratch = Scratch::new(&[("m.prism", MODEL)]);
    let (_, file) = written(&scratch, "Pmax=? [ F x=1 ]", "--policy");
    assert_eq!(action(&file, 0), "right");
    assert_eq!(file["strategies"][0]["values"], json!([1.0]));
}

#[test]
fn both_sides_of_a_game_have_a_strategy() {
    let scratch = Scratch::new(&[("m.prism", GAME)]);
    for property in ["<<us>> Pmax=? [ F x=3 ]", "<<us>> Pmax=? [ F<=3 x=3 ]", "<<us>> Pmin=? [ G x!=4 ]"] {
        let (_, ours) = written(&scratch, property, "--policy");
        let (_, theirs) = written(&scratch, property, "--opponent-policy");
        assert_eq!(theirs["side"], "opponent");
        let [a, b] = [&ours, &theirs].map(|file| file["strategies"][0]["values"][0].as_f64().unwrap());
        assert!((a - b).abs() < 1e-6, "{property}: {a} {b}");
        for file in [&ours, &theirs] {
            verified(&scratch, file).expect(0);
        }
        assert!(nodes(&ours).iter().any(|node| node["other"] == true), "{ours}");
        let mut lie = ours.clone();
        let both = lie["strategies"][0]["nodes"].as_array_mut().unwrap();
        let node = both.iter_mut().find(|node| node["other"] == true).unwrap();
        node["actions"].as_array_mut().unwrap().pop();
        verified(&scratch, &lie).expect(1);
    }
    scratch.run("reach m.prism --target x=3 --opponent-policy -").ends(2, "one property of a game");
}

/// Changes a file into one that is false.
type Lie = fn(&mut Json);

#[test]
fn lies_about_a_strategy_are_refused() {
    let scratch = Scratch::new(&[("m.prism", MODEL)]);
    let lies: [(Lie, i32); 9] = [
        (|s| s["values"] = json!(["0.46876"]), 1),
        (|s| s["nodes"][0]["steps"] = json!(1), 1),
        (|s| s["nodes"][1]["steps"] = json!(4), 1),
        (|s| s["nodes"][0]["actions"] = json!([]), 1),
        (|s| s["nodes"][0]["actions"][0]["successors"][0]["probability"] = json!(0.25), 1),
        (|s| s["nodes"][0]["actions"][0]["successors"][0]["node"] = json!(0), 1),
        (|s| s["nodes"][0]["actions"][0]["position"] = json!(0), 3),
        (|s| s["nodes"][0]["state"]["x"] = json!(1), 3),
        (|s| s["share"] = json!(0.5), 3),
    ];
    let (_, file) = written(&scratch, "Pmax=? [ F<=5 x=4 ]", "--policy");
    for (number, (lie, status)) in lies.into_iter().enumerate() {
        let mut changed = file.clone();
        lie(&mut changed["strategies"][0]);
        let found = verified(&scratch, &changed);
        assert_eq!(found.status, status, "{number}: {}{}", found.stdout, found.stderr);
    }
    let mut bound = written(&scratch, "Pmax>=0.4 [ F x=4 ]", "--policy").1;
    bound["property"] = json!("Pmax>=0.6 [ F x=4 ]");
    let refused = verified(&scratch, &bound).expect(1).json();
    assert_eq!(refused["violation"]["condition"], "the strategy does not satisfy the property");
}

/// The memory of a formula is that of its monitors.
#[test]
fn lies_about_the_memory_of_a_formula_are_refused() {
    let scratch = Scratch::new(&[("m.prism", MODEL)]);
    let (_, file) = written(&scratch, "Pmax=? [ (F x=1) & (F x=4) ]", "--policy");
    let memories: Vec<&Json> = nodes(&file).iter().map(|node| &node["memory"]).collect();
    let other = memories.iter().find(|memory| **memory != memories[0]).unwrap();
    let mut lie = file.clone();
    lie["strategies"][0]["nodes"][0]["memory"] = (*other).clone();
    verified(&scratch, &lie).expect(1);
    let mut without = file.clone();
    for node in without["strategies"][0]["nodes"].as_array_mut().unwrap() {
        node.as_object_mut().unwrap().remove("memory");
    }
    verified(&scratch, &without).expect(0);
}

/// `verify` did not look at `round`.
#[test]
fn lies_about_rounds_are_refused() {
    let scratch = Scratch::new(&[("m.prism", MODEL)]);
    let (_, file) = written(&scratch, "Pmax=? [ (G F x=1) & (G F x=2) ]", "--policy");
    assert!(nodes(&file).iter().any(|node| node["round"] == 1), "{file}");
    let lies: [(Lie, &str); 2] = [
        (|s| s["nodes"][0]["round"] = json!(2), "`round` of a node"),
        (
            |s| {
                let nodes = s["nodes"].as_array_mut().unwrap();
                nodes.iter_mut().for_each(|node| node["round"] = json!(0));
            },
            "two nodes have the same state and memory",
        ),
    ];
    for (lie, reason) in lies {
        let mut changed = file.clone();
        lie(&mut changed["strategies"][0]);
        let report = verified(&scratch, &changed).expect(1).json();
        let found = report["violation"]["condition"].as_str().unwrap();
        assert!(found.contains(reason), "{found}");
    }
    let mut lie = written(&scratch, "Pmax=? [ F x=4 ]", "--policy").1;
    lie["strategies"][0]["nodes"][0]["round"] = json!(1);
    verified(&scratch, &lie).expect(1);
}

#[test]
fn several_initial_states_have_one_strategy_with_the_worst_value() {
    let several = MODEL.replace("init 0;", ";") + "init x<3 endinit\n";
    let scratch = Scratch::new(&[("m.prism", &several)]);
    let (_, file) = written(&scratch, "Pmax=? [ F x=4 ]", "--policy");
    assert_eq!(file["strategies"][0]["starts"], 3);
    assert!((file["strategies"][0]["values"][0].as_f64().unwrap() - 0.5).abs() < 1e-6);
    verified(&scratch, &file).expect(0);
    let mut fewer = file.clone();
    fewer["strategies"][0]["starts"] = json!(2);
    verified(&scratch, &fewer).expect(1);
}

#[test]
fn runs_measure_the_value_of_a_strategy() {
    let scratch = Scratch::new(&[("m.prism", MODEL)]);
    let properties = [
        "Pmax=? [ F<=5 x=4 ]",
        "R{\"c\"}min=? [ F x>2 ]",
        "R{\"c\"}max=? [ C<=6 ]",
        "R{\"c\"}max=? [ I=3 ]",
        "R{\"c\"}min=? [ Fc x>2 ]",
        "R{\"c\"}min=? [ F (x=1 & X x=0) ]",
        "Pmax=? [ (F x=1) & (F x=4) ]",
        "Pmin=? [ (F x=1) & (F x=4) ]",
        "Pmax=? [ (G F x=1) & (G F x=2) ]",
        "Pmax=? [ (F G x=3) | (F G x=4) ]",
    ];
    for property in properties {
        written(&scratch, property, "--policy");
        let found = scratch.run("simulate m.prism --policy policy.json --runs 2000 --json").expect(0).json();
        let objective = &found["runs"]["objectives"][0];
        let [low, high] = [0, 1].map(|at| objective["interval"][at].as_f64().unwrap());
        let claimed = objective["claimed"].as_f64().unwrap();
        assert!(low <= claimed && claimed <= high, "{property}: {objective}");
    }
    written(&scratch, "R{\"c\"}max=? [ S ]", "--policy");
    scratch.run("simulate m.prism --policy policy.json").ends(2, "`verify` computes the value");
}

/// Other programs read tables, drawings and the chain that a strategy leaves.
#[test]
fn strategies_have_other_forms() {
    let scratch = Scratch::new(&[("m.prism", MODEL)]);
    let [model, table, drawing, text] = ["m.prism", "s.csv", "s.dot", "s.txt"].map(|name| scratch.show(name));
    let property = "R{\"c\"}min=? [ F \"far\" ]";
    let written = |file: &str| scratch.run(format!("reach m.prism --property '{property}' --policy {file}"));
    written(&table).expect(0);
    let table = scratch.read("s.csv");
    assert!(table.starts_with("node,x,steps,round,action,position,next\n0,0,0,0,left,0,1 2\n"), "{table}");
    written(&drawing).expect(0);
    let drawing = scratch.read("s.dot");
    assert!(drawing.contains("0 -> 1 [label=\"left 0.25\"]"), "{drawing}");
    written(&text).ends(2, ".json, .csv, .dot");
    for (format, file, reward) in
        [("prism", "strategy.prism", "c"), ("drn", "strategy.drn", "c"), ("umb", "strategy.umb", "c")]
    {
        let folder = scratch.show(format);
        let asked = ["reach", &model, "--property", property, "--induced", &folder, "--format", format];
        Finished::of(executable().args(asked)).expect(0);
        let chain = format!("{folder}/{file}");
        let same = format!("R{{\"{reward}\"}}=? [ F \"far\" ]");
        let found = Finished::of(executable().args(["reach", &chain, "--property", &same, "--json"]))
            .expect(0)
            .json();
        let value = found["properties"][0]["value"]["lower"].as_f64().unwrap();
        assert!((value - 1.5).abs() < 1e-6, "{format}: {value}");
    }
    let folder = scratch.show("tra");
    let asked = ["reach", &model, "--property", property, "--induced", &folder];
    Finished::of(executable().args(asked)).expect(0);
    let rewards = scratch.read("tra/strategy.1.srew");
    assert_eq!(rewards, "3 2\n0 1\n1 0.5\n");
    let multi =
        ["reach", &model, "--property", "multi(Pmax=? [ F x=1 ], P>=0 [ F x=4 ])", "--induced", &folder];
    Finished::of(executable().args(multi)).ends(2, "of one operator");
}

/// A `dtmc` was said to have no strong cyclic plan.
#[test]
fn a_chain_has_no_strategies_but_those_that_reach_surely() {
    let chain = "dtmc\nmodule m\n x : [0..2] init 0;\n [] x=0 -> 1/2:(x'=1) + 1/2:(x'=2);\n [] x>0 -> true;\nendmodule\n";
    let scratch = Scratch::new(&[("m.prism", chain)]);
    for property in ["P=? [ F x=1 ]", "P>0 [ F x=1 ]", "P=? [ G F x=1 ]"] {
        let found = scratch.run(format!("reach m.prism --policy p.json --property '{property}'")).expect(2);
        assert!(found.stderr.contains("a `dtmc` has no choices"), "{property}: {}", found.stderr);
    }
    scratch.run("reach m.prism --policy p.json --property 'P>=1 [ F x>0 ]'").expect(0);
}
