//! The operations in which the symbolic engine spends its time, as far as the library shows them.

mod common;

use std::sync::Arc;

use criterion::{BatchSize, BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use meliora::engine::SymbolicEngine;
use meliora::engine::{Algebra, Engine, Scope};

use common::Case;

/// An operation of an engine that was just built: its caches contain only entries from building.
fn fresh<T>(c: &mut Criterion, case: &Case, name: &str, states: u64, work: impl Fn(&SymbolicEngine) -> T) {
    let mut group = c.benchmark_group(name);
    group.throughput(Throughput::Elements(states));
    group.bench_function(BenchmarkId::from_parameter(&case.name), |b| {
        let keep = |engine: Arc<SymbolicEngine>| {
            let result = work(&engine);
            (result, engine)
        };
        b.iter_batched(|| case.symbolic(), keep, BatchSize::PerIteration);
    });
    group.finish();
}

fn operations(c: &mut Criterion) {
    let mut cases = common::cases();
    cases.push(common::gridworld(24, 5));
    for case in &cases {
        let states = case.announce();
        let mut group = c.benchmark_group("encoding");
        group.throughput(Throughput::Elements(states));
        // In the scope `all` nothing is explored: the model is only encoded and checked.
        group.bench_function(BenchmarkId::from_parameter(&case.name), |b| {
            b.iter_with_large_drop(|| case.symbolic_in(Scope::All));
        });
        group.finish();
        let target = case.preferences.objectives[0].target().unwrap();
        fresh(c, case, "pre-image", states, |engine| {
            engine.pre(&engine.all_choices(), &engine.states_where(target).unwrap()).unwrap()
        });
        fresh(c, case, "universal pre-image", states, |engine| {
            let inside = engine.difference(&engine.all_states(), &engine.states_where(target).unwrap());
            engine.pre_within(&engine.all_choices(), &inside.unwrap()).unwrap()
        });
        fresh(c, case, "image", states, |engine| engine.post(&engine.all_choices()).unwrap());
        fresh(c, case, "inner fixpoint", states, |engine| {
            let target = engine.states_where(target).unwrap();
            engine.can_reach(&target, &engine.all_choices(), &[]).unwrap()
        });
        fresh(c, case, "losing states", states, |engine| {
            let outside = engine.difference(&engine.all_states(), &engine.states_where(target).unwrap());
            engine.stay_within(&outside.unwrap(), &engine.all_choices()).unwrap()
        });
        fresh(c, case, "confined fixpoint", states, |engine| {
            let target = engine.states_where(target).unwrap();
            let outside = engine.difference(&engine.all_states(), &target).unwrap();
            let choices = engine.choices_in(&engine.all_choices(), &outside).unwrap();
            engine.almost_surely_reach(&target, &choices).unwrap()
        });
    }
}

criterion_group! { name = all; config = common::config(); targets = operations }
criterion_main!(all);
