//! Files of policies: the first rule that holds counts, names are exact, and written files are read back.

use crate::common::prelude::*;

/// Checks a policy; returns what `verify` says.
fn verified(model: [&str; 2], policy: &str, more: &[&str]) -> Finished {
    let scratch = Scratch::new(&[model.into(), ("policy.txt", policy)]);
    let [model, policy] = [model[0], "policy.txt"].map(|name| scratch.show(name));
    Finished::of(executable().args(["verify", &policy, &model, "--json"]).args(more))
}

/// Returns the fault of a policy.
fn fault(model: [&str; 2], policy: &str, target: &str) -> String {
    let report = verified(model, policy, &["--target", target]).expect(1).json();
    report["violation"]["condition"].as_str().unwrap().to_owned()
}

/// Lets `reach` write a policy in both formats and `verify` read them; returns the texts.
fn read_back(model: [&str; 2], target: &str) -> [String; 2] {
    ["policy.txt", "policy.json"].map(|file| {
        let scratch = Scratch::new(&[model.into()]);
        let [model, policy] = [model[0], file].map(|name| scratch.show(name));
        let reach = ["reach", &model, "--target", target, "--policy", &policy];
        Finished::of(executable().args(reach)).expect(0);
        let verify = ["verify", &policy, &model, "--target", target, "--json"];
        let report = Finished::of(executable().args(verify)).expect(0).json();
        assert_eq!(report["accepted"], json!(true));
        std::fs::read_to_string(policy).unwrap()
    })
}

const CASES: [&str; 2] = [
    "m.prism",
    "mdp module m s:[0..2]; b:bool; [go] s=0 -> (s'=1); [Go] s=0 -> (s'=2); [d] s>0 -> true; endmodule",
];

#[test]
fn names_of_actions_differ_by_capitals_and_blanks() {
    let policy = |action: &str| format!("If holds: s=0\nExecute: {action} / SC / d=1\n");
    assert!(verified(CASES, &policy("go"), &["--target", "s=1"]).expect(0).json()["accepted"] == true);
    assert!(fault(CASES, &policy("Go"), "s=1").contains("has no action"));
    assert!(fault(CASES, &policy("GO"), "s=1").contains("takes `GO` in a state where this is not enabled"));
    read_back(CASES, "s=1");
    read_back(CASES, "s=2");
    let jani = jani(&["go", "g o"], &["l"]);
    assert!(fault(["m.jani", &jani], &policy("g o"), "s=2").contains("has no action"));
}

#[test]
fn the_first_rule_that_holds_counts() {
    let rules = |rules: &[[&str; 2]]| {
        rules
            .iter()
            .map(|[holds, action]| format!("If holds: {holds}\nExecute: {action}\n"))
            .collect::<String>()
    };
    // A rule for a whole state does not count before an earlier one that holds.
    let partial_first = rules(&[["s=0", "Go"], ["s=0/b=false", "go"]]);
    assert!(fault(CASES, &partial_first, "s=1").contains("has no action"));
    let whole_first = rules(&[["s=0/b=false", "go"], ["s=0", "Go"]]);
    verified(CASES, &whole_first, &["--target", "s=1"]).expect(0);
    // Negations count, and a rule that contradicts itself never holds.
    assert!(fault(CASES, &rules(&[["s=0/not(s=0)", "go"]]), "s=1").contains("has no action"));
    verified(CASES, &rules(&[["not(b=false)", "Go"], ["not(s=1)", "go"]]), &["--target", "s=1"]).expect(0);
    let task = [
        "t.pddl",
        "(define (domain d) (:predicates (p) (q) (g) (dead))
        (:action good :precondition (not (dead)) :effect (g))
        (:action bad :precondition (not (g)) :effect (and (dead) (q) (not (p)))))
        (define (problem x) (:domain d) (:init (p)) (:goal (g)))",
    ];
    let bad_first = rules(&[["not(g)", "bad"], ["p/not(q)", "good"]]);
    assert!(fault(task, &bad_first, "\"goal\"").contains("no path of the policy"));
    verified(task, &rules(&[["p/not(q)", "good"], ["not(g)", "bad"]]), &["--target", "\"goal\""]).expect(0);
}

#[test]
fn written_rules_with_more_facts_come_first() {
    let task = [
        "t.pddl",
        "(define (domain d) (:predicates (a) (b) (c))
        (:action x :precondition (not (a)) :effect (a))
        (:action y :precondition (and (a) (not (b))) :effect (b))
        (:action z :precondition (and (a) (b)) :effect (c)))
        (define (problem p) (:domain d) (:init) (:goal (c)))",
    ];
    let [text, _] = read_back(task, "\"goal\"");
    let order: Vec<&str> = text.lines().filter(|line| line.starts_with("If")).collect();
    assert_eq!(order, ["If holds: a/b", "If holds: a", "If holds: "]);
}

/// A model with actions and locations of these names: each action leads from 0 to another number, the last one to 1.
fn jani(actions: &[&str], locations: &[&str]) -> String {
    let number = json!({"kind": "bounded", "base": "int", "lower-bound": 0, "upper-bound": 3});
    let guard = json!({"exp": {"op": "=", "left": "s", "right": 0}});
    let edge = |(at, action): (usize, &&str)| {
        let assignments = json!([{"ref": "s", "value": actions.len() - at}]);
        json!({"location": locations[0], "action": action, "guard": guard,
               "destinations": [{"location": locations[locations.len() - 1], "assignments": assignments}]})
    };
    let edges: Vec<Json> = actions.iter().enumerate().map(edge).collect();
    let named = |all: &[&str]| all.iter().map(|name| json!({"name": name})).collect::<Json>();
    json!({"jani-version": 1, "name": "n", "type": "mdp", "actions": named(actions), "properties": [],
           "variables": [{"name": "s", "type": number, "initial-value": 0}],
           "automata": [{"name": "A", "locations": named(locations), "initial-locations": [locations[0]],
                         "edges": edges}],
           "system": {"elements": [{"automaton": "A"}]}})
    .to_string()
}

#[test]
fn files_are_read_back_whatever_names_are_in_them() {
    for names in [["a", "a / b"], ["\"", "a\"b"], ["not(c)", "x=y"], [" a ", "a/b"], ["fin\n", "true"]] {
        let model = jani(&names, &names);
        for target in ["s=1", "s=2"] {
            read_back(["m.jani", &model], target);
        }
    }
    let model = jani(&["a", "a / b"], &["l"]);
    verified(["m.jani", &model], "If holds: s=0\nExecute: a / b\n", &["--target", "s=2"])
        .ends(3, "a name with ` / ` stands in double quotes");
    let quoted = "If holds: s=0\nExecute: \"a / b\"\n";
    verified(["m.jani", &model], quoted, &["--target", "s=1"]).expect(0);
    assert!(fault(["m.jani", &model], quoted, "s=2").contains("has no action"));
}

/// An action may have the name of a command without one.
const DOUBLED: [&str; 2] = [
    "m.jani",
    r##"{"jani-version": 1, "name": "n", "type": "mdp", "actions": [{"name": "A#1"}],
    "variables": [{"name": "s", "type": {"kind": "bounded", "base": "int", "lower-bound": 0, "upper-bound": 2},
                   "initial-value": 0}], "properties": [], "system": {"elements": [{"automaton": "A"}]},
    "automata": [{"name": "A", "locations": [{"name": "l"}], "initial-locations": ["l"], "edges": [
      {"location": "l", "guard": {"exp": {"op": "=", "left": "s", "right": 0}},
       "destinations": [{"location": "l", "assignments": [{"ref": "s", "value": 1}]}]},
      {"location": "l", "action": "A#1", "guard": {"exp": {"op": "=", "left": "s", "right": 0}},
       "destinations": [{"location": "l", "assignments": [{"ref": "s", "value": 2}]}]}]}]}"##,
];

#[test]
fn choices_with_one_name_are_told_apart_by_their_position() {
    let [one, _] = read_back(DOUBLED, "s=1");
    let [other, json] = read_back(DOUBLED, "s=2");
    assert!(one.contains("Execute: A#1 / position=") && one != other, "{one}");
    assert!(json.contains("\"position\": "), "{json}");
    let unclear = "If holds: s=0\nExecute: A#1\n";
    assert!(fault(DOUBLED, unclear, "s=1").contains("several choices have this name"));
    let wrong = "If holds: s=0\nExecute: A#1 / position=2\n";
    assert!(
        fault(DOUBLED, wrong, "s=1")
            .contains("at the position 2 in a state where this choice is not enabled")
    );
}

#[test]
fn actions_that_print_alike_are_told_apart() {
    let task = [
        "t.pddl",
        "(define (domain d) (:requirements :typing) (:predicates (good ?x ?y) (g) (dead) (ok))
        (:action move :parameters (?x ?y) :precondition (ok)
         :effect (and (not (ok)) (when (good ?x ?y) (g)) (when (not (good ?x ?y)) (dead)))))
        (define (problem p) (:domain d) (:objects a b,c a,b c) (:init (ok) (good a b,c)) (:goal (g)))",
    ];
    let unclear = verified(task, "If holds: ok\nExecute: move(a,b,c)\n", &[]).expect(1).json();
    assert!(unclear["violation"]["condition"].as_str().unwrap().contains("not enabled"), "{unclear}");
    read_back(task, "\"goal\"");
}

#[test]
fn preferences_alone_are_no_goal() {
    let task = [
        "t.pddl",
        "(define (domain d) (:predicates (p)) (:action one :effect (p)))
        (define (problem x) (:domain d) (:init) (:goal (preference a (p))))",
    ];
    verified(task, "Policy:\n", &[]).ends(2, "this problem has no goal that must hold");
    verified(task, "If holds:\nExecute: one\n", &["--target", "\"a\""]).expect(0);
    let scratch = Scratch::new(&[task.into()]);
    Finished::of(executable().args(["reach", &scratch.show(task[0])]))
        .ends(2, "this problem has no goal that must hold");
}

#[test]
fn policies_are_checked_from_each_initial_state() {
    let model = [
        "m.prism",
        "mdp module m s:[0..3]; [a] s<2 -> 1/2:(s'=2) + 1/2:(s'=s); [d] s>1 -> true; endmodule
        init s<2 endinit",
    ];
    read_back(model, "s=2");
    let one = "If holds: s=0\nExecute: a\n";
    let report = verified(model, one, &["--target", "s=2"]).expect(1).json();
    assert_eq!(report["violation"]["state"], json!({"s": 1}));
    let none = ["m.prism", "mdp module m s:[0..3]; [a] true -> true; endmodule init s>3 endinit"];
    verified(none, one, &["--target", "s=2"]).expect(2);
}
