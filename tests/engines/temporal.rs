//! Regions of temporal formulas in both engines, against end components enumerated one by one.

use meliora::advanced::lang::ltl::{Monitoring, parse_formula};
use meliora::model::temporal::{Asks, Begin, Condition};
use meliora::planning::temporal::judged;
use proptest::prelude::*;

use crate::common::brute::Set;
use crate::common::prelude::*;
use crate::engines::lasso::watched;

/// Subsets of more states are not enumerated.
const MOST_STATES: usize = 11;

/// A formula over the labels "p" and "q", all operands in brackets.
fn formula() -> impl Strategy<Value = String> {
    let atom = prop_oneof![Just("\"p\"".to_owned()), Just("\"q\"".to_owned()), Just("(!\"p\")".to_owned())];
    atom.prop_recursive(4, 8, 2, |inner| {
        let two = || (inner.clone(), inner.clone());
        prop_oneof![
            inner.clone().prop_map(|a| format!("(F {a})")),
            inner.clone().prop_map(|a| format!("(G {a})")),
            inner.clone().prop_map(|a| format!("(G (F {a}))")),
            inner.clone().prop_map(|a| format!("(F (G {a}))")),
            inner.clone().prop_map(|a| format!("(X {a})")),
            inner.clone().prop_map(|a| format!("(F<=2 {a})")),
            two().prop_map(|(a, b)| format!("({a} U {b})")),
            two().prop_map(|(a, b)| format!("({a} W {b})")),
            two().prop_map(|(a, b)| format!("({a} M {b})")),
            two().prop_map(|(a, b)| format!("({a} & {b})")),
            two().prop_map(|(a, b)| format!("({a} | {b})")),
            two().prop_map(|(a, b)| format!("({a} => {b})")),
        ]
    })
}

/// Returns true if the paths that visit exactly the states of a set infinitely often satisfy a condition.
fn holds(condition: &Condition, marked: &dyn Fn(&Predicate) -> Set, within: &Set) -> bool {
    match condition {
        Condition::Constant(value) => *value,
        Condition::Leaf(Asks::Accept | Asks::Again, mark) => !marked(mark).is_disjoint(within),
        Condition::Leaf(_, mark) => marked(mark).is_disjoint(within),
        Condition::All(parts) => parts.iter().all(|p| holds(p, marked, within)),
        Condition::Any(parts) => parts.iter().any(|p| holds(p, marked, within)),
    }
}

/// Returns true if paths can stay in a set and visit all of it infinitely often, almost surely.
fn is_end_component(brute: &Brute, set: &Set) -> bool {
    let staying = brute.choices_in(&brute.pre_within(&brute.all_choices(), set), set);
    set.iter().all(|&state| {
        let mut met = Set::from([state]);
        loop {
            let next = &met | &brute.post(&brute.choices_in(&staying, &met));
            if next == met {
                return met == *set && !brute.choices_in(&staying, &Set::from([state])).is_empty();
            }
            met = next;
        }
    })
}

/// Pmax = 1, Pmax > 0, Pmin = 1, Pmin > 0, from what all end components satisfy.
fn enumerated(brute: &Brute, program: &Program, condition: &Condition) -> [Set; 4] {
    let marked = |mark: &Predicate| brute.states_where(program, mark.id());
    let (mut good, mut bad) = (Set::new(), Set::new());
    for code in 1u32..1 << brute.states.len() {
        let set: Set = brute.all_states().into_iter().filter(|s| code >> s & 1 == 1).collect();
        if is_end_component(brute, &set) {
            let into = if holds(condition, &marked, &set) { &mut good } else { &mut bad };
            into.extend(set);
        }
    }
    let (all, choices) = (brute.all_states(), brute.all_choices());
    let surely = |target: &Set| brute.almost_surely_reach(target, &choices).0;
    let possibly = |target: &Set| brute.can_reach(target, &choices, &[]);
    [surely(&good), possibly(&good), &all - &possibly(&bad), &all - &surely(&bad)]
}

struct Case {
    program: Program,
    condition: Condition,
}

/// A random program with the monitors of a formula; none where the formula exceeds a limit.
fn case(numbers: &[u16], predicates: &[Vec<u16>; 2], formula: &str, begin: Begin) -> Option<Case> {
    let mut program = random_program(numbers, false);
    for (name, predicate) in ["p", "q"].into_iter().zip(predicates) {
        let predicate = random_predicate(&mut program, predicate);
        program.labels.push((name.to_owned(), predicate));
    }
    let source = SourceFile::new("formula", formula);
    let formula = parse_formula(&source).unwrap();
    let mut watching = Monitoring::new(&program);
    let condition = watched(&mut watching, &source, &formula)?;
    let program = watching.finish(begin).unwrap();
    let condition = condition.map(&|mark| program.predicate(mark));
    Some(Case { program, condition })
}

fn listed<E: Engine>(engine: &E, x: &E::States) -> Vec<State> {
    engine.list_states(x, usize::MAX).unwrap()
}

fn answers<E: Engine>(engine: &E, case: &Case) -> [Vec<State>; 5] {
    let fresh = case.program.predicate(case.program.monitors.as_ref().unwrap().fresh);
    let found =
        judged(engine, &fresh, RegionSearch::of_condition(engine, &case.condition).all().unwrap()).unwrap();
    let all = engine.states_where(&fresh).unwrap();
    [&found.pmax_one, &found.pmax_positive, &found.pmin_one, &found.pmin_positive, &all]
        .map(|x| listed(engine, x))
}

fn engines(program: &Program, scope: Scope) -> (SymbolicEngine, ExplicitEngine) {
    let program = Arc::new(program.clone());
    let settings = Settings { scope, memory: 64 << 20, ..Settings::default() };
    let symbolic = SymbolicEngine::new(program.clone(), settings.clone()).unwrap();
    (symbolic, ExplicitEngine::new(program, settings).unwrap())
}

#[test]
fn conditions_of_the_model_are_read_in_its_product_and_not_the_other_way_round() {
    let text = "mdp module m s:[0..2]; [] s<2 -> (s'=s+1); [] true -> (s'=0); endmodule";
    let program = parsed(text);
    let product = |formula: &str| {
        let source = SourceFile::new("formula", formula);
        let mut watching = Monitoring::new(&program);
        watching.watch(&source, &parse_formula(&source).unwrap(), "w").unwrap();
        watching.finish(Begin::Everywhere).unwrap()
    };
    let [product, other] = ["F (s=1 & X s=0)", "F (s=1 & X s=2)"].map(product);
    let source = SourceFile::new("target", "s>0");
    let tree = lang::parse_expression(&source).unwrap();
    let own = lang::lower_target(&program, &source, &tree).unwrap();
    let marked = product.predicate(product.monitors.as_ref().unwrap().fresh);
    for (of, accepted) in [(&program, [true, false]), (&product, [true, true]), (&other, [true, false])] {
        let (symbolic, explicit) = engines(of, Scope::All);
        for (condition, accepted) in [&own, &marked].into_iter().zip(accepted) {
            let [a, b] = [symbolic.states_where(condition).err(), explicit.states_where(condition).err()];
            for error in [a, b] {
                assert_eq!(matches!(error, Some(Error::Usage(_))), !accepted, "{error:?}");
                assert_eq!(error.is_none(), accepted);
            }
        }
    }
}

fn numbers(most: usize) -> impl Strategy<Value = Vec<u16>> {
    prop::collection::vec(any::<u16>(), 0..most)
}

proptest! {
    #![proptest_config(meliora_amount::random(400))]

    #[test]
    fn regions_are_those_of_all_end_components(
        program in numbers(60),
        p in numbers(8),
        q in numbers(8),
        formula in formula(),
    ) {
        let Some(case) = case(&program, &[p, q], &formula, Begin::Everywhere) else { return Ok(()) };
        let brute = Brute::new(&case.program, Scope::All).unwrap();
        let (symbolic, explicit) = engines(&case.program, Scope::All);
        let found = answers(&symbolic, &case);
        prop_assert_eq!(&found, &answers(&explicit, &case), "{}", &formula);
        if brute.states.len() <= MOST_STATES {
            let expected = enumerated(&brute, &case.program, &case.condition);
            let fresh = brute.states_where(&case.program, case.program.monitors.as_ref().unwrap().fresh);
            for (found, expected) in found.iter().zip(&expected) {
                let expected: Vec<State> = (expected & &fresh).iter().map(|&s| brute.states[s].clone()).collect();
                let mut found = found.clone();
                found.sort();
                prop_assert_eq!(found, expected, "{}", &formula);
            }
        }
    }

    #[test]
    fn both_engines_judge_from_every_reachable_state(
        program in numbers(80),
        p in numbers(8),
        q in numbers(8),
        formula in formula(),
    ) {
        let Some(case) = case(&program, &[p, q], &formula, Begin::Everywhere) else { return Ok(()) };
        let (symbolic, explicit) = engines(&case.program, Scope::Reachable);
        let expected = answers(&explicit, &case);
        prop_assert_eq!(&answers(&symbolic, &case), &expected, "{}", &formula);
        // With fresh monitors the states are those of the model, and so are its deadlocks.
        let plain = Brute::new(&case.program.without_monitors(), Scope::Reachable).unwrap();
        let fresh = case.program.predicate(case.program.monitors.as_ref().unwrap().fresh);
        let fresh = explicit.states_where(&fresh).unwrap();
        prop_assert_eq!(listed(&explicit, &fresh).len(), plain.states.len());
        let stuck = explicit.intersection(&explicit.deadlock_states(), &fresh).unwrap();
        prop_assert_eq!(listed(&explicit, &stuck).len(), plain.deadlocks.len());
    }

    #[test]
    fn both_engines_explore_the_same_product(
        program in numbers(80),
        p in numbers(8),
        q in numbers(8),
        formula in formula(),
    ) {
        let Some(case) = case(&program, &[p, q], &formula, Begin::Initially) else { return Ok(()) };
        for scope in [Scope::Reachable, Scope::All] {
            let (symbolic, explicit) = engines(&case.program, scope);
            let (all, stuck) = (listed(&symbolic, &symbolic.all_states()), listed(&symbolic, &symbolic.deadlock_states()));
            prop_assert_eq!(&all, &listed(&explicit, &explicit.all_states()));
            prop_assert_eq!(stuck, listed(&explicit, &explicit.deadlock_states()));
            let initial = listed(&symbolic, &symbolic.initial_states());
            prop_assert_eq!(initial, listed(&explicit, &explicit.initial_states()));
            let count = symbolic.count_transitions(&symbolic.all_choices(), &symbolic.all_states()).unwrap();
            prop_assert_eq!(count, explicit.count_transitions(&explicit.all_choices(), &explicit.all_states()).unwrap());
            if scope == Scope::Reachable {
                let mut brute = Brute::new(&case.program, scope).unwrap().states;
                brute.sort();
                prop_assert_eq!(all, brute);
            }
        }
    }
}
