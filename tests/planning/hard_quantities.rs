//! Quantities of models that are hard for a solver: rare events, long chains, ties, components with
//! thousands of states, dozens of levels.

use meliora::quantities::{Cost, Earned, Exploration, Interval, Node};

use crate::common::prelude::*;
use crate::planning::loaded::Loaded;
use crate::planning::quantities::exact;

fn values(loaded: &Loaded, safety: Safety, levels: usize, exact: bool) -> (Values, Node) {
    paid(loaded, safety, levels, exact, &Steps)
}

fn paid(loaded: &Loaded, safety: Safety, levels: usize, exact: bool, costs: &dyn Cost) -> (Values, Node) {
    let analysis = loaded.analyse(safety, None);
    let starts = loaded.engine.list_states(&loaded.engine.initial_states(), 1).unwrap();
    let mut values = Values::new(ValueOptions { levels, exact, within: None });
    let exploration = Exploration::new(values.options(), &analysis, &loaded.program, costs).unwrap();
    exploration.run(&mut values, &starts).unwrap();
    values.solve(&*loaded.engine).unwrap();
    let start = values.start(&starts[0]).unwrap();
    (values, start)
}

const ROUNDED: ValueOptions = ValueOptions { levels: 1, exact: false, within: None };

const TWO: &str = "objective A = F x=0; objective B = F x=1; prefer B > A;";

#[test]
fn a_fraction_that_no_double_has_is_exact() {
    let model =
        "mdp const double p = 1/3; module m x:[0..2] init 0; [] x=0 -> p:(x'=1) + 1-p:(x'=2); endmodule";
    let loaded = Loaded::new(model, "objective B = F x=1; empty = gain;");
    let (values, start) = values(&loaded, Safety::Action, 1, true);
    assert_eq!(exact(&values.probability(start, 1)), Ratio::new(1.into(), 3.into()));
}

#[test]
fn a_rare_exit_from_a_loop_costs_no_precision() {
    // Every round succeeds with 1e-12 and fails for good with 2e-12.
    let model = "mdp module m x:[0..3] init 0;\n\
        [] x=0 -> (x'=3); [] x=3 -> 1e-12:(x'=1) + 2e-12:(x'=2) + 1-3e-12:(x'=0); endmodule";
    let loaded = Loaded::new(model, "objective B = F x=1; empty = gain;");
    let (values, start) = values(&loaded, Safety::Action, 1, false);
    let found = values.probability(start, 1).interval;
    assert!(found.lower <= 1.0 / 3.0 && 1.0 / 3.0 <= found.upper && found.width() < 1e-14, "{found:?}");
}

#[test]
fn a_long_chain_is_solved_without_recursion() {
    let model =
        "mdp module m x:[0..100001] init 0; [] x<100000 -> 0.99999:(x'=x+1) + 0.00001:(x'=100001); endmodule";
    let loaded = Loaded::new(model, "objective B = F x=100000; empty = gain;");
    let (values, start) = values(&loaded, Safety::Action, 1, false);
    let found = values.probability(start, 1).interval;
    let expected = 0.99999f64.powi(100_000);
    assert!((found.lower - expected).abs() < 1e-9 && found.width() < 1e-9, "{found:?}");
}

#[test]
fn few_of_the_states_are_enough_near_the_goal() {
    let model = "mdp module m x:[0..5000] init 9; [] x=2 -> 0.5:(x'=0) + 0.5:(x'=1);
        [] x>2 -> 0.7:(x'=x-1) + 0.3:true; [] x>2 -> (x'=min(x+1,5000)); endmodule";
    let loaded = Loaded::new(model, "objective A = F x=0; objective B = F x=1;");
    let (analysis, mut values) = (loaded.analyse(Safety::Action, None), Values::new(ROUNDED));
    let exploration = Exploration::new(ROUNDED, &analysis, &loaded.program, &Steps).unwrap();
    for nodes in [12, 24, 48, 96] {
        exploration.run_part(&mut values, &[vec![9]], nodes).unwrap();
        values.solve(&*loaded.engine).unwrap();
        assert!(nodes > 12 || !values.is_settled());
    }
    assert!(values.is_settled() && values.nodes() < 100);
    let cost = values.cost(values.start(&[9]).unwrap(), 1).unwrap().interval;
    assert!(cost.lower <= 11.0 && 11.0 <= cost.upper && cost.width() < 1e-9, "{cost:?}");
}

#[test]
fn of_equal_choices_one_that_makes_progress_is_chosen() {
    // Waiting in 0 and 3 is as good as trying, forever.
    let model = "mdp module m x:[0..3] init 0; [wait] x=0 -> (x'=3); [back] x=3 -> (x'=0);\n\
        [try] x=0 -> 1/2:(x'=1) + 1/2:(x'=2); endmodule";
    let loaded = Loaded::new(model, "objective B = F x=1; empty = gain;");
    let (values, start) = values(&loaded, Safety::Action, 1, false);
    is_about(values.probability(start, 1).interval, 0.5);
    let best = values.best_choice(start, 1, Aim::Likely).unwrap();
    assert_eq!(loaded.program.choices(&[0]).unwrap()[best].1, "try");
}

#[test]
fn what_weakens_is_lost_under_transition() {
    let model = "mdp module m x:[0..3] init 0; [a] x=0 -> 1/4:(x'=1) + 3/4:(x'=2); endmodule";
    let loaded = Loaded::new(model, &format!("{TWO} objective C = F x=2; prefer A > C;"));
    let (values, start) = values(&loaded, Safety::Transition, 1, true);
    assert_eq!(exact(&values.probability(start, 1)), Ratio::new(1.into(), 4.into()));
    assert!(values.cost(start, 1).is_none());
}

const ZERO: &str = "objective B = F x=0; empty = gain;";
/// Neither is certain, but one of the two is.
const EITHER: &str = "objective A = F x=0; objective B = F x=1;";

/// P_1 and C_1 of the initial state of a model whose states form one large component.
fn large(model: &str, preferences: &str) -> (Interval, Option<Interval>) {
    let (values, start) = values(&Loaded::new(model, preferences), Safety::Action, 1, false);
    (values.probability(start, 1).interval, values.cost(start, 1).map(|cost| cost.interval))
}

fn is_about(found: Interval, expected: f64) {
    let width = found.width() / found.upper.max(1.0);
    assert!(found.lower <= expected * (1.0 + 1e-12) && expected * (1.0 - 1e-12) <= found.upper, "{found:?}");
    assert!(width < 1e-7, "{found:?} is wide");
}

#[test]
fn a_random_walk_with_a_drift_is_iterated() {
    // The ruin of a gambler who wins a round with 0.55, from 20 of 3000: (9/11)^20.
    let model =
        "mdp module m x:[0..3000] init 20; [] x>0 & x<3000 -> 0.45:(x'=x-1) + 0.55:(x'=x+1); endmodule";
    is_about(large(model, ZERO).0, (9.0f64 / 11.0).powi(20));
}

#[test]
fn a_slow_random_walk_is_eliminated() {
    // From a wall at distance n, a fair walk takes n(n+1) steps.
    let model = "mdp module m x:[0..1501] init 1501;\n\
        [] x=2 -> 0.25:(x'=0) + 0.25:(x'=1) + 0.5:(x'=3); [] x>2 & x<1501 -> 0.5:(x'=x-1) + 0.5:(x'=x+1);\n\
        [] x=1501 -> 0.5:(x'=x-1) + 0.5:true; endmodule";
    is_about(large(model, EITHER).1.unwrap(), 1500.0 * 1501.0);
}

#[test]
fn a_large_component_with_a_rare_exit_is_solved() {
    let model = "mdp module m x:[0..1501] init 2; [] x>1 & x<1501 -> (x'=x+1);\n\
        [] x=1501 -> 1e-12:(x'=0) + 2e-12:(x'=1) + 1-3e-12:(x'=2); endmodule";
    is_about(large(model, ZERO).0, 1.0 / 3.0);
}

#[test]
fn free_moves_to_the_best_exit_of_a_large_component_cost_nothing() {
    // An end component of cost 0 for probabilities and for costs.
    let model = "mdp module m x:[0..2001] init 2; [left] x>2 -> (x'=x-1); [right] x>1 & x<2001 -> (x'=x+1);\n\
        [try] x=1000 -> 0.3:(x'=0) + 0.7:(x'=1); [try] x=50 -> 0.2:(x'=0) + 0.8:(x'=1); endmodule";
    is_about(large(model, ZERO).0, 0.3);
    let model = "mdp module m x:[0..2001] init 2; [left] x>2 -> (x'=x-1); [right] x>1 & x<2001 -> (x'=x+1);\n\
        [try] x=1000 -> 1/8:(x'=0) + 1/8:(x'=1) + 3/4:true;\n\
        [try] x=50 -> 1/10:(x'=0) + 1/10:(x'=1) + 4/5:true; endmodule\n\
        rewards \"tries\" [try] true : 1; endrewards";
    // The nearer exit takes 48 steps and 5 tries; the better one 4 tries.
    is_about(large(model, EITHER).1.unwrap(), 53.0);
    let loaded = Loaded::new(model, EITHER);
    let tries = Earned { program: &loaded.program, structure: &loaded.program.rewards[0] };
    let (values, start) = paid(&loaded, Safety::Action, 1, false, &tries);
    is_about(values.cost(start, 1).unwrap().interval, 4.0);
    let best = values.best_choice(start, 1, Aim::Cheap).unwrap();
    assert_eq!(loaded.program.choices(&[2]).unwrap()[best].1, "right");
}

#[test]
fn what_weakens_is_lost_in_a_large_component() {
    let model = "mdp module m x:[0..3002] init 20;\n\
        [a] x>0 & x<3000 -> 0.4:(x'=x-1) + 0.5:(x'=x+1) + 0.1:(x'=3001); endmodule";
    let loaded = Loaded::new(model, "objective A = F x<=3000; objective B = F x=0; prefer B > A;");
    let (values, start) = values(&loaded, Safety::Transition, 1, false);
    // The smaller root of 0.4 - x + 0.5 x² = 0, to the power of 20.
    is_about(values.probability(start, 1).interval, (1.0 - 0.2f64.sqrt()).powi(20));
}

/// Checks the probability to climb a ladder: each try climbs or is stuck, and only the goal of the own rung is certain.
fn climbs<E: Engine>(engine: &Arc<E>, program: &Program, preferences: &Arc<Preferences>, safety: Safety) {
    let analysis = finished(engine, preferences, Options { safety, ..Options::default() });
    let mut values = Values::new(ValueOptions { levels: RUNGS, exact: true, within: None });
    let bottom = vec![0; program.variables.len()];
    let exploration = Exploration::new(values.options(), &analysis, program, &Steps).unwrap();
    exploration.run(&mut values, std::slice::from_ref(&bottom)).unwrap();
    values.solve(engine.as_ref()).unwrap();
    let node = values.start(&bottom).unwrap();
    for k in [1, 62, 63, 64, 65, RUNGS] {
        let half = Ratio::new(1.into(), 2.into());
        assert_eq!(exact(&values.probability(node, k)), num_traits::pow(half, k), "{safety:?}, P_{k}");
    }
}

/// More levels and classes than a word has bits.
const RUNGS: usize = 70;

#[test]
fn many_levels_and_classes_have_their_probabilities() {
    let model = format!(
        "mdp module m n : [0..{RUNGS}]; stuck : bool; done : bool;
           [try] n<{RUNGS} & !stuck & !done -> 1/2:(n'=n+1) + 1/2:(stuck'=true);
           [take] !done -> (done'=true); [] done -> true; endmodule"
    );
    let goal = |n: usize| format!("objective g{n} = F (done & n={n});\n");
    let order: Vec<String> = (0..=RUNGS).rev().map(|n| format!("g{n}")).collect();
    let goals: String = (0..=RUNGS).map(goal).collect();
    let (program, preferences) = task(model, format!("{goals}prefer {};", order.join(" > ")));
    let symbolic = Arc::new(SymbolicEngine::new(program.clone(), Settings::default()).unwrap());
    let explicit = Arc::new(ExplicitEngine::new(program.clone(), Settings::default()).unwrap());
    for safety in [Safety::Action, Safety::Prefix] {
        climbs(&symbolic, &program, &preferences, safety);
        climbs(&explicit, &program, &preferences, safety);
    }
}
