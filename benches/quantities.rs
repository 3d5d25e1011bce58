//! The quantities of a finished analysis: exploration and equations, for all states.
//!
//! `cargo bench -p meliora-benches --bench quantities -- solve` measures the equations alone; throughput is in states.

mod common;

use std::time::{Duration, Instant};

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use meliora::engine::Engine;
use meliora::quantities::{Exploration, Steps, ValueOptions, Values};

/// P_1, P_2, C_1, C_2 and N.
const OPTIONS: ValueOptions = ValueOptions { levels: 2, exact: false, within: None };

fn quantities(c: &mut Criterion) {
    for case in common::cases() {
        let states = case.announce();
        let mut group = c.benchmark_group("quantities");
        group.throughput(Throughput::Elements(states));
        let engine = case.symbolic();
        let mut analysis = case.analysis(&engine);
        analysis.run(&mut |_| ()).unwrap();
        let all = engine.list_states(&engine.all_states(), usize::MAX).unwrap();
        let timed = |times: u64, phase: usize| -> Duration {
            let once = |_| {
                let mut values = Values::new(OPTIONS);
                let start = Instant::now();
                let exploration = Exploration::new(OPTIONS, &analysis, &case.program, &Steps).unwrap();
                exploration.run(&mut values, &all).unwrap();
                let explored = start.elapsed();
                values.solve(&*engine).unwrap();
                [explored, start.elapsed() - explored][phase]
            };
            (0..times).map(once).sum()
        };
        for (phase, name) in ["explore", "solve"].into_iter().enumerate() {
            group.bench_function(BenchmarkId::new(name, &case.name), |b| {
                b.iter_custom(|times| timed(times, phase));
            });
        }
        group.finish();
    }
}

criterion_group! { name = all; config = common::config(); targets = quantities }
criterion_main!(all);
