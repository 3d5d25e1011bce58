//! Planning problems: preferences of PDDL 3, names, and files with mistakes.

use crate::cli::common::Scratch;

const ENDS: &str = "(define (domain d) (:requirements :strips :preferences :negative-preconditions)
  (:predicates (s) (g) (p) (q))
  (:action a :parameters () :precondition (s) :effect (and (not (s)) (p)))
  (:action b :parameters () :precondition (s) :effect (and (not (s)) (g) (q))))
(define (problem x) (:domain d) (:init (s))
  (:goal (and (g) (preference prefp (p)) (preference clean (not (q))))))";

const HOSPITAL: &str = "(define (domain hospital) (:predicates (at ?p) (item-at ?i ?p))
  (:action bring :parameters (?i ?from ?to) :precondition (item-at ?i ?from)
    :effect (oneof (and) (and (not (item-at ?i ?from)) (item-at ?i ?to)))))";

const SHIFT: &str = "(define (problem shift) (:domain hospital) (:objects dock icu-1 - object pills - object)
  (:init (item-at pills dock))
  (:goal (and (item-at pills icu-1) (preference pills-Ward (item-at pills dock)) (preference Home (at dock)))))";

/// A preference counted as achieved at step 0, or in a state from which the goal was lost.
#[test]
fn preferences_are_judged_where_a_plan_ends() {
    let scratch =
        Scratch::new(&[("ends.pddl", ENDS), ("ends.pref", "prefer prefp > goal; prefer clean > goal;")]);
    let [model, wishes] = ["ends.pddl", "ends.pref"].map(|name| scratch.show(name));
    for history in ["", "history = play;"] {
        let text = format!("prefer prefp > goal; prefer clean > goal; {history}");
        scratch.write("ends.pref", text);
        let report = run!("check {model} {wishes} --json").expect(0).json();
        let initial = &report["initial"][0];
        assert_eq!(initial["sure"], serde_json::json!(["goal"]), "{history} {report}");
        assert_eq!(initial["possible"], serde_json::json!(["goal"]), "{history}");
    }
    // Without a hard goal, a plan may end anywhere.
    let soft = ENDS.replace("(and (g) ", "(and ");
    scratch.write("ends.pddl", soft);
    scratch.write("ends.pref", "prefer prefp > clean;");
    let report = run!("check {model} {wishes} --json").expect(0).json();
    assert_eq!(report["initial"][0]["sure"], serde_json::json!(["prefp", "clean"]), "{report}");
}

#[test]
fn names_of_preferences_with_hyphens_and_capitals_are_found_in_preference_files() {
    let wishes = "objective X-1 = F item-at(PILLS,icu-1); prefer pills-ward > GOAL; prefer x-1 > home;";
    let scratch = Scratch::new(&[("d.pddl", HOSPITAL), ("p.pddl", SHIFT), ("w.pref", wishes)]);
    let [domain, problem, wishes, dump] =
        ["d.pddl", "p.pddl", "w.pref", "dump"].map(|name| scratch.show(name));
    for history in ["", "history = play;"] {
        let text = scratch.read("w.pref") + history;
        scratch.write("w.pref", text);
        let report = run!("check {domain} {problem} {wishes} --json").expect(0).json();
        let names: Vec<&str> =
            report["objectives"].as_array().unwrap().iter().map(|o| o["name"].as_str().unwrap()).collect();
        assert_eq!(names, ["X-1", "goal", "pills-Ward", "Home"]);
        run!("export {domain} {problem} {wishes} --out {dump} -q").expect(0);
        run!("verify {dump} {domain} {problem} {wishes}").expect(0);
        let found = run!("query {dump} almost-sure:X-1 --count").expect(0).stdout;
        assert!(found.trim().parse::<u32>().unwrap() > 0, "{found}");
    }
    let wrong = "prefer pills-war > goal;";
    scratch.write("w.pref", wrong);
    run!("check {domain} {problem} {wishes}").ends(3, "unknown objective `pills-war`").says("`pills-Ward`");
}

/// Each was an \"unexpected argument\".
#[test]
fn mistakes_in_one_of_two_files_have_their_places() {
    let scratch = Scratch::new(&[("d.pddl", HOSPITAL), ("p.pddl", SHIFT), ("open.pddl", "")]);
    let [domain, problem, broken] = ["d.pddl", "p.pddl", "open.pddl"].map(|name| scratch.show(name));
    for (text, place, message) in [
        (SHIFT.strip_suffix(')').unwrap(), ":1:1", "this bracket is not closed"),
        ("", ":1:1", "the file contains no list"),
        ("(define (problm x))", ":1:9", "expected `(domain NAME)` or `(problem NAME)`"),
        ("(defin (problem x))", ":1:1", "expected `(define …)`"),
    ] {
        scratch.write("open.pddl", text);
        for files in [format!("{domain} {broken}"), format!("{broken} {domain}")] {
            run!("reach {files}").ends(3, message).says(format!("{broken}{place}"));
        }
    }
    scratch.write("open.pddl", "(define (domian x))");
    run!("reach {broken} {problem}").ends(3, "found `(domian …)`");
    let missing = scratch.show("nowhere.pddl");
    let error = run!("reach {missing} {problem}").expect(3).stderr;
    assert!(error.contains("nowhere.pddl") && !error.contains("unexpected"), "{error}");
}

#[test]
fn a_problem_for_another_domain_is_warned_about() {
    let other = SHIFT.replace("(:domain hospital)", "(:domain harbour)");
    let scratch = Scratch::new(&[("d.pddl", HOSPITAL), ("p.pddl", &other)]);
    let [domain, problem] = ["d.pddl", "p.pddl"].map(|name| scratch.show(name));
    run!("reach {domain} {problem}").ends(0, "the problem is for the domain `harbour`");
}
