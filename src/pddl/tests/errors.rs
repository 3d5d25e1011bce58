//! Wrong and unsupported texts: each with its place and its message.

use super::loaded;
use meliora_base::error::{Error, SourceFile};
use meliora_base::exact::{Exact, Ratio, Real};
use meliora_base::progress::NoProgress;
use meliora_model::rewards::RewardItem;

/// Returns the file, line and column of the first error, and its message.
fn first_error(domain: &str, problem: &str) -> String {
    match loaded(domain, problem) {
        Err(Error::Input(all)) => {
            let (line, column) = all[0].position();
            format!("{}:{line}:{column}: {}", all[0].source.name, all[0].message)
        }
        Err(other) => panic!("{other}"),
        Ok(_) => "no error".to_owned(),
    }
}

const PROBLEM: &str = "(define (problem p) (:objects a - t) (:init (p a)) (:goal (p a)))";

fn domain(action: &str) -> String {
    format!("(define (domain d) (:types t) (:predicates (p ?x - t) (q))\n{action})")
}

#[test]
fn mistakes_in_domains_are_shown_at_their_places() {
    for (action, expected) in [
        ("(:action a :precondition (= b a) :effect (q))", "2:29: unknown object `b`"),
        ("(:action a :effect (r))", "2:20: unknown predicate `r`"),
        ("(:action a :effect (q a))", "2:20: `q` has 0 arguments, here are 1"),
        ("(:action a :parameters (?x) :effect (p ?y))", "2:40: unknown variable `?y`"),
        ("(:action a :parameters (?x - u) :effect (p ?x))", "2:30: unknown type `u`"),
        ("(:action a :parameters (x) :effect (q))", "2:25: expected a variable such as `?x`, found `x`"),
        (
            "(:action a :parameters (?x ?x - t) :effect (p ?x))",
            "2:28: the variable `?x` stands twice in this list",
        ),
        ("(:action a :effect (oneof))", "2:20: `oneof` has no outcome"),
        (
            "(:action a :effect (probabilistic 0.6 (q) 0.5 (and)))",
            "2:20: the probabilities sum to 11/10, which is more than 1",
        ),
        (
            "(:action a :effect (oneof (q) (increase (reward) 1)))",
            "2:31: a number that depends on the outcome of `oneof` is not supported",
        ),
        ("(:action a :effect (increase (total-cost) -1))", "2:43: a cost is at least 0"),
        (
            "(:action a :effect (decrease (total-cost) 1))",
            "2:20: numbers that change, such as `(total-cost)`, are not supported",
        ),
        ("(:action a :effect (when (q)))", "2:20: `when` has 2 parts, here are 1"),
        (
            "(:action a :effect (increase (fuel) 1))",
            "2:20: numbers that change, such as `(fuel)`, are not supported",
        ),
        ("(:action a :precondition (> (fuel) 1))", "2:26: numbers in conditions are not supported"),
        (
            "(:action a :precondition (preference x (q)))",
            "2:26: a preference can stand only in the goal, alone or in its outer `and`",
        ),
        ("(:durative-action a)", "2:1: actions with a duration are not supported"),
        ("(:action a :duration (= ?duration 1))", "2:12: actions with a duration are not supported"),
        ("(:constraints (always (q)))", "2:1: `:constraints` on whole paths are not supported"),
        ("(:action a :effect (increase (total-cost) (far)))", "2:43: unknown function `far`"),
        (
            "(:functions (far ?a - t)) (:action a :effect (increase (total-cost) (far)))",
            "2:69: `far` has 1 arguments, here are 0",
        ),
        ("(:action a :effect (r a) )", "2:20: unknown predicate `r`"),
        ("(:fairness :a (x))", "2:1: `:fairness` of some actions is not supported: all outcomes are fair"),
        ("(:actions)", "2:1: unknown section `:actions`"),
        ("(:sensor a)", "2:1: `:sensor` is not supported: all facts are observed"),
        (
            "(:functions (f)) (:action a :effect (probabilistic (f) (q)))",
            "2:52: probabilities that are computed, here by `f`, are not supported",
        ),
        ("(:action a :effect (probabilistic (q) 0.5))", "2:35: expected a number, found `(q …)`"),
        (
            "(:action a :effects (q))",
            "2:12: expected `:parameters`, `:precondition` or `:effect`, found `:effects`",
        ),
        ("(:derived (q) (p a)) (:action a :effect (q))", "2:41: `q` is derived and cannot be changed"),
        ("(:action a :effect (q)", "1:1: this bracket is not closed"),
        ("(:action a :effect (q))) )", "2:26: this bracket closes nothing"),
    ] {
        assert_eq!(first_error(&domain(action), PROBLEM), format!("domain.pddl:{expected}"), "{action}");
    }
}

#[test]
fn mistakes_in_problems_are_shown_at_their_places() {
    for (parts, expected) in [
        ("(:init (= (fuel) 3)) (:goal (q))", "2:11: unknown function `fuel`"),
        (
            "(:init (unknown (q))) (:goal (q))",
            "2:8: incomplete initial states, here by `unknown`, are not supported",
        ),
        (
            "(:init (oneof (q) (or (q) (p a)))) (:goal (q))",
            "2:19: incomplete initial states, here by `or`, are not supported",
        ),
        (
            "(:init (oneof (q) (probabilistic 1/2 (q)))) (:goal (q))",
            "2:19: `probabilistic` cannot stand in a `oneof` of `:init`",
        ),
        (
            "(:hidden (q)) (:goal (q))",
            "2:1: `:hidden` is not supported: all facts of the initial states are known",
        ),
        ("(:init (oneof)) (:goal (q))", "2:8: `oneof` has no alternative"),
        ("(:init)", "2:1: the problem has no goal"),
        ("(:goal (q)) (:goal (q))", "2:13: the problem has two goals"),
        ("(:goal (preference (q)))", "2:8: expected `(preference NAME condition)`, found `(preference …)`"),
        ("(:goal (preference goal (q)))", "2:20: the objective `goal` is declared twice"),
        (
            "(:goal (and (preference pills-ward (q)) (preference Pills-Ward (p a))))",
            "2:53: the objective `Pills-Ward` is declared twice",
        ),
        ("(:goal (sometime (q)))", "2:8: conditions on whole paths, such as `sometime`, are not supported"),
        ("(:goal (q)) (:goal-reward many)", "2:27: expected a number, found `many`"),
        ("(:goal (q)) (:goal-reward 1) (:goal-reward 2)", "2:30: the goal has two rewards"),
    ] {
        let problem = format!("(define (problem p) (:objects a - t)\n{parts})");
        assert_eq!(first_error(&domain(""), &problem), format!("problem.pddl:{expected}"), "{parts}");
    }
}

#[test]
fn a_refused_domain_is_reported_without_its_initial_states() {
    let domain = domain("(:action a :observe (q))");
    let many = "(oneof (q) (p a)) ".repeat(13);
    let problem = format!("(define (problem p) (:objects a - t) (:init (and {many})) (:goal (q)))");
    match loaded(&domain, &problem) {
        Err(Error::Input(all)) => assert_eq!(
            all.iter().map(|wrong| wrong.message.as_str()).collect::<Vec<_>>(),
            ["`:observe` is not supported: all facts are observed"]
        ),
        _ => panic!("an action that observes was read"),
    }
    assert!(
        first_error(&domain.replace(":observe", ":effect"), &problem)
            .contains("more than 4096 initial states")
    );
}

#[test]
fn an_unknown_type_is_reported_once_for_the_objects_of_a_list() {
    let problem = "(define (problem p) (:objects a b c - time d - time) (:goal (q)))";
    match loaded(&domain(""), problem) {
        Err(Error::Input(all)) => {
            let shown: Vec<_> = all.iter().map(|wrong| (wrong.message.as_str(), wrong.position())).collect();
            assert_eq!(shown, [("unknown type `time`", (1, 39)), ("unknown type `time`", (1, 48))]);
        }
        _ => panic!("objects of an unknown type were read"),
    }
}

#[test]
fn an_object_that_only_actions_name_has_the_type_of_its_parameter() {
    let domain = "(define (domain d) (:requirements :strips :typing) (:types room status)
        (:predicates (is ?x - room ?s - status) (seen ?s - status))
        (:action look :parameters (?s - status) :precondition (is hall ?s) :effect (seen ?s))
        (:action wait :parameters () :precondition (is hall open) :effect (is hall Shut)))";
    let problem = "(define (problem p) (:objects hall - room) (:init (is hall open)) (:goal (seen shut)))";
    let sources = [SourceFile::new("d", domain), SourceFile::new("p", problem)];
    let planned = crate::load(&sources, &NoProgress).unwrap();
    assert_eq!(planned.program.actions, ["look(open)", "look(Shut)", "wait"]);
    let notes: Vec<_> =
        planned.warnings.iter().map(|note| (note.message.as_str(), note.position())).collect();
    assert_eq!(notes, [("`open` is not declared (and 1 more)", (4, 61))]);
}

#[test]
fn a_problem_for_another_domain_is_noted_at_the_name() {
    let notes = |domain: &str, problem: &str| {
        let texts = [
            format!("(define (domain {domain}) (:predicates (q)) (:action a :effect (q)))"),
            format!("(define (problem p) (:domain {problem}) (:goal (q)))"),
        ];
        let sources = texts.map(|text| SourceFile::new("f", text));
        let warnings = crate::load(&sources, &NoProgress).unwrap().warnings;
        warnings.iter().map(|note| (note.message.clone(), note.position())).collect::<Vec<_>>()
    };
    let expected = "the problem is for the domain `sea`".to_owned();
    assert_eq!(notes("land", "sea"), [(expected, (1, 30))]);
    assert_eq!(notes("Land", "land"), []);
}

#[test]
fn an_empty_file_and_a_misspelled_part_are_errors_at_their_places() {
    let domain = "(define (domain d) (:predicates (q)))";
    for (problem, expected) in [
        ("", "1:1: the file contains no list"),
        ("; nothing\n", "1:1: the file contains no list"),
        (
            "(define (problm p) (:goal (q)))",
            "1:9: expected `(domain NAME)` or `(problem NAME)`, found `(problm …)`",
        ),
        ("(defin (problem p))", "1:1: expected `(define …)`, found `(defin …)`"),
        ("(define (problem p)\n(:goal (q))", "1:1: this bracket is not closed"),
    ] {
        assert_eq!(first_error(domain, problem), format!("problem.pddl:{expected}"), "{problem}");
    }
    let halves = [domain, "(define (problem p)\n(:goal (q))", "(define (problm p))"].map(crate::parts);
    assert_eq!(halves.map(|p| (p.domain, p.problem)), [(true, false), (false, true), (false, false)]);
}

#[test]
fn a_missing_or_repeated_part_is_named() {
    let missing = first_error("(define (domain d))", "(define (domain d))");
    assert_eq!(missing, "problem.pddl:1:9: this part stands twice");
    let one = SourceFile::new("p.pddl", PROBLEM);
    match crate::load(&[one], &NoProgress) {
        Err(Error::Input(all)) => assert_eq!(all[0].message, "the domain is missing"),
        _ => panic!("a problem alone was read"),
    }
}

#[test]
fn a_derived_fact_that_depends_on_its_negation_is_refused() {
    let wrong = "(define (domain d) (:predicates (p) (q)) (:derived (p) (not (q))) (:derived (q) (p)))";
    let message = first_error(wrong, "(define (problem x) (:goal (p)))");
    assert!(message.ends_with("depends on its own negation"), "{message}");
}

#[test]
fn features_that_are_not_declared_and_weights_are_notes() {
    let domain =
        "(define (domain d) (:requirements :strips) (:predicates (q)) (:action a :effect (oneof (q) (and))))";
    let problem = "(define (problem p) (:goal (preference x (q))) (:metric minimize (* 3 (is-violated x))))";
    let sources = [SourceFile::new("d", domain), SourceFile::new("p", problem)];
    let planned = crate::load(&sources, &NoProgress).unwrap();
    let notes: Vec<&str> = planned.warnings.iter().map(|note| note.message.as_str()).collect();
    assert_eq!(
        notes,
        [
            "the weights of preferences are not used: they are not an order of the objectives",
            "`:requirements` does not declare :preferences, :non-deterministic, which the problem uses",
        ]
    );
}

#[test]
fn an_action_with_too_many_outcomes_is_refused_at_its_place() {
    let domain = "(define (domain d) (:types t) (:predicates (p ?x - t) (q))
        (:action a :effect (forall (?x - t) (oneof (p ?x) (not (p ?x)) (q)))))";
    let objects: String = (0..40).map(|n| format!("o{n} ")).collect();
    let problem = format!("(define (problem p) (:objects {objects} - t) (:goal (q)))");
    match loaded(domain, &problem) {
        Err(Error::Input(all)) => assert_eq!(
            (all[0].message.as_str(), all[0].position()),
            ("`a` has more than 65536 outcomes", (2, 9))
        ),
        _ => panic!("2^40 outcomes were listed"),
    }
}

/// The costs of actions are constants and values of functions that `:init` gives.
#[test]
fn values_of_functions_are_costs() {
    let domain = "(define (domain d) (:types t) (:predicates (at ?x - t)) (:functions (far ?a ?b - t) (old) - number)
        (:action go :parameters (?a ?b - t) :precondition (at ?a)
         :effect (and (not (at ?a)) (at ?b) (increase (total-cost) (far ?a ?b)) (increase (total-cost) 1/2))))";
    let problem = "(define (problem p) (:objects a b - t)
        (:init (at a) (= (far a b) 2) (= (far b a) 3) (= (far a a) 0) (= (far b b) 0) (= (total-cost) 0)) (:goal (at b))
        (:metric minimize (total-time)))";
    let sources = [SourceFile::new("d", domain), SourceFile::new("p", problem)];
    let planned = crate::load(&sources, &NoProgress).unwrap();
    let costs = &planned.program.rewards[0];
    let state = [0];
    let exact = |item: &RewardItem| planned.program.pool.exact(item.value, &state).unwrap();
    let shown: Vec<Exact> = costs.items.iter().map(exact).collect();
    assert_eq!((costs.name.as_deref(), shown.len()), (Some("cost"), 4));
    assert_eq!(planned.program.actions, ["go(a,a)", "go(a,b)", "go(b,a)", "go(b,b)"]);
    let halves = |n: i64| Exact::Real(Real::Finite(Ratio::new(n.into(), 2.into())));
    assert_eq!(shown, [1, 5, 7, 1].map(halves));
    let notes: Vec<_> =
        planned.warnings.iter().map(|note| (note.message.as_str(), note.position())).collect();
    assert_eq!(
        notes,
        [
            ("no cost depends on this function", (1, 85)),
            ("the metric is not used: problems have no time", (3, 28))
        ]
    );
}

#[test]
fn a_cost_without_a_value_is_refused_at_its_action() {
    let domain = domain("(:functions (far ?a - t)) (:action a :effect (increase (total-cost) (far a)))");
    let refused = first_error(&domain, PROBLEM);
    assert_eq!(refused, "domain.pddl problem.pddl:2:27: the amount `far(a)` has no value");
    let negative = PROBLEM.replace("(p a)) (:goal", "(p a) (= (far a) -1)) (:goal");
    assert!(first_error(&domain, &negative).ends_with("the amount `far(a)` is a cost less than 0"));
}

/// Collections write types next to their dash, atoms without brackets, facts about objects that nothing declares, and
/// declarations whose parameters have one name.
#[test]
fn other_forms_have_the_meaning_that_their_authors_give_them() {
    let domain = "(define (domain d) (:types t) (:predicates (at ?x -t) (road ?x ?x -t) (lost) (q))
        (:action go :parameters (?x ?y -t) :precondition (and (at ?x) (road ?x ?y) (not lost))
         :effect (and (at ?y) (probabilistic 1/2 lost))))";
    let problem = "(define (problem p) (:objects a b -t) (:init (at a) (road a b) (road b c) q) (:goal (and (at b) q)))";
    let sources = [SourceFile::new("d", domain), SourceFile::new("p", problem)];
    let planned = crate::load(&sources, &NoProgress).unwrap();
    assert_eq!(planned.program.actions, ["go(a,b)"]);
    let notes: Vec<_> = planned.warnings.iter().map(|note| note.message.as_str()).collect();
    assert!(notes.contains(&"`c` is not declared"), "{notes:?}");
    assert!(notes.contains(&"the parameter `?x` stands twice in this list"), "{notes:?}");
    // An action changes the place, so a name that is not known is a mistake.
    let changed = problem.replace("(at a)", "(at d)");
    assert_eq!(first_error(domain, &changed), "problem.pddl:1:50: unknown object `d`");
}
