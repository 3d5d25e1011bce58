//! Tests of reading, grounding and invariants.

mod agreement;
mod drawn;
mod drawn_conditions;
mod errors;
mod initial;
mod measures;
mod quantified;

use meliora_base::error::{Result, SourceFile};
use meliora_base::progress::NoProgress;
use meliora_model::Program;

fn loaded(domain: &str, problem: &str) -> Result<Program> {
    let sources = [SourceFile::new("domain.pddl", domain), SourceFile::new("problem.pddl", problem)];
    crate::load(&sources, &NoProgress).map(|planned| planned.program)
}

/// Returns the variables with their values: `at(r)=a|b`, or the name of a Boolean one.
fn variables(program: &Program) -> Vec<String> {
    let one = |v: &meliora_model::Variable| match v.values.is_empty() {
        true => v.name.clone(),
        false => format!("{}={}", v.name, v.values.join("/")),
    };
    program.variables.iter().map(one).collect()
}

const ROBOTS: &str = "(define (domain robots)
  (:requirements :typing :non-deterministic)
  (:types robot room box)
  (:predicates (at ?r - robot ?x - room) (in ?b - box ?x - room) (held ?b - box ?r - robot) (free ?r - robot)
    (door ?x ?y - room))
  (:action move :parameters (?r - robot ?x ?y - room) :precondition (and (at ?r ?x) (door ?x ?y))
    :effect (and (not (at ?r ?x)) (at ?r ?y)))
  (:action grasp :parameters (?r - robot ?b - box ?x - room)
    :precondition (and (at ?r ?x) (in ?b ?x) (free ?r))
    :effect (oneof (and) (and (not (in ?b ?x)) (held ?b ?r) (not (free ?r)))))
  (:action put :parameters (?r - robot ?b - box ?x - room) :precondition (and (at ?r ?x) (held ?b ?r))
    :effect (and (in ?b ?x) (not (held ?b ?r)) (free ?r))))";

const HOUSE: &str = "(define (problem house) (:domain robots)
  (:objects Ann - robot hall attic cellar - room toys - box)
  (:init (at Ann hall) (in toys attic) (free Ann) (door hall attic) (door attic hall))
  (:goal (in toys hall)))";

#[test]
fn places_of_a_robot_and_of_a_box_are_one_variable_each() {
    let program = loaded(ROBOTS, HOUSE).unwrap();
    // The cellar has no door, so no fact about it is reachable.
    let expected =
        ["at(Ann)=hall/attic", "in|held(toys)=in(toys,attic)/in(toys,hall)/held(toys,Ann)", "free(Ann)"];
    assert_eq!(variables(&program), expected);
    let actions = [
        "move(Ann,hall,attic)",
        "move(Ann,attic,hall)",
        "grasp(Ann,toys,hall)",
        "grasp(Ann,toys,attic)",
        "put(Ann,toys,hall)",
        "put(Ann,toys,attic)",
    ];
    let mut sorted = program.actions.clone();
    sorted.sort();
    let mut expected = actions.map(str::to_owned).to_vec();
    expected.sort();
    assert_eq!(sorted, expected);
    let state: Vec<i64> = program.variables.iter().map(|v| v.initial.unwrap()).collect();
    assert_eq!(program.show_state(&state), "at(Ann)=hall,in|held(toys)=\"in(toys,attic)\",free(Ann)=true");
}

#[test]
fn one_file_with_both_parts_in_any_order_is_the_same_problem() {
    let two = loaded(ROBOTS, HOUSE).unwrap();
    let one = SourceFile::new("both.pddl", format!("; a comment\n{HOUSE}\n{ROBOTS}"));
    let one = crate::load(&[one], &NoProgress).unwrap().program;
    assert_eq!(one.actions, two.actions);
    assert_eq!(variables(&one), variables(&two));
    assert!(crate::is_pddl("\u{20}; x\n ( Define (domain d))") && !crate::is_pddl("mdp module m endmodule"));
    let halves = [ROBOTS, HOUSE, "mdp"].map(crate::parts);
    assert_eq!(halves.map(|p| (p.domain, p.problem)), [(true, false), (false, true), (false, false)]);
}

#[test]
fn a_variable_has_a_value_for_none_of_its_facts_only_where_a_fact_can_be_lost() {
    let domain = |more: &str| {
        format!(
            "(define (domain d) (:predicates (at ?x)) (:action go :parameters (?x ?y) :precondition (at ?x)
            :effect (and (not (at ?x)) (at ?y))) {more})"
        )
    };
    let problem = "(define (problem p) (:objects a b) (:init (at a)) (:goal (at b)))";
    assert_eq!(variables(&loaded(&domain(""), problem).unwrap()), ["at=a/b"]);
    let lost = domain("(:action drop :parameters (?x) :precondition (at ?x) :effect (not (at ?x)))");
    assert_eq!(variables(&loaded(&lost, problem).unwrap()), ["at=a/b/none"]);
}

#[test]
fn costs_are_a_reward_structure() {
    let domain = "(define (domain d) (:requirements :action-costs) (:predicates (p)) (:functions (total-cost) - number)
        (:action do :effect (and (p) (increase (total-cost) 2.5))) (:action wait :effect (and)))";
    let problem =
        "(define (problem q) (:init (= (total-cost) 0)) (:goal (p)) (:metric minimize (total-cost)))";
    let program = loaded(domain, problem).unwrap();
    assert_eq!(program.rewards[0].name.as_deref(), Some("cost"));
    assert_eq!(["cost", "total-cost"].map(|name| program.reward_structure(Some(name))), [Some(0); 2]);
    let item = &program.rewards[0].items[0];
    assert_eq!(program.pool.eval(item.value, &[0]), Ok(meliora_base::value::Value::Real(2.5)));
    assert_eq!(program.rewards[0].items.len(), 1);
}

#[test]
fn derived_facts_that_depend_on_each_other_are_the_least_solution() {
    let domain = "(define (domain d) (:predicates (on ?x ?y) (above ?x ?y))
        (:derived (above ?x ?y) (or (on ?x ?y) (exists (?z) (and (on ?x ?z) (above ?z ?y)))))
        (:action cut :parameters (?x ?y) :precondition (on ?x ?y) :effect (not (on ?x ?y))))";
    let problem = "(define (problem p) (:objects a b c d) (:init (on a b) (on b c) (on c d) (on d a))
        (:goal (not (above a d))))";
    let program = loaded(domain, problem).unwrap();
    let goal = program.labels.iter().find(|(name, _)| name == "goal").unwrap().1;
    let at = |text: &str| {
        let planning = program.planning.as_ref().unwrap();
        planning.facts.iter().find(|f| f.name == text).map(|f| (f.variable.index(), f.value)).unwrap()
    };
    let mut state: Vec<i64> = program.variables.iter().map(|v| v.initial.unwrap()).collect();
    let eval = |state: &[i64]| program.pool.eval(goal, state);
    assert_eq!(eval(&state), Ok(meliora_base::value::Value::Bool(false)));
    // Without `on(b,c)` only `c` is above `d`, and the blocks above `c` are not.
    let (variable, value) = at("on(b,c)");
    assert_eq!((program.variables[variable].values.is_empty(), value), (true, 1));
    state[variable] = 0;
    assert_eq!(eval(&state), Ok(meliora_base::value::Value::Bool(true)));
}

#[test]
fn facts_on_which_no_goal_depends_are_left_out_if_only_goals_are_asked_about() {
    let domain = "(define (domain d) (:predicates (at ?x) (seen ?x) (lit) (tired))
        (:action go :parameters (?x ?y) :precondition (at ?x)
          :effect (and (not (at ?x)) (at ?y) (seen ?x) (when (lit) (tired))))
        (:action light :effect (lit)) (:action rest :precondition (tired) :effect (not (tired))))";
    let problem = "(define (problem p) (:objects a b) (:init (at a)) (:goal (at b)))";
    let sources = [SourceFile::new("d", domain), SourceFile::new("p", problem)];
    let all = crate::load(&sources, &NoProgress).unwrap().program;
    let goals = crate::load_for_goals(&sources, &NoProgress).unwrap().program;
    assert_eq!(variables(&all).len(), 5);
    assert_eq!(variables(&goals), ["at=a/b"]);
    assert_eq!(goals.actions, ["go(a,a)", "go(a,b)", "go(b,a)", "go(b,b)"]);
}
