//! Both engines compared with a reference implementation, on random programs.

use meliora::error::Result;
use proptest::prelude::*;

use crate::common::agreement;
use crate::common::prelude::*;

/// The numbers from which a random program is made.
pub(crate) fn numbers(most: usize) -> impl Strategy<Value = Vec<u16>> {
    proptest::collection::vec(0u16..1000, 0..most)
}

fn scope() -> impl Strategy<Value = Scope> {
    prop_oneof![Just(Scope::Reachable), Just(Scope::All)]
}

fn explicit(program: &Arc<Program>, scope: Scope) -> Result<ExplicitEngine> {
    ExplicitEngine::new(program.clone(), Settings { scope, ..Settings::default() })
}

fn symbolic(program: &Arc<Program>, scope: Scope) -> Result<SymbolicEngine> {
    let settings = Settings { scope, memory: 64 << 20, ..Settings::default() };
    SymbolicEngine::new(program.clone(), Settings { order: Order::Declared, ..settings })
}

proptest! {
    #![proptest_config(meliora_amount::random(300))]

    /// The symbolic engine takes part in every fifth case: it takes ten times as long.
    #[test]
    fn every_operation_is_that_of_the_reference(
        of in numbers(160),
        first in numbers(20),
        second in numbers(20),
        scope in scope(),
        is_symbolic_too in prop::bool::weighted(0.2),
    ) {
        let mut program = random_program(&of, false);
        let predicates = [random_predicate(&mut program, &first), random_predicate(&mut program, &second)];
        let program = Arc::new(program);
        let brute = Brute::new(&program, scope).unwrap();
        let agrees = |engine: AnyEngine| agreement::check(&engine, &program, &brute, &predicates);
        let engine = explicit(&program, scope).unwrap();
        agreement::check(&engine, &program, &brute, &predicates);
        agrees(engine.into());
        if is_symbolic_too {
            let engine = symbolic(&program, scope).unwrap();
            agreement::check(&engine, &program, &brute, &predicates);
            agrees(engine.into());
        }
    }

    #[test]
    fn a_fault_is_found_where_there_is_one(of in numbers(160), scope in scope()) {
        let program = Arc::new(random_program(&of, true));
        let expected = Brute::new(&program, scope);
        let explicit = explicit(&program, scope).err();
        let symbolic = symbolic(&program, scope).err();
        for (name, error) in [("explicit", explicit), ("symbolic", symbolic)] {
            match (&expected, error) {
                (Ok(_), None) => {}
                (Err(_), Some(Error::Input(diagnostics))) => prop_assert_eq!(diagnostics.len(), 1),
                (Ok(_), Some(error)) => prop_assert!(false, "{}: no fault, but {}", name, error),
                (Err(fault), other) => prop_assert!(false, "{}: {:?}, but {:?}", name, fault, other),
            }
        }
    }
}

#[test]
fn a_part_of_a_guard_that_is_not_looked_at_has_no_fault() {
    let text = "mdp module m far : [0..999999] init 7; x : [0..2] init 0;\n\
        [a] far<5 & mod(1,x)=0 -> true; [b] x=1 -> true; [c] x=2 -> true; endmodule";
    let program = Arc::new(parsed(text));
    assert!(explicit(&program, Scope::Reachable).is_ok());
    assert!(symbolic(&program, Scope::Reachable).is_ok());
}

/// A token among `places` flags: it moves to the next flag or back to the first.
fn token(places: usize) -> String {
    let mut text = String::from("mdp module m x0 : bool init true;\n");
    for place in 1..places {
        text += &format!("x{place} : bool init false;\n");
    }
    for place in 0..places {
        let next = (place + 1) % places;
        text += &format!("[] x{place} -> (x{place}'=false) & (x{next}'=true);\n");
        if place > 1 {
            text += &format!("[back] x{place} -> 0.5: (x{place}'=false) & (x0'=true) + 0.5: true;\n");
        }
    }
    text + "endmodule"
}

fn with_predicates<const N: usize>(model: &str, predicates: [&str; N]) -> (Arc<Program>, [Predicate; N]) {
    let none = SourceFile::new("constants", "");
    let checked = lang::load(&SourceFile::new("m", model), &none).unwrap();
    let predicates = predicates.map(|text| {
        let source = SourceFile::new("target", text);
        let expression = lang::parse_expression(&source).unwrap();
        lang::lower_target(&checked.program, &source, &expression).unwrap()
    });
    (Arc::new(checked.program), predicates)
}

#[test]
fn more_sets_of_written_variables_than_the_operation_cache_tells_apart() {
    let (program, predicates) = with_predicates(&token(40), ["x0", "x3 | x17 | x38", "!x20"]);
    let by_symbolic = answers(&symbolic(&program, Scope::Reachable).unwrap(), &predicates);
    assert_eq!(by_symbolic, answers(&explicit(&program, Scope::Reachable).unwrap(), &predicates));
    // From 0 the token does not get to 3, 17 or 38 at once; from each of them it gets back to 0.
    assert_eq!(by_symbolic[1].len(), 0);
    assert_eq!(by_symbolic[3].len(), 3);
}

#[test]
fn sets_without_a_pattern_have_large_diagrams() {
    let model = "mdp module m x : [0..255]; y : [0..127];\n\
        [up] x<255 -> 0.5: (x'=x+1) + 0.5: true; [right] y<127 -> (y'=y+1);\n\
        [twice] x<128 & y>2 -> (x'=2*x) & (y'=y-2); [back] x=255 -> (x'=0); endmodule";
    let predicates = ["mod(x*y+7*x*x,251)<100", "mod(3*x+x*y*y,241)>90", "x<200"];
    let (program, predicates) = with_predicates(model, predicates);
    let by_symbolic = answers(&symbolic(&program, Scope::Reachable).unwrap(), &predicates);
    assert!(by_symbolic == answers(&explicit(&program, Scope::Reachable).unwrap(), &predicates));
}

/// For each X and Y the states of Y with a choice into X, and the fixpoints of each X.
fn answers<E: Engine>(engine: &E, predicates: &[Predicate]) -> Vec<Vec<Vec<i64>>> {
    let sets: Vec<E::States> = predicates.iter().map(|e| engine.states_where(e).unwrap()).collect();
    let mut found = Vec::new();
    for y in &sets {
        let c = engine.choices_in(&engine.all_choices(), y).unwrap();
        for x in &sets {
            found.push(engine.sources(&engine.pre(&c, x).unwrap()).unwrap());
        }
    }
    for x in &sets {
        found.push(engine.can_reach(x, &engine.all_choices(), &[]).unwrap());
        found.push(engine.almost_surely_reach(x, &engine.all_choices()).unwrap().states);
        found.push(engine.stay_within(x, &engine.all_choices()).unwrap().states);
    }
    found.iter().map(|x| engine.list_states(x, usize::MAX).unwrap()).collect()
}
