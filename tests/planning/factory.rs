//! A factory of many machines that move one at a time, under both engines.

use meliora::advanced::symbolic::Ways;
use meliora::planning::result::AnalysisResult;

use crate::common::factory::{OVER_PATHS, PREFERENCES, factory};
use crate::common::prelude::*;

fn read(machines: usize, preferences: &str) -> (Arc<Program>, Arc<Preferences>) {
    task(factory(machines), preferences.to_owned())
}

fn results<E: Engine>(engine: E, preferences: &Arc<Preferences>) -> Vec<AnalysisResult> {
    let engine = Arc::new(engine);
    let result = |safety| {
        let analysis = finished(&engine, preferences, Options { safety, max_level: None });
        analysis.result().clone()
    };
    Safety::ALL.iter().map(|&safety| result(safety)).collect()
}

#[test]
fn both_engines_agree_on_a_factory() {
    for preferences in [PREFERENCES, OVER_PATHS] {
        let (program, preferences) = read(2, preferences);
        let symbolic = SymbolicEngine::new(Arc::clone(&program), Settings::default()).unwrap();
        let explicit = ExplicitEngine::new(program, Settings::default()).unwrap();
        assert_eq!(results(symbolic, &preferences), results(explicit, &preferences));
    }
}

/// The work for the classes of objectives over paths.
fn work(machines: usize, preferences: &str) -> (u64, Ways) {
    let (program, preferences) = read(machines, preferences);
    let engine = Arc::new(SymbolicEngine::new(program, Settings::default()).unwrap());
    let before = engine.ways().steps;
    finished(&engine, &preferences, Options::default());
    (engine.ways().steps - before, engine.ways())
}

#[test]
fn monitors_that_wait_do_not_make_lost_states_hard_to_find() {
    let (steps, ways) = work(8, OVER_PATHS);
    assert!(ways.lost_by_lists > 0, "{ways:?}");
    assert_eq!(ways.lost_by_layers, 0, "{ways:?}");
    assert!(steps < 4_000_000, "{steps}");
}
