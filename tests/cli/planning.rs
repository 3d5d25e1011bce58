//! Planning problems in PDDL on the command line.

use crate::common::prelude::*;

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
    scratch.write("both.pddl", format!("{}{}", DOORS[1].1, DOORS[0].1));
    assert_eq!(counts(&format!("info {} --json", scratch.show("both.pddl"))), two);
    for (arguments, input) in
        [(format!("info - {problem} --json"), DOORS[0].1), (format!("info {domain} - --json"), DOORS[1].1)]
    {
        let mut command = executable();
        command.args(arguments.split(' '));
        assert_eq!(Finished::reading(&mut command, input).expect(0).json()["counts"], two, "{arguments}");
    }
    run!("info {domain}").ends(3, "the problem is missing");
    run!("info {domain} nosuch.pddl").ends(3, "nosuch.pddl: no such file");
    run!("info {domain} nosuch").ends(3, "nosuch: no such file");
    run!("info {domain} --problem models/toy.prism").ends(2, "`models/toy.prism` is not in PDDL");
}

#[test]
fn atoms_are_written_as_calls_also_with_hyphens_and_as_labels() {
    let scratch = Scratch::new(&DOORS);
    let model = format!("{} {}", scratch.show("d.pddl"), scratch.show("p.pddl"));
    let states = |target: &str| {
        let mut command = executable();
        command.arg("reach").args(model.split(' ')).args(["--json", "--target", target]);
        Finished::of(&mut command).expect(0).json()["target"].clone()
    };
    assert_eq!(states("robot-at(l-2)"), states("Robot-At( L-2 )"));
    assert_eq!(states("robot-at(l-2) & hand-free"), states("!(!robot-at(l-2) | !hand-free)"));
    assert_eq!(states("\"robot-at(init)\" & hand-free"), states("\"goal\""));
    assert_eq!(states("robot-at(l-1) & robot-at(l-2)"), "0");
    // It is well-formed, but never holds.
    assert_eq!(states("way(l-1,l-1)"), "0");
    let mut command = executable();
    command.arg("reach").args(model.split(' ')).args(["--target", "robot-at(l-3)"]);
    Finished::of(&mut command).expect(3);
}

#[test]
fn a_problem_without_a_target_asks_for_a_strong_cyclic_plan() {
    let report = run!("reach {RIVER} --strong --json").expect(0).json();
    let plan = json!({"strong_cyclic": true, "strong": false, "strong_states": "24", "policy_states": null});
    assert_eq!(report["plan"], plan);
    assert_eq!(report["holds"], true);
    let scratch = Scratch::new(&DOORS);
    let doors = format!("{} {}", scratch.show("d.pddl"), scratch.show("p.pddl"));
    // The way back may be lost, but not the way on.
    let report = run!("reach {doors} --strong --json").expect(0).json();
    assert_eq!((&report["plan"]["strong_cyclic"], &report["plan"]["strong"]), (&json!(true), &json!(true)));
    let unsolvable = DOORS[0].1.replace("(robot-at ?y)", "");
    scratch.write("d.pddl", unsolvable);
    let policy = scratch.show("policy.txt");
    let none = run!("reach {doors} --policy {policy} --json").expect(1);
    assert_eq!(none.json()["plan"]["strong_cyclic"], false);
    assert!(!scratch.path("policy.txt").exists());
}

#[test]
fn policies_have_an_action_for_each_state_that_they_visit() {
    let scratch = Scratch::new(&[]);
    let (text, json) = (scratch.show("policy.txt"), scratch.show("policy.json"));
    for engine in ["symbolic", "explicit"] {
        let report = run!("reach {RIVER} --policy {text} --json --engine {engine}").expect(0).json();
        assert_eq!(report["plan"]["policy_states"], "11");
        let text = std::fs::read_to_string(&text).unwrap();
        assert_eq!(text.matches("If holds: ").count(), 11);
        assert!(text.contains("Execute: drive(station,school) / SC / d=8\n"), "{text}");
        run!("reach {RIVER} --policy {json} --engine {engine}").expect(0);
        let entries: serde_json::Value =
            serde_json::from_str(&std::fs::read_to_string(&json).unwrap()).unwrap();
        assert_eq!(entries.as_array().unwrap().len(), 11);
        assert_eq!(entries[1]["action"], "extinguish(school)");
        assert_eq!(entries[1]["state"][0], "at(school)");
        assert_eq!(entries[1]["distance"], 7);
    }
    // Models of other languages have policies, too, with values in place of facts.
    run!("reach models/drone.prism --target at=1 --policy {json}").expect(0);
    assert!(std::fs::read_to_string(&json).unwrap().contains("\"at=0\""));
    run!("reach {RIVER} --property F(true) --property G(true) --policy -").expect(2);
}

#[test]
fn a_policy_never_replaces_one_of_the_two_files_of_its_problem() {
    let scratch = Scratch::new(&DOORS);
    let (domain, problem) = (scratch.show("d.pddl"), scratch.show("p.pddl"));
    for path in [&domain, &problem] {
        run!("reach {domain} {problem} --policy {path}").ends(2, "is an input of this run");
    }
}

#[test]
fn preferences_of_a_problem_are_objectives_that_a_file_orders() {
    let report = run!("check {HOUSE} models/household.pref --json").expect(0).json();
    let names: Vec<_> = report["objectives"].as_array().unwrap().iter().map(|o| o["name"].clone()).collect();
    assert_eq!(names, ["clean", "fed", "played"]);
    assert_eq!(report["initial"][0]["sasi_rank"], 1);
    let report = run!("check {RIVER} models/responders.pref --json").expect(0).json();
    let names: Vec<_> = report["objectives"].as_array().unwrap().iter().map(|o| o["name"].clone()).collect();
    assert_eq!(names, ["School", "Farm", "goal"]);
    assert_eq!(report["initial"][0]["most_preferred"], json!(["goal"]));
    for engine in ["symbolic", "explicit"] {
        let options = format!("--engine {engine} --scope all --json");
        let report = run!("check {HOUSE} models/household.pref {options}").expect(0).json();
        // Three places, four values for `closed|has|fed`, four Boolean variables.
        assert_eq!(report["counts"]["states"], "192");
    }
}

#[test]
fn the_place_of_a_robot_can_be_given_by_its_name() {
    let scratch = Scratch::new(&DOORS);
    scratch.write("x.pref", "objective A = F hand-free; prefer goal > A;");
    let model = format!("{} {} {}", scratch.show("d.pddl"), scratch.show("p.pddl"), scratch.show("x.pref"));
    let report = run!("strategy {model} --at robot-at=l-2,way(l-1,l-2)=false --json").expect(0).json();
    assert_eq!(report["states"][0]["state"]["robot-at"], "l-2");
    assert_eq!(report["states"][0]["most_preferred"], json!(["goal"]));
}

#[test]
fn dumps_of_planning_problems_are_verified_and_queried() {
    let scratch = Scratch::new(&[]);
    let dump = scratch.show("dump");
    run!("export {HOUSE} models/household.pref --out {dump}").expect(0);
    run!("verify {dump} {HOUSE} models/household.pref").expect(0);
    let mut query = executable();
    query.args(["query", &dump, "almost-sure:fed", "--contains", "at=kitchen,closed|has|fed=has(tin)"]);
    Finished::of(&mut query).expect(0);
}

#[test]
fn numbers_say_that_probabilities_are_assumed() {
    let assumed = run!("reach {RIVER} --property Pmax=?[F\"goal\"]").expect(0);
    assumed.says("equal ones are assumed");
    assert!(!run!("reach {RIVER}").expect(0).stderr.contains("assumed"));
}

#[test]
fn policies_are_verified_state_by_state_and_faults_are_named() {
    let scratch = Scratch::new(&[]);
    for name in ["policy.txt", "policy.json"] {
        let policy = scratch.show(name);
        run!("reach {RIVER} --policy {policy}").expect(0);
        let report = run!("verify {policy} {RIVER} --json").expect(0).json();
        assert_eq!((&report["accepted"], &report["states"]), (&json!(true), &json!("11")));
        assert_eq!(report["longest"], json!(null));
        let strong = run!("verify {policy} {RIVER} --strong --json").expect(1).json();
        assert!(strong["violation"]["condition"].as_str().unwrap().contains("may visit a state again"));
    }
    let text = scratch.read("policy.txt");
    let changed = scratch.show("changed.txt");
    let refused = |text: &str| {
        std::fs::write(&changed, text).unwrap();
        let report = run!("verify {changed} {RIVER} --json").expect(1).json();
        assert_eq!(report["accepted"], false);
        report["violation"]["condition"].as_str().unwrap().to_owned()
    };
    let entries: Vec<&str> = text.trim().split("\n\n").collect();
    assert!(refused(entries[0]).contains("has no action in a state"));
    let other = text.replacen("drive(station,school)", "drive(school,station)", 1);
    assert!(refused(&other).contains("takes `drive(school,station)` in a state where this is not enabled"));
    // A policy that moves between two places without end: its rules come first.
    let there = "If holds: at(station)\nExecute: drive(station,school)\nIf holds: at(school)\nExecute: drive(school,station)\n";
    assert!(refused(there).contains("no path of the policy leads from a state that it visits to the goal"));
    std::fs::write(&changed, "Policy:\nIf holds: at(moon)\nExecute: wait\n").unwrap();
    run!("verify {changed} {RIVER}").ends(3, "changed.txt:2:1").says("`at(moon)` is not a fact");
}

#[test]
fn rules_of_planners_hold_wherever_their_facts_do() {
    let scratch = Scratch::new(&DOORS);
    let doors = format!("{} {}", scratch.show("d.pddl"), scratch.show("p.pddl"));
    let policy = scratch.show("policy.txt");
    let text = "If holds: not(hand-free)\nExecute: Drop / SC / d=3\n
If holds: robot-at(l-1)\nExecute: go( l-1, l-2 ) / SC / d=2\n
If holds: robot-at(l-2)\nExecute: go(l-2,init) / SC / d=1\n";
    std::fs::write(&policy, text).unwrap();
    let report = run!("verify {policy} {doors} --strong --json").expect(0).json();
    // The way behind the robot may be lost in each of its two steps.
    assert_eq!(report["longest"], "3");
    // Models of other languages have values in place of facts.
    run!("reach models/drone.prism --target at=1 --policy {policy}").expect(0);
    run!("verify {policy} models/drone.prism --target at=1").expect(0);
    run!("verify {policy} models/drone.prism").ends(2, "--target");
}

#[test]
fn policies_are_simulated_until_they_reach_the_goal() {
    let scratch = Scratch::new(&[]);
    let policy = scratch.show("policy.txt");
    run!("reach {RIVER} --policy {policy}").expect(0);
    let report = run!("simulate {RIVER} --policy {policy} --runs 50 --json").expect(0).json();
    assert_eq!((&report["runs"]["reached"], &report["runs"]["given_up"]), (&json!(50), &json!(0)));
    assert_eq!(report["runs"]["first"][0]["action"], "drive(station,school)");
    let few = run!("simulate {RIVER} --policy {policy} --runs 50 --steps 2 --json").expect(0).json();
    assert_eq!((&few["runs"]["reached"], &few["runs"]["given_up"]), (&json!(0), &json!(50)));
    std::fs::write(&policy, "If holds: at(station)\nExecute: drive(station,school)\n").unwrap();
    let ends = run!("simulate {RIVER} --policy {policy} --runs 1 --json").expect(1).json();
    assert!(ends["violation"]["condition"].as_str().unwrap().contains("has no action in a state"));
    run!("simulate {RIVER}").expect(2);
}

#[test]
fn strategy_writes_the_policies_of_objectives_with_and_without_preferences() {
    let scratch = Scratch::new(&[]);
    let (one, other) = (scratch.show("one.txt"), scratch.show("other.txt"));
    run!("reach {RIVER} --policy {one}").expect(0);
    run!("strategy {RIVER} --policy {other}").expect(0);
    let read = |name: &str| scratch.read(name);
    assert_eq!(read("one.txt"), read("other.txt"));
    let school =
        format!("strategy {RIVER} models/responders.pref --objective School --policy {other} --json");
    assert_eq!(run(&school).expect(0).json()["plan"]["strong_cyclic"], true);
    run!("verify {other} {RIVER} --target saved(school)").expect(0);
    assert_ne!(read("one.txt"), read("other.txt"));
    let fed = format!("strategy {HOUSE} --objective fed --policy {one}");
    run(&fed).ends(0, "no strong cyclic plan exists");
    let unknown = run!("strategy {RIVER} models/responders.pref --objective No --policy {other}");
    unknown.ends(2, "unknown objective `No`");
}

#[test]
fn pages_name_the_facts_of_planning_problems_as_they_are_written() {
    let page = run!("report {HOUSE} models/household.pref --out -").expect(0).stdout;
    let text = page.replace("<wbr>", "");
    for shown in [
        "<code>at(hall), closed</code>",
        "For not clean(hall), not clean(kitchen), not clean(bath), not played.",
        "<code>at(kitchen)</code>",
        "<code>has(tin)</code>",
    ] {
        assert!(text.contains(shown), "{shown}: {text}");
    }
    assert!(!text.contains("at=hall") && !text.contains("at=kitchen"), "{text}");
}

#[test]
fn states_are_named_by_atoms_with_and_without_the_model() {
    let scratch = Scratch::new(&[]);
    let dump = scratch.show("dump");
    let at = |text: &str| {
        let mut command = executable();
        command.arg("strategy").args(HOUSE.split(' ')).args([
            "models/household.pref",
            "--json",
            "--at",
            text,
        ]);
        Finished::of(&mut command).expect(0).json()["states"].clone()
    };
    assert_eq!(at("at(kitchen)"), at("at=kitchen"));
    assert_eq!(
        at("At( kitchen ),has(tin), clean(hall)"),
        at("at=kitchen,closed|has|fed=has(tin),clean(hall)=true")
    );
    assert_eq!(at("at(kitchen),!clean(hall)"), at("at=kitchen,clean(hall)=false"));
    run!("export {HOUSE} models/household.pref --out {dump}").expect(0);
    run!("verify {dump} {HOUSE} models/household.pref").expect(0);
    let count = |condition: &str| {
        scratch.run(format!("query dump reachable --json --where '{condition}'")).expect(0).json()["count"]
            .clone()
    };
    assert_eq!(count("at(kitchen) & !clean(hall)"), count("at=1 & !clean(hall)"));
    assert_ne!(count("at(kitchen)"), count("true"));
    let mut contains = executable();
    contains.args(["query", &dump, "almost-sure:fed", "--contains", "at(kitchen),has(tin)"]);
    Finished::of(&mut contains).expect(0);
}

#[test]
fn no_plan_is_proved_by_the_dump_of_the_losing_region() {
    let scratch = Scratch::new(&DOORS);
    scratch.write("d.pddl", DOORS[0].1.replace("(robot-at ?y)", ""));
    scratch.write("none.pref", "");
    let inputs = ["d.pddl", "p.pddl", "none.pref"].map(|name| scratch.show(name)).join(" ");
    let dump = scratch.show("dump");
    run!("export {inputs} --out {dump}").expect(0);
    run!("verify {dump} {inputs}")
        .prints(0, "almost-sure:goal                 no wrong states, no missing states");
    let mut query = executable();
    query.args(["query", &dump, "initial & !almost-sure:goal", "--json"]);
    assert_eq!(Finished::of(&mut query).expect(0).json()["count"], "1");
}

/// Two initial states: from one of them the delivery may fail until the road is dry.
const COURIER: &str = "(define (domain courier) (:predicates (at ?x) (wet) (home))
  (:functions (far ?x ?y) - number)
  (:action drive :parameters (?x ?y) :precondition (at ?x) :effect (and (increase (total-cost) (far ?x ?y))
    (when (not (wet)) (and (not (at ?x)) (at ?y)))
    (when (wet) (probabilistic 1/2 (and (not (at ?x)) (at ?y) (decrease (reward) 2))))))
  (:action wait :precondition (wet) :effect (and (probabilistic 1/4 (not (wet))) (decrease (reward) 1))))
(define (problem p) (:domain courier) (:objects a b)
  (:init (at a) (oneof (wet) (and)) (= (far a b) 3) (= (far b a) 3) (= (far a a) 0) (= (far b b) 0))
  (:goal (at b)) (:goal-reward 10) (:metric maximize (reward)))";

#[test]
fn rewards_costs_and_several_initial_states_answer_and_verify() {
    let scratch = Scratch::new(&[("c.pddl", COURIER)]);
    let (file, policy) = (scratch.show("c.pddl"), scratch.show("p.txt"));
    run!("reach {file} --policy {policy}").expect(0);
    run!("verify {policy} {file}").expect(0);
    let ask = |property: &str| {
        scratch.run(format!("reach c.pddl --json --property '{property}'")).expect(0).json()["properties"][0]
            ["value"]
            .clone()
    };
    let close = |value: &serde_json::Value, expected: [f64; 2]| {
        let bounds = [value["lower"].as_f64().unwrap(), value["upper"].as_f64().unwrap()];
        bounds.iter().zip(expected).all(|(x, y)| (x - y).abs() < 1e-6)
    };
    // On a wet road, waiting is free.
    assert!(close(&ask("R{\"cost\"}min=? [ F \"goal\" ]"), [3.0, 3.0]), "{file}");
    assert_eq!(ask("R{\"total-cost\"}min=? [ F \"goal\" ]"), ask("R{\"cost\"}min=? [ F \"goal\" ]"));
    // On a dry road the first step earns 10. On a wet one, driving earns half of it, less one on average.
    assert!(
        close(&ask("R{\"reward\"}max=? [ C<=1 ]"), [4.0, 10.0]),
        "{}",
        ask("R{\"reward\"}max=? [ C<=1 ]")
    );
    assert!(
        close(&ask("R{\"reward\"}max=? [ C<=100 ]"), [6.0, 10.0]),
        "{}",
        ask("R{\"reward\"}max=? [ C<=100 ]")
    );
}
