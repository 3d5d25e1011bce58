//! Both engines on random grid worlds of thousands of states, robots and batteries among them: large
//! enough that the symbolic engine uses each of its algorithms, which the tests check.

use meliora::advanced::symbolic::Ways;
use meliora::engine::regions;
use meliora::generate::{Choices, Parameters, gridworld};
use meliora::planning::result::AnalysisResult;

use crate::common::prelude::*;

/// A world that numbers describe.
fn world(seed: u64) -> (Arc<Program>, Arc<Preferences>) {
    let side = 3 + seed as usize % 5;
    let robots = 1 + usize::from(seed % 3 == 2);
    let mut parameters = Parameters::new(side, side + seed as usize % 3, 2 + seed as usize % 3);
    parameters.robots = robots;
    parameters.battery = (seed % 4 != 1).then_some(if robots > 1 { 6 } else { 3 * side as u32 });
    parameters.walls = [10, 25][seed as usize % 2];
    parameters.slippery = [10, 30][seed as usize / 2 % 2];
    let choices = Choices { seed, ..Choices::default() };
    let written = gridworld(&parameters, &choices).unwrap();
    task(written.model, written.preferences)
}

fn results<E: Engine>(engine: &Arc<E>, preferences: &Arc<Preferences>) -> Vec<AnalysisResult> {
    let result = |safety| {
        let analysis = finished(engine, preferences, Options { safety, max_level: None });
        analysis.result().clone()
    };
    Safety::ALL.iter().map(|&safety| result(safety)).collect()
}

/// The sizes of the four regions of the first target.
fn counts<E: Engine>(engine: &E, preferences: &Preferences) -> Vec<String> {
    let target = engine.states_where(preferences.objectives[0].target().unwrap()).unwrap();
    let found = regions::regions(engine, &target).unwrap();
    let all = [found.pmax_one, found.pmax_positive, found.pmin_one, found.pmin_positive];
    all.iter().map(|x| engine.count(x).unwrap().to_string()).collect()
}

/// Thresholds that send small work each way.
fn thresholds() -> [Thresholds; 4] {
    let usual = Thresholds::default();
    // All methods take turns.
    let hasty = Thresholds { first_turn: 20, ..usual };
    let narrow = Thresholds { relations_per_bit: 0, first_turn: 80, first_collection: 2_000, ..usual };
    // Garbage is collected within all recursions.
    let early = Thresholds { first_collection: 2_000, ..usual };
    [usual, hasty, narrow, early]
}

/// The ways that were taken to what the explicit engine finds on the worlds of these seeds.
fn ways(seeds: impl Iterator<Item = u64>) -> Vec<Ways> {
    let mut ways = Vec::new();
    for seed in seeds {
        let (program, preferences) = world(seed);
        let explicit = Arc::new(ExplicitEngine::new(Arc::clone(&program), Settings::default()).unwrap());
        let expected = (results(&explicit, &preferences), counts(&*explicit, &preferences));
        for thresholds in thresholds() {
            let settings = Settings { memory: 256 << 20, thresholds, ..Settings::default() };
            let symbolic = Arc::new(SymbolicEngine::new(Arc::clone(&program), settings).unwrap());
            let found = (results(&symbolic, &preferences), counts(&*symbolic, &preferences));
            assert_eq!(found, expected, "seed {seed}, {thresholds:?}");
            ways.push(symbolic.ways());
        }
    }
    ways
}

#[test]
fn every_way_leads_to_what_the_explicit_engine_finds() {
    // In two threads: this is the longest test of all.
    let ways = std::thread::scope(|scope| {
        let halves =
            [0, 1].map(|first| scope.spawn(move || ways((first..share(20).min(8) as u64).step_by(2))));
        halves.map(|half| half.join().unwrap()).concat()
    });
    let sum = |of: fn(&Ways) -> u64| ways.iter().map(of).sum::<u64>();
    let total = Ways {
        by_recursion: sum(|w| w.by_recursion),
        by_saturation: sum(|w| w.by_saturation),
        confined_by_recursion: sum(|w| w.confined_by_recursion),
        lost_by_recursion: sum(|w| w.lost_by_recursion),
        lost_by_lists: sum(|w| w.lost_by_lists),
        lost_by_layers: sum(|w| w.lost_by_layers),
        steps: sum(|w| w.steps),
    };
    println!("{total:?}");
    // On grids the recursion always ends before saturation; the tests of the engine compare both on all small relations.
    let reached = [total.by_recursion, total.confined_by_recursion];
    let lost = [total.lost_by_recursion, total.lost_by_lists, total.lost_by_layers];
    assert!(reached.iter().chain(&lost).all(|&n| n >= 10), "{total:?}");
}
