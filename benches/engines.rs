//! The phases of the main job under each engine: building, reachability, outcomes, levels.
//!
//! `cargo bench -p meliora-benches --bench engines -- fleet` measures one family; throughput is in states.

mod common;

use std::sync::Arc;

use criterion::{BatchSize, BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use meliora::engine::Engine;
use meliora::engine::regions::regions;
use meliora::planning::Phase;

use common::Case;

/// All phases of one engine on one case. What an operation needs is made before the clock starts, and
/// anew each time: a diagram that was computed once is found again in no time.
fn phases<E: Engine>(c: &mut Criterion, case: &Case, engine: &str, states: u64, build: impl Fn() -> Arc<E>) {
    let mut group = c.benchmark_group(engine);
    group.throughput(Throughput::Elements(states));
    let id = |phase: &str| BenchmarkId::new(phase, &case.name);
    group.bench_function(id("build"), |b| b.iter_with_large_drop(&build));
    let target = case.preferences.objectives[0].target().unwrap();
    group.bench_function(id("reachability"), |b| {
        let work = |engine: Arc<E>| {
            let found = regions(&*engine, &engine.states_where(target).unwrap()).unwrap();
            (found, engine)
        };
        b.iter_batched(&build, work, BatchSize::PerIteration);
    });
    group.bench_function(id("outcomes"), |b| {
        let work = |engine: Arc<E>| {
            case.analysis(&engine).run_phase(Phase::Outcomes, &mut |_| ()).unwrap();
            engine
        };
        b.iter_batched(&build, work, BatchSize::PerIteration);
    });
    group.bench_function(id("levels"), |b| {
        b.iter_custom(|times| {
            let once = |_| {
                let engine = build();
                let mut analysis = case.analysis(&engine);
                analysis.run_phase(Phase::Outcomes, &mut |_| ()).unwrap();
                analysis.run_phase(Phase::Improvement, &mut |_| ()).unwrap();
                let start = std::time::Instant::now();
                analysis.run_phase(Phase::Sasi, &mut |_| ()).unwrap();
                analysis.run_phase(Phase::Spi, &mut |_| ()).unwrap();
                start.elapsed()
            };
            (0..times).map(once).sum()
        });
    });
    group.finish();
}

fn engines(c: &mut Criterion) {
    for case in common::cases() {
        let states = case.announce();
        phases(c, &case, "symbolic", states, || case.symbolic());
        phases(c, &case, "explicit", states, || case.explicit());
    }
}

criterion_group! { name = all; config = common::config(); targets = engines }
criterion_main!(all);
