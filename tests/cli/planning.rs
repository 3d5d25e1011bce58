//! Planning problems in PDDL on the command line.

use serde_json::json;

use crate::common::{Scratch, meliora, run};

const HOUSE: &str = "models/household.pddl models/household-flat.pddl";
const RIVER: &str = "models/responders.pddl";

/// A robot with hyphens in its names, a door that may jam, and an object called like a keyword.
const DOORS: [(&str, &str); 2] = [
    (
        "d.pddl",
        "(define (domain doors) (:predicates (robot-at ?x) (way ?x ?y) (hand-free))
         (:action go :parameters (?x ?y) :precondition (and (robot-at ?x) (way ?x ?y))
           :effect (and (not (robot-at ?x)) (robot-at ?y) (oneof (and) (not (way ?x ?y)))))
         (:action drop :precondition (not (hand-free)) :effect (hand-free)))",
    ),
    (
        "p.pddl",
        "(define (problem p) (:domain doors) (:objects l-1 l-2 init)
         (:init (robot-at l-1) (way l-1 l-2) (way l-2 l-1) (way l-2 init)) (:goal (and (robot-at init) (hand-free))))",
    ),
];

#[test]
fn two_files_in_any_order_one_file_and_standard_input_are_one_model() {
    let scratch = Scratch::new(&DOORS);
    let (domain, problem) = (scratch.show("d.pddl"), scratch.show("p.pddl"));
    let counts = |arguments: &str| run(arguments).expect(0).json()["counts"].clone();
    let two = counts(&format!("info {domain} {problem} --json"));
    assert_eq!(two["states"], "32");
    assert_eq!(counts(&format!("info --json {problem} {domain}")), two);
    std::fs::write(scratch.path("both.pddl"), format!("{}{}", DOORS[1].1, DOORS[0].1)).unwrap();
    assert_eq!(counts(&format!("info {} --json", scratch.show("both.pddl"))), two);
    for (arguments, input) in
        [(format!("info - {problem} --json"), DOORS[0].1), (format!("info {domain} - --json"), DOORS[1].1)]
    {
        let mut command = meliora();
        command.args(arguments.split(' ')).write_stdin(input);
        assert_eq!(crate::common::Finished::of(&mut command).expect(0).json()["counts"], two, "{arguments}");
    }
    let lone = run(&format!("info {domain}")).expect(3).stderr;
    assert!(lone.contains("the problem is missing"), "{lone}");
    let missing = run(&format!("info {domain} nosuch.pddl")).expect(3).stderr;
    assert!(missing.contains("nosuch.pddl: no such file"), "{missing}");
}

#[test]
fn atoms_are_written_as_calls_also_with_hyphens_and_as_labels() {
    let scratch = Scratch::new(&DOORS);
    let model = format!("{} {}", scratch.show("d.pddl"), scratch.show("p.pddl"));
    let states = |target: &str| {
        let mut command = meliora();
        command.arg("reach").args(model.split(' ')).args(["--json", "--target", target]);
        crate::common::Finished::of(&mut command).expect(0).json()["target"].clone()
    };
    assert_eq!(states("robot-at(l-2)"), states("Robot-At( L-2 )"));
    assert_eq!(states("robot-at(l-2) & hand-free"), states("!(!robot-at(l-2) | !hand-free)"));
    assert_eq!(states("\"robot-at(init)\" & hand-free"), states("\"goal\""));
    assert_eq!(states("robot-at(l-1) & robot-at(l-2)"), "0");
    // It is well-formed, but never holds.
    assert_eq!(states("way(l-1,l-1)"), "0");
    let mut command = meliora();
    command.arg("reach").args(model.split(' ')).args(["--target", "robot-at(l-3)"]);
    crate::common::Finished::of(&mut command).expect(3);
}

#[test]
fn a_problem_without_a_target_asks_for_a_strong_cyclic_plan() {
    let report = run(&format!("reach {RIVER} --strong --json")).expect(0).json();
    let plan = json!({"strong_cyclic": true, "strong": false, "strong_states": "24", "policy_states": null});
    assert_eq!(report["plan"], plan);
    assert_eq!(report["holds"], true);
    let scratch = Scratch::new(&DOORS);
    let doors = format!("{} {}", scratch.show("d.pddl"), scratch.show("p.pddl"));
    // The way back may be lost, but not the way on.
    let report = run(&format!("reach {doors} --strong --json")).expect(0).json();
    assert_eq!((&report["plan"]["strong_cyclic"], &report["plan"]["strong"]), (&json!(true), &json!(true)));
    let unsolvable = DOORS[0].1.replace("(robot-at ?y)", "");
    std::fs::write(scratch.path("d.pddl"), unsolvable).unwrap();
    let policy = scratch.show("policy.txt");
    let none = run(&format!("reach {doors} --policy {policy} --json")).expect(1);
    assert_eq!(none.json()["plan"]["strong_cyclic"], false);
    assert!(!scratch.path("policy.txt").exists());
}

#[test]
fn policies_have_an_action_for_each_state_that_they_visit() {
    let scratch = Scratch::new(&[]);
    let (text, json) = (scratch.show("policy.txt"), scratch.show("policy.json"));
    for engine in ["symbolic", "explicit"] {
        let report = run(&format!("reach {RIVER} --policy {text} --json --engine {engine}")).expect(0).json();
        assert_eq!(report["plan"]["policy_states"], "11");
        let text = std::fs::read_to_string(&text).unwrap();
        assert_eq!(text.matches("If holds: ").count(), 11);
        assert!(text.contains("Execute: drive(station,school) / SC / d=8\n"), "{text}");
        run(&format!("reach {RIVER} --policy {json} --engine {engine}")).expect(0);
        let entries: serde_json::Value =
            serde_json::from_str(&std::fs::read_to_string(&json).unwrap()).unwrap();
        assert_eq!(entries.as_array().unwrap().len(), 11);
        assert_eq!(entries[1]["action"], "extinguish(school)");
        assert_eq!(entries[1]["state"][0], "at(school)");
        assert_eq!(entries[1]["distance"], 7);
    }
    // Models of other languages have policies, too, with values in place of facts.
    run(&format!("reach models/drone.prism --target at=1 --policy {json}")).expect(0);
    assert!(std::fs::read_to_string(&json).unwrap().contains("\"at=0\""));
    run(&format!("reach {RIVER} --property F(true) --property G(true) --policy -")).expect(2);
}

#[test]
fn a_policy_never_replaces_one_of_the_two_files_of_its_problem() {
    let scratch = Scratch::new(&DOORS);
    let (domain, problem) = (scratch.show("d.pddl"), scratch.show("p.pddl"));
    for path in [&domain, &problem] {
        let refused = run(&format!("reach {domain} {problem} --policy {path}")).expect(2);
        assert!(refused.stderr.contains("is an input of this run"), "{}", refused.stderr);
    }
}

#[test]
fn preferences_of_a_problem_are_objectives_that_a_file_orders() {
    let report = run(&format!("check {HOUSE} models/household.pref --json")).expect(0).json();
    let names: Vec<_> = report["objectives"].as_array().unwrap().iter().map(|o| o["name"].clone()).collect();
    assert_eq!(names, ["clean", "fed", "played"]);
    assert_eq!(report["initial"][0]["sasi_rank"], 1);
    let report = run(&format!("check {RIVER} models/responders.pref --json")).expect(0).json();
    let names: Vec<_> = report["objectives"].as_array().unwrap().iter().map(|o| o["name"].clone()).collect();
    assert_eq!(names, ["School", "Farm", "goal"]);
    assert_eq!(report["initial"][0]["most_preferred"], json!(["goal"]));
    for engine in ["symbolic", "explicit"] {
        let options = format!("--engine {engine} --scope all --json");
        let report = run(&format!("check {HOUSE} models/household.pref {options}")).expect(0).json();
        // Three places, four values for `closed|has|fed`, four Boolean variables.
        assert_eq!(report["counts"]["states"], "192");
    }
}

#[test]
fn the_place_of_a_robot_can_be_given_by_its_name() {
    let scratch = Scratch::new(&DOORS);
    std::fs::write(scratch.path("x.pref"), "objective A = F hand-free; prefer goal > A;").unwrap();
    let model = format!("{} {} {}", scratch.show("d.pddl"), scratch.show("p.pddl"), scratch.show("x.pref"));
    let report =
        run(&format!("strategy {model} --at robot-at=l-2,way(l-1,l-2)=false --json")).expect(0).json();
    assert_eq!(report["states"][0]["state"]["robot-at"], "l-2");
    assert_eq!(report["states"][0]["most_preferred"], json!(["goal"]));
}

#[test]
fn dumps_of_planning_problems_are_verified_and_queried() {
    let scratch = Scratch::new(&[]);
    let dump = scratch.show("dump");
    run(&format!("export {HOUSE} models/household.pref --out {dump}")).expect(0);
    run(&format!("verify {dump} {HOUSE} models/household.pref")).expect(0);
    let mut query = meliora();
    query.args(["query", &dump, "almost-sure:fed", "--contains", "at=kitchen,closed|has|fed=has(tin)"]);
    crate::common::Finished::of(&mut query).expect(0);
}

#[test]
fn numbers_say_that_probabilities_are_assumed() {
    let assumed = run(&format!("reach {RIVER} --property Pmax=?[F\"goal\"]")).expect(0);
    assert!(assumed.stderr.contains("equal ones are assumed"), "{}", assumed.stderr);
    assert!(!run(&format!("reach {RIVER}")).expect(0).stderr.contains("assumed"));
}
