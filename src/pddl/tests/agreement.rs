//! Drawn tasks: the program has the states, the choices and the probabilities of the definitions.

use std::collections::{BTreeMap, BTreeSet};

use meliora_base::exact::Ratio;
use meliora_base::value::Value;
use meliora_model::planning::Named;
use meliora_model::{Program, State as Values};
use proptest::prelude::*;

use super::drawn::{Drawn, State, Tape};
use super::loaded;

/// Maximum number of states that are compared in one task.
const MOST_STATES: usize = 300;

/// Returns the names of the atoms that hold in a state of the program.
fn atoms(program: &Program, values: &[i64]) -> BTreeSet<String> {
    let planning = program.planning.as_ref().unwrap();
    let holds = |(_, id): &(&String, &meliora_model::expr::ExprId)| {
        program.pool.eval(**id, values) == Ok(Value::Bool(true))
    };
    planning.atoms.iter().filter(holds).map(|(name, _)| name.clone()).collect()
}

/// Returns the names of atoms as the program writes them.
fn shown<'s>(states: impl IntoIterator<Item = &'s State>) -> BTreeSet<String> {
    let name = |(name, objects): &(&str, Vec<usize>)| {
        let shown: Vec<&str> = objects.iter().map(|&o| ["a", "b", "c"][o]).collect();
        if shown.is_empty() { (*name).to_owned() } else { format!("{name}({})", shown.join(",")) }
    };
    states.into_iter().flatten().map(name).collect()
}

fn holds(program: &Program, label: &str, values: &[i64]) -> bool {
    let (_, id) = program.labels.iter().find(|(name, _)| name == label).unwrap();
    program.pool.eval(*id, values) == Ok(Value::Bool(true))
}

fn compare(drawn: &Drawn) {
    let texts = drawn.texts();
    let program = loaded(&texts[0], &texts[1]).unwrap_or_else(|e| panic!("{e}\n{}\n{}", texts[0], texts[1]));
    let initial: Values = program.variables.iter().map(|v| v.initial.unwrap()).collect();
    let mut known: BTreeMap<State, Values> = [(drawn.initial().clone(), initial.clone())].into();
    let mut open = vec![(drawn.initial().clone(), initial)];
    while let Some((state, values)) = open.pop() {
        let context = || format!("{}\n{}\nin {state:?}", texts[0], texts[1]);
        assert_eq!(atoms(&program, &values), shown([&state, &drawn.derived(&state)]), "{}", context());
        let goals = ["goal", "wish"].map(|label| holds(&program, label, &values));
        assert_eq!(goals, drawn.goals(&state), "{}", context());
        let expected = drawn.steps(&state);
        let steps = program.exact_steps(&values).unwrap();
        let names: BTreeSet<&str> =
            steps.iter().map(|step| step.name.as_str()).filter(|n| *n != "deadlock").collect();
        assert_eq!(names, expected.keys().map(String::as_str).collect(), "{}", context());
        for step in steps.iter().filter(|step| step.name != "deadlock") {
            let mut found: BTreeMap<BTreeSet<String>, (Ratio, &Values)> = BTreeMap::new();
            for (next, probability) in &step.successors {
                let twice = found.insert(facts(&program, next), (probability.clone(), next));
                assert!(twice.is_none(), "{} {}", step.name, context());
            }
            let (successors, reward) = &expected[&step.name];
            if let Some(structure) = program.reward_structure(Some("reward")) {
                let earned = program.reward(&program.rewards[structure], &values, &step.choice).unwrap();
                assert_eq!(earned, *reward, "{} {}", step.name, context());
            }
            for (next, probability) in successors {
                let derived = State::new();
                let (p, values) = found
                    .remove(&shown([next, &derived]))
                    .unwrap_or_else(|| panic!("{} does not lead to {next:?}: {}", step.name, context()));
                assert_eq!(p, *probability, "{} {}", step.name, context());
                if known.len() < MOST_STATES && !known.contains_key(next) {
                    known.insert(next.clone(), values.clone());
                    open.push((next.clone(), values.clone()));
                }
            }
            assert!(found.is_empty(), "{} leads further: {}", step.name, context());
        }
    }
}

/// Returns the atoms that hold, without derived ones.
fn facts(program: &Program, values: &[i64]) -> BTreeSet<String> {
    atoms(program, values).into_iter().filter(|name| !name.starts_with("linked")).collect()
}

proptest! {
    #![proptest_config(meliora_amount::random(1000))]

    #[test]
    fn programs_have_the_states_and_steps_of_the_definitions(bytes in prop::collection::vec(any::<u8>(), 0..120)) {
        compare(&Drawn::new(&mut Tape(bytes.iter())));
    }
}

#[test]
fn atoms_that_never_hold_are_known_by_name() {
    let domain = "(define (domain d) (:types t) (:predicates (at ?x - t) (near ?x ?y - t)))";
    let problem = "(define (problem p) (:objects A b - t) (:init (near A b)) (:goal (at b)))";
    let program = loaded(domain, problem).unwrap();
    let planning = program.planning.as_ref().unwrap();
    assert!(matches!(planning.named("near( a, B )"), Some(Named::Atom(_))));
    assert_eq!(planning.named("at(b)"), Some(Named::Never));
    assert_eq!(["at(c)", "at", "far(b)", "near(a)"].map(|name| planning.named(name)), [None; 4]);
}
