//! Quantified conditions of effects, and typed lists.

use super::{loaded, variables};
use meliora_base::error::SourceFile;
use meliora_base::progress::NoProgress;
use meliora_base::value::Value;
use meliora_model::Program;

/// Returns whether an action can make the goal true in the initial state.
fn reaches(program: &Program, action: &str) -> bool {
    let initial: meliora_model::State = program.variables.iter().map(|v| v.initial.unwrap()).collect();
    let (_, goal) = program.labels.iter().find(|(name, _)| name == "goal").unwrap();
    let steps = program.exact_steps(&initial).unwrap();
    let step = steps.iter().find(|step| step.name == action).unwrap_or_else(|| panic!("no {action}"));
    let holds = |next: &[i64]| program.pool.eval(*goal, next) == Ok(Value::Bool(true));
    step.successors.iter().any(|(next, _)| holds(next))
}

/// Returns a problem with one action `a` over a spot, for its effect and its goal; `s1` is lit.
fn one_action(effect: &str, goal: &str) -> Program {
    let domain = format!(
        "(define (domain d) (:types spot bot) (:predicates (lit ?x - spot) (on ?x - spot))
        (:action a :parameters (?v - spot) :effect {effect}))"
    );
    let problem =
        format!("(define (problem p) (:objects s1 s2 - spot b1 - bot) (:init (lit s1)) (:goal {goal}))");
    loaded(&domain, &problem).unwrap()
}

#[test]
fn quantified_conditions_around_alternatives_are_those_of_the_quantified_variables() {
    let some = "(when (exists (?w - bot ?q - spot) (lit ?q)) (probabilistic 1/2 (on ?v)))";
    assert!(reaches(&one_action(some, "(on s2)"), "a(s2)"));
    // The inner variable is not the one that the atom names.
    let all = "(when (forall (?q - spot) (exists (?w - spot) (lit ?q))) (probabilistic 1/2 (on ?v)))";
    assert!(!reaches(&one_action(all, "(on s2)"), "a(s2)"));
    let some = "(when (exists (?q - spot) (and (lit ?q) (not (= ?q ?v)))) (oneof (on ?v) (and)))";
    assert!(reaches(&one_action(some, "(on s2)"), "a(s2)"));
    // `s1` itself is the only one that is lit: nothing is ever on, so that nothing depends on the action.
    assert!(!reaches(&one_action(some, "(on s1)"), "a(s1)"));
}

#[test]
fn quantified_conditions_inside_of_quantified_effects_do_not_panic() {
    let when = "(when (exists (?q - spot) (lit ?q)) (on ?e))";
    for effect in [
        format!("(forall (?e - spot) (probabilistic 1/2 {when}))"),
        format!("(forall (?e - spot) (oneof (and) {when}))"),
        format!("(probabilistic 1/2 (forall (?e - spot) {when}))"),
        format!("(and (forall (?e - spot) (not (on ?e))) (oneof (forall (?e - spot) {when}) (and)))"),
    ] {
        assert!(reaches(&one_action(&effect, "(and (on s1) (on s2))"), "a(s1)"), "{effect}");
    }
}

#[test]
fn variables_of_a_condition_are_not_those_of_a_quantified_effect_inside() {
    let effect = "(when (exists (?q - spot) (lit ?q)) (forall (?e - spot) (on ?e)))";
    assert!(reaches(&one_action(effect, "(forall (?e - spot) (on ?e))"), "a(s1)"));
}

#[test]
fn equal_outcomes_count_once_whatever_the_depth_of_their_quantifiers() {
    let when = "(when (exists (?q - spot) (on ?q)) (lit ?v))";
    let effect = format!("(oneof (forall (?e - bot) {when}) {when} (on s2))");
    let program = one_action(&effect, "(on s2)");
    let command = &program.commands[0];
    assert_eq!(command.branches.len(), 2);
}

#[test]
fn the_types_in_the_head_of_a_rule_are_not_objects() {
    let domain = |head: &str| {
        format!(
            "(define (domain d) (:types spot bot) (:predicates (lit ?s - spot) (both ?x ?y))
            (:derived (both {head}) (and (lit ?x) (lit ?y)))
            (:action light :parameters (?s - spot) :effect (lit ?s)))"
        )
    };
    let problem = "(define (problem p) (:objects s1 s2 - spot) (:init) (:goal (forall (?s) (lit ?s))))";
    for head in ["?x - spot ?y - spot", "?x ?y - (either spot bot)", "?x - (either bot spot) ?y - spot"] {
        let sources = [SourceFile::new("d", domain(head)), SourceFile::new("p", problem)];
        let planned = crate::load(&sources, &NoProgress).unwrap();
        let parameters = &planned.program.planning.as_ref().unwrap().predicates["both"];
        assert_eq!(parameters[0], ["s1", "s2"], "{head}");
        assert_eq!(variables(&planned.program), ["lit(s1)", "lit(s2)"]);
        assert!(planned.warnings.iter().all(|note| !note.message.contains("is not declared")), "{head}");
    }
}

#[test]
fn an_action_may_have_the_name_of_a_predicate() {
    let domain = "(define (domain d) (:types spot) (:predicates (near ?x ?y - spot) (lit ?x - spot))
        (:action near :parameters (?x - spot) :effect (forall (?y - spot) (lit ?y))))";
    let problem = "(define (problem p) (:objects s1 - spot) (:init) (:goal (lit s1)))";
    assert_eq!(variables(&loaded(domain, problem).unwrap()), ["lit(s1)"]);
}
