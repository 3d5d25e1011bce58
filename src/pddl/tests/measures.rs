//! Rewards and costs of actions, and the reward of the goal.

use super::loaded;
use meliora_base::exact::Ratio;
use meliora_model::Program;
use meliora_model::step::{Choice, Step};

/// Returns what each choice of a state adds to a measure, by the name of the action.
fn earned(program: &Program, measure: &str, state: &[i64]) -> Vec<(String, Ratio)> {
    let structure = &program.rewards[program.reward_structure(Some(measure)).unwrap()];
    let of = |step: Step<Ratio>| match step.choice {
        Choice::Combination { synchronisation, commands } => {
            let one = [(synchronisation, commands)];
            Some((step.name, program.signed_reward_of(structure, state, &one).unwrap()))
        }
        _ => None,
    };
    program.exact_steps(state).unwrap().into_iter().filter_map(of).collect()
}

fn initial(program: &Program) -> Vec<i64> {
    program.variables.iter().map(|v| v.initial.unwrap()).collect()
}

fn fraction(above: i64, below: i64) -> Ratio {
    Ratio::new(above.into(), below.into())
}

#[test]
fn amounts_under_conditions_and_probabilities_are_averages() {
    let domain = "(define (domain d) (:requirements :mdp) (:predicates (on ?x) (lit)) (:functions (worth ?x) - number)
        (:action look :effect (and
          (forall (?x) (when (on ?x) (increase (reward) (worth ?x))))
          (probabilistic 1/4 (and (lit) (increase (reward) 8) (decrease (reward) (worth a))) 1/2 (increase (total-cost) 3)))))";
    let problem = "(define (problem p) (:objects a b c) (:init (on a) (on c) (= (worth a) 2) (= (worth b) 5) (= (worth c) 1/2)
        (= (reward) 0)) (:goal (lit)) (:metric maximize (reward)))";
    let program = loaded(domain, problem).unwrap();
    let state = initial(&program);
    // 2 and 1/2 for `a` and `c`, and a quarter of 8 - 2.
    assert_eq!(earned(&program, "reward", &state), [("look".to_owned(), fraction(4, 1))]);
    assert_eq!(earned(&program, "cost", &state), [("look".to_owned(), fraction(3, 2))]);
}

#[test]
fn the_reward_of_the_goal_is_earned_by_the_first_step_into_it() {
    let domain = "(define (domain d) (:predicates (g) (h) (both)) (:derived (both) (and (g) (h)))
        (:action try :effect (and (probabilistic 1/2 (g) 1/4 (h)) (decrease (reward) 1)))
        (:action undo :precondition (g) :effect (not (g))))";
    let problem = |init: &str, goal: &str| {
        format!(
            "(define (problem p) (:init {init}) (:goal {goal}) (:goal-reward 10) (:metric maximize (reward)))"
        )
    };
    let of = |program: &Program, state: &[i64]| {
        earned(program, "reward", state).into_iter().map(|(_, x)| x).collect::<Vec<_>>()
    };
    let program = loaded(domain, &problem("", "(g)")).unwrap();
    let mut state = initial(&program);
    assert_eq!(of(&program, &state), [fraction(4, 1)]);
    // The reward is not earned again after the goal has been left.
    let steps = program.exact_steps(&state).unwrap();
    let remembers = program.variables.iter().position(|v| v.name == "goal-reward").unwrap();
    let g = program.variables.iter().position(|v| v.name == "g").unwrap();
    assert!(steps[0].successors.iter().all(|(next, _)| next[remembers] == next[g]));
    state[remembers] = 1;
    assert_eq!(of(&program, &state), [fraction(-1, 1)]);
    // Where the goal holds initially, the first step earns it.
    let program = loaded(domain, &problem("(g)", "(g)")).unwrap();
    assert_eq!(of(&program, &initial(&program)), [fraction(9, 1), fraction(10, 1)]);
    let program = loaded(domain, &problem("(g)", "(both)")).unwrap();
    assert_eq!(of(&program, &initial(&program)), [fraction(3, 2), fraction(0, 1)]);
}

#[test]
fn a_question_about_goals_does_not_need_the_reward_of_the_goal() {
    let domain =
        "(define (domain d) (:predicates (g)) (:action try :effect (and (g) (decrease (reward) 1))))";
    let problem = "(define (problem p) (:init) (:goal (g)) (:goal-reward 10))";
    let sources = [domain, problem].map(|text| meliora_base::error::SourceFile::new("p", text));
    let planned = crate::load_for_goals(&sources, &meliora_base::progress::NoProgress).unwrap();
    assert_eq!((planned.program.variables.len(), planned.program.rewards.len()), (1, 0));
}

#[test]
fn parts_whose_static_condition_fails_do_not_multiply_outcomes() {
    let domain = "(define (domain d) (:predicates (at ?x) (slip ?x ?y))
        (:action drive :parameters (?x ?y) :precondition (at ?x) :effect (and (not (at ?x))
          (forall (?w) (when (slip ?x ?w) (probabilistic 3/4 (at ?y) 1/4 (at ?w)))))))";
    let names: String = (0..40).map(|i| format!(" c{i}")).collect();
    let slips: String = (0..39).map(|i| format!("(slip c{} c{i})", i + 1)).collect();
    let problem = format!("(define (problem p) (:objects{names}) (:init (at c1) {slips}) (:goal (at c39)))");
    let program = loaded(domain, &problem).unwrap();
    let steps = program.exact_steps(&initial(&program)).unwrap();
    assert!(steps.iter().all(|step| step.successors.len() <= 2));
}

#[test]
fn a_problem_of_rewards_alone_has_no_goal() {
    let domain =
        "(define (domain d) (:predicates (g)) (:action try :effect (and (g) (increase (reward) 1))))";
    let program = loaded(domain, "(define (problem p) (:init) (:metric maximize (reward)))").unwrap();
    assert_eq!(earned(&program, "reward", &initial(&program)), [("try".to_owned(), fraction(1, 1))]);
    assert!(program.labels.is_empty() && !program.planning.unwrap().has_goal());
}
