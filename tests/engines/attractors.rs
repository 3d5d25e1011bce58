//! The methods that remove an attractor, each against the reference and the explicit engine.

use std::sync::Arc;

use meliora::advanced::symbolic::Thresholds;
use meliora::engine::regions::{Regions, regions};
use meliora::engine::{Algebra, Engine, ExplicitEngine, Settings, SymbolicEngine};
use meliora::error::SourceFile;
use meliora::lang;
use meliora::model::State;
use meliora::model::predicate::Predicate;
use proptest::prelude::*;

use crate::common::agreement;
use crate::common::brute::Brute;
use crate::common::random_program::{random_predicate, random_program};
use crate::explicit::numbers;

/// The recursion over the lists of all groups alone, turns with layers after a single step and after
/// some, which finds a part of the lost states, and the usual order of attempts.
fn thresholds() -> [Thresholds; 5] {
    let without_parts = Thresholds { relations_per_bit: 0, ..Thresholds::default() };
    let limited = [u64::MAX, 1, 20, 100].map(|lose_steps| Thresholds { lose_steps, ..without_parts });
    let [forced, one, few, some] = limited;
    [forced, one, few, some, Thresholds::default()]
}

fn listed<E: Engine>(engine: &E, target: &Predicate) -> Regions<Vec<State>> {
    let found = regions(engine, &engine.states_where(target).unwrap()).unwrap();
    found.map(|x| engine.list_states(&x, usize::MAX).unwrap())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn every_way_to_remove_an_attractor_finds_the_same(
        of in numbers(160),
        first in numbers(20),
        second in numbers(20),
    ) {
        let mut program = random_program(&of, false);
        let predicates = [random_predicate(&mut program, &first), random_predicate(&mut program, &second)];
        let program = Arc::new(program);
        let brute = Brute::new(&program, Settings::default().scope).unwrap();
        let explicit = ExplicitEngine::new(program.clone(), Settings::default()).unwrap();
        for thresholds in thresholds() {
            let settings = Settings { memory: 64 << 20, thresholds, ..Settings::default() };
            let engine = SymbolicEngine::new(program.clone(), settings).unwrap();
            agreement::check(&engine, &program, &brute, &predicates);
            for target in predicates.map(|e| program.predicate(e)) {
                prop_assert_eq!(listed(&engine, &target), listed(&explicit, &target), "{:?}", thresholds);
            }
        }
    }
}

/// Modules that run down side by side: each loss has as many layers as the longest of them.
fn burning(modules: usize) -> SymbolicEngine {
    let module = |i: usize| {
        format!("module m{i} x{i} : [0..9]; [] x{i}<9 -> 0.5: (x{i}'=x{i}+1) + 0.5: true; endmodule ")
    };
    let text = format!("mdp {}", (0..modules).map(module).collect::<String>());
    let none = SourceFile::new("constants", "");
    let source = SourceFile::new("m", text);
    let program = lang::load(&source, &none).unwrap().program;
    let thresholds = Thresholds { relations_per_bit: 0, ..Thresholds::default() };
    SymbolicEngine::new(Arc::new(program), Settings { thresholds, ..Settings::default() }).unwrap()
}

#[test]
fn losses_of_many_layers_in_a_product_need_no_layers() {
    let engine = burning(6);
    let last = engine.singleton(&[9; 6]).unwrap();
    let found = regions(&engine, &last).unwrap();
    assert_eq!(engine.count(&found.pmin_positive).unwrap(), 1_000_000u32.into());
    let ways = engine.ways();
    assert!(ways.lost_by_lists > 0 && ways.lost_by_layers == 0, "{ways:?}");
}
