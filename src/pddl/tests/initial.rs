//! Several initial states, and a first random step.

use super::{loaded, variables};
use meliora_base::value::Value;
use meliora_model::Program;

const DOMAIN: &str = "(define (domain d) (:predicates (at ?x) (wet) (done))
    (:action go :parameters (?x ?y) :precondition (and (at ?x) (not (wet))) :effect (and (not (at ?x)) (at ?y)))
    (:action dry :precondition (wet) :effect (not (wet))))";

fn problem(init: &str) -> String {
    format!("(define (problem p) (:objects a b c) (:init {init}) (:goal (at c)))")
}

/// Returns the initial states as they are shown.
fn starts(program: &Program) -> Vec<String> {
    let mut all = vec![Vec::new()];
    for variable in &program.variables {
        let values = || variable.low..=variable.high;
        all =
            all.iter().flat_map(|state| values().map(move |value| [&state[..], &[value]].concat())).collect();
    }
    all.retain(|state| program.pool.eval(program.initial, state) == Ok(Value::Bool(true)));
    all.iter().map(|state| program.show_state(state)).collect()
}

#[test]
fn alternatives_of_init_are_initial_states_and_keep_invariants() {
    let program = loaded(DOMAIN, &problem("(oneof (at a) (at b)) (oneof (and) (wet))")).unwrap();
    assert_eq!(variables(&program), ["at=a/b/c", "wet"]);
    assert_eq!(starts(&program), ["at=a,wet=false", "at=a,wet=true", "at=b,wet=false", "at=b,wet=true"]);
    assert!(program.variables.iter().all(|variable| variable.initial.is_none()));
    let joined = loaded(DOMAIN, &problem("(and (oneof (at a) (at b)) (and (wet)))")).unwrap();
    assert_eq!(starts(&joined), ["at=a,wet=true", "at=b,wet=true"]);
    // Two places at once are no invariant.
    let program = loaded(DOMAIN, &problem("(oneof (and (at a) (at b)) (at b))")).unwrap();
    assert_eq!(starts(&program).len(), 2);
    assert_eq!(variables(&program), ["at(a)", "at(b)", "at(c)"]);
    // Equal alternatives are one state, nested ones are listed.
    let program =
        loaded(DOMAIN, &problem("(oneof (at a) (oneof (at b) (at a)) (and (at c) (not (wet))))")).unwrap();
    assert_eq!(starts(&program), ["at=a", "at=b", "at=c"]);
}

#[test]
fn a_fact_that_nothing_changes_can_differ_between_initial_states() {
    let domain = "(define (domain d) (:predicates (road ?x) (there))
        (:action go :parameters (?x) :precondition (not (road ?x)) :effect (there)))";
    let problem = "(define (problem p) (:objects a) (:init (oneof (road a) (and))) (:goal (there)))";
    let program = loaded(domain, problem).unwrap();
    assert_eq!(program.actions, ["go(a)"]);
    assert_eq!(starts(&program), ["road(a)=false,there=false", "road(a)=true,there=false"]);
}

#[test]
fn probabilities_in_init_are_a_first_step() {
    let init = "(wet) (probabilistic 1/4 (at a) 1/2 (at c)) (probabilistic 1/3 (done))";
    let program = loaded(DOMAIN, &problem(init)).unwrap();
    let start: Vec<i64> = program.variables.iter().map(|v| v.initial.unwrap()).collect();
    let goal = program.labels.iter().find(|(name, _)| name == "goal").unwrap().1;
    let at_goal = |state: &[i64]| program.pool.eval(goal, state) == Ok(Value::Bool(true));
    let steps = program.exact_steps(&start).unwrap();
    assert_eq!(steps.iter().map(|step| step.name.as_str()).collect::<Vec<_>>(), ["start"]);
    assert_eq!(steps[0].successors.len(), 6);
    let half = steps[0].successors.iter().filter(|(state, _)| at_goal(state)).map(|(_, p)| p);
    assert_eq!(half.sum::<meliora_base::exact::Ratio>().to_string(), "1/2");
    let names = |state: &[i64]| {
        program.exact_steps(state).unwrap().into_iter().map(|step| step.name).collect::<Vec<_>>()
    };
    assert!(steps[0].successors.iter().all(|(state, _)| names(state) == ["dry"]));
}

#[test]
fn a_goal_that_the_facts_before_the_first_step_satisfy_has_not_been_reached() {
    let domain = "(define (domain d) (:predicates (wet) (start)) (:action start :effect (wet)))";
    let problem = "(define (problem p) (:init (probabilistic 0.5 (wet)))
        (:goal (and (not (wet)) (preference calm (not (start))))))";
    let program = loaded(domain, problem).unwrap();
    let start: Vec<i64> = program.variables.iter().map(|v| v.initial.unwrap()).collect();
    for (name, label) in &program.labels {
        assert_eq!(program.pool.eval(*label, &start), Ok(Value::Bool(false)), "{name}");
    }
    assert_eq!(program.actions, ["start", "start_"]);
}
