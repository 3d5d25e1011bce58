//! The explicit engine against a reference by the book, on random programs.

#[path = "common/engines.rs"]
mod engines;

use std::sync::Arc;

use engines::brute::Brute;
use engines::random_program::{random_predicate, random_program};
use meliora::engine::explicit::ExplicitEngine;
use meliora::engine::symbolic::{SymbolicEngine, order};
use meliora::engine::{Scope, Settings};
use meliora::error::{Error, Result, SourceFile};
use meliora::lang;
use meliora::model::Program;
use proptest::prelude::*;

fn numbers(most: usize) -> impl Strategy<Value = Vec<u16>> {
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
    SymbolicEngine::new(program.clone(), order::declared(program), 1, settings)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn every_operation_is_that_of_the_reference(
        of in numbers(160),
        first in numbers(20),
        second in numbers(20),
        scope in scope(),
    ) {
        let mut program = random_program(&of, false);
        let predicates = [random_predicate(&mut program, &first), random_predicate(&mut program, &second)];
        let program = Arc::new(program);
        let brute = Brute::new(&program, scope).unwrap();
        engines::agreement::check(&explicit(&program, scope).unwrap(), &program, &brute, &predicates);
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
    let none = SourceFile::new("constants", "");
    let program = Arc::new(lang::load(&SourceFile::new("m", text), &none).unwrap().program);
    assert!(explicit(&program, Scope::Reachable).is_ok());
    assert!(symbolic(&program, Scope::Reachable).is_ok());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    #[test]
    fn every_operation_of_the_other_engine_too(
        of in numbers(160),
        first in numbers(20),
        second in numbers(20),
        scope in scope(),
    ) {
        let mut program = random_program(&of, false);
        let predicates = [random_predicate(&mut program, &first), random_predicate(&mut program, &second)];
        let program = Arc::new(program);
        let brute = Brute::new(&program, scope).unwrap();
        engines::agreement::check(&symbolic(&program, scope).unwrap(), &program, &brute, &predicates);
    }
}
