//! States and choices that a model does not have are in no set.

use meliora::model::CommandId;
use proptest::prelude::*;

use crate::common::prelude::*;
use crate::engines::explicit::numbers;

const SCOPES: [Scope; 2] = [Scope::All, Scope::Reachable];

fn program(text: &str) -> Arc<Program> {
    Arc::new(parsed(text))
}

fn settings(scope: Scope) -> Settings {
    Settings { scope, memory: 16 << 20, ..Settings::default() }
}

/// All pairs of small values, as states of a model whose x is 1 to 3 and whose y is -1 to 1.
fn check_states<E: Engine>(engine: &E) {
    let all = engine.all_states();
    let check = |state: &[i64], exists: bool| {
        assert_eq!(engine.contains(&all, state).unwrap(), exists, "{state:?}");
        assert_eq!(!engine.is_empty(&engine.singleton(state).unwrap()).unwrap(), exists, "{state:?}");
    };
    for x in -2..7 {
        for y in -5..6 {
            check(&[x, y], (1..=3).contains(&x) && (-1..=1).contains(&y));
        }
    }
    check(&[i64::MIN, i64::MAX], false);
}

#[test]
fn values_outside_of_their_ranges_are_no_state() {
    let program = program(
        "mdp module m x : [1..3] init 1; y : [-1..1] init 0;\n\
         [] x<3 -> (x'=x+1); [] y<1 -> (y'=y+1); [] y>-1 -> (y'=y-1); endmodule",
    );
    for scope in SCOPES {
        check_states(&ExplicitEngine::new(program.clone(), settings(scope)).unwrap());
        check_states(&SymbolicEngine::new(program.clone(), settings(scope)).unwrap());
    }
}

#[test]
fn of_many_valuations_those_that_are_not_reached_are_no_state() {
    // The sum of x and y is always even.
    let program = program(
        "mdp module m x : [0..599] init 0; y : [0..599] init 0;\n\
         [] x<599 & y<599 -> (x'=x+1) & (y'=y+1); [] x>0 & y<599 -> (x'=x-1) & (y'=y+1);\n\
         [] x<598 -> (x'=x+2); [] x=0 & y=0 -> (x'=599) & (y'=1); endmodule",
    );
    let engine = ExplicitEngine::new(program, settings(Scope::Reachable)).unwrap();
    let all = engine.all_states();
    assert_eq!(engine.count(&all).unwrap(), 180_000u32.into());
    for x in 0..600 {
        for y in 0..600 {
            assert_eq!(engine.contains(&all, &[x, y]).unwrap(), (x + y) % 2 == 0, "x={x}, y={y}");
        }
    }
}

fn combination(synchronisation: usize, commands: &[u32]) -> Choice {
    Choice::Combination { synchronisation, commands: commands.iter().map(|&c| CommandId(c)).collect() }
}

/// For each choice whether the states 0, 1 and 2 have it, as the explicit engine says.
fn check_choices(text: &str, expected: &[(Choice, [bool; 3])]) {
    let program = program(text);
    for scope in SCOPES {
        let engine = ExplicitEngine::new(program.clone(), settings(scope)).unwrap();
        for (choice, states) in expected {
            let found =
                [0, 1, 2].map(|x| engine.contains_choice(&engine.all_choices(), &[x], choice).unwrap());
            assert_eq!(found, *states, "{choice:?}");
        }
        assert!(!engine.contains_choice(&engine.all_choices(), &[3], &expected[0].0).unwrap());
    }
}

#[test]
fn a_state_has_its_own_choices_and_no_other() {
    let text = "mdp module m x : [0..2] init 0; [a] x=0 -> (x'=1); [b] x<2 -> (x'=2); endmodule\n\
        module n [b] true -> true; [b] x=1 -> true; endmodule";
    let none = [false; 3];
    check_choices(
        text,
        &[
            (combination(0, &[0]), [true, false, false]),
            (combination(1, &[1, 2]), [true, true, false]),
            (combination(1, &[1, 3]), [false, true, false]),
            (Choice::Deadlock, [false, false, true]),
            // A command of another action, too many commands, too few, numbers that are too large.
            (combination(0, &[1]), none),
            (combination(0, &[0, 2]), none),
            (combination(1, &[1]), none),
            (combination(2, &[0]), none),
            (combination(0, &[9]), none),
            (Choice::Uniform, none),
        ],
    );
}

#[test]
fn a_state_of_a_chain_has_one_choice_and_none_by_command() {
    check_choices(
        "dtmc module m x : [0..2] init 0; [a] x=0 -> (x'=1); [b] x<2 -> (x'=2); endmodule",
        &[
            (Choice::Uniform, [true, true, false]),
            (Choice::Deadlock, [false, false, true]),
            (combination(0, &[0]), [false; 3]),
            (combination(1, &[1]), [false; 3]),
        ],
    );
}

#[test]
fn the_step_of_monitors_in_a_deadlock_of_a_chain_is_its_choice() {
    let model = "dtmc module m s : [0..1] init 0; endmodule";
    let program = parsed(model);
    let preferences = SourceFile::new("p", "objective O = F (s=1 & X s=1);");
    let program = Arc::new(lang::load_preferences(&preferences, program).unwrap().program);
    let (symbolic, explicit) = (
        SymbolicEngine::new(program.clone(), settings(Scope::Reachable)).unwrap(),
        ExplicitEngine::new(program.clone(), settings(Scope::Reachable)).unwrap(),
    );
    let state = symbolic.list_states(&symbolic.initial_states(), 1).unwrap().remove(0);
    let steps = program.steps(&state).unwrap();
    assert_eq!(steps.len(), 1);
    let others = [Choice::Deadlock, combination(0, &[0]), combination(0, &[1])];
    for (choice, expected) in others.iter().map(|c| (c, false)).chain([(&steps[0].choice, true)]) {
        let mine = symbolic.contains_choice(&symbolic.all_choices(), &state, choice).unwrap();
        let theirs = explicit.contains_choice(&explicit.all_choices(), &state, choice).unwrap();
        assert_eq!((mine, theirs), (expected, expected), "{choice:?}");
    }
}

#[test]
fn a_set_is_listed_in_one_order_however_many_states_are_wanted() {
    let text = "mdp module m x : [-3..9] init 0; b : bool init false; y : [0..20] init 7;
         [] x<9 -> (x'=x+1) & (y'=mod(3*y+x+4,21)); [] x>-3 -> (x'=x-1) & (b'=!b); endmodule";
    let program = program(text);
    for order in [Order::Auto, Order::Declared] {
        let engine = SymbolicEngine::new(program.clone(), Settings { order, ..Settings::default() }).unwrap();
        let all = engine.all_states();
        let (mut listing, mut one_by_one) = (engine.listing(&all).unwrap(), Vec::new());
        while let Some(state) = engine.next_listed(&mut listing).unwrap() {
            one_by_one.push(state);
        }
        assert!(one_by_one.len() > 200 && one_by_one.is_sorted(), "{}", one_by_one.len());
        assert_eq!(engine.list_states(&all, usize::MAX).unwrap(), one_by_one);
        for limit in [1, 63, 65, one_by_one.len() - 1, one_by_one.len()] {
            assert_eq!(engine.list_states(&all, limit).unwrap(), one_by_one[..limit], "{limit}");
        }
    }
}

/// Compares the test for several sets at once with one test per set, in all states and outside of them.
fn check_several<E: Engine>(engine: &E, predicates: &[Predicate]) {
    let mut sets = vec![engine.all_states(), engine.no_states(), engine.initial_states()];
    for predicate in predicates {
        let holds = engine.states_where(predicate).unwrap();
        sets.push(engine.can_reach(&holds, &engine.all_choices(), &[]).unwrap());
        sets.push(holds);
    }
    let several = engine.membership(&sets.iter().collect::<Vec<_>>()).unwrap();
    for state in engine.list_states(&engine.all_states(), usize::MAX).unwrap() {
        for state in
            [state.clone(), state.iter().map(|x| x + 1).collect(), state.iter().map(|x| x - 1).collect()]
        {
            let bit =
                |(number, x): (usize, &E::States)| u64::from(engine.contains(x, &state).unwrap()) << number;
            let expected: u64 = sets.iter().enumerate().map(bit).sum();
            assert_eq!(several.of(&state).unwrap(), expected, "{state:?}");
        }
    }
}

proptest! {
    #![proptest_config(meliora_amount::random(60))]

    #[test]
    fn several_sets_contain_what_each_of_them_contains(
        of in numbers(160),
        first in numbers(20),
        second in numbers(20),
    ) {
        let mut program = random_program(&of, false);
        let predicates = [random_predicate(&mut program, &first), random_predicate(&mut program, &second)];
        let predicates = predicates.map(|e| program.predicate(e));
        let program = Arc::new(program);
        for scope in SCOPES {
            let settings = Settings { scope, memory: 64 << 20, ..Settings::default() };
            check_several(&ExplicitEngine::new(program.clone(), settings.clone()).unwrap(), &predicates);
            check_several(&SymbolicEngine::new(program.clone(), settings).unwrap(), &predicates);
        }
    }
}
