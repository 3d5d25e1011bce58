//! Analyses on several threads: the same results in the same order, limits and cancellation.

use std::fs;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::thread::{self, ThreadId};

use meliora::advanced::any::{AnyChoices, AnyStates};
use meliora::advanced::symbolic::Thresholds;
use meliora::engine::{Algebra, AnyEngine, Engine, ProgressSink, Scope, Settings, Storage};
use meliora::error::{Error, Limit, SourceFile};
use meliora::generate::{Choices, Parameters, gridworld};
use meliora::lang;
use meliora::model::Program;
use meliora::model::preference::Preferences;
use meliora::planning::levels::{End, Level};
use meliora::planning::{Analysis, Kind, Options, Phase, Safety};
use meliora::quantities::state_values::StateValues;
use meliora::quantities::{Steps, ValueOptions, Values};

type Case = (Arc<Program>, Arc<Preferences>);

fn case(model: &str, constants: &str, preferences: &str) -> Case {
    let constants = SourceFile::new("constants", constants);
    let mut program = lang::load(&SourceFile::new("m", model), &constants).unwrap().program;
    let preferences = SourceFile::new("p", preferences);
    let preferences = lang::load_preferences(&preferences, &mut program).unwrap();
    (Arc::new(program), Arc::new(preferences))
}

/// A random grid world with three items, and more preferences in its file.
fn grid(seed: u64, more: &str) -> Case {
    let parameters = Parameters::new(3, 4 + seed as usize % 2, 3);
    let written = gridworld(&parameters, &Choices { seed, ..Choices::default() }).unwrap();
    case(&written.model, "", &(written.preferences + more))
}

/// Settings with which the smallest model is worked on by several threads.
fn settings(threads: u32) -> Settings {
    let thresholds = Thresholds { nodes_for_threads: 0, ..Thresholds::default() };
    Settings { threads, thresholds, memory: 256 << 20, ..Settings::default() }
}

/// The events of an analysis, and the states of all its sets.
fn everything((program, preferences): &Case, settings: Settings, safety: Safety) -> Vec<String> {
    let engine = Arc::new(AnyEngine::new(Arc::clone(program), settings).unwrap());
    let mut analysis = Analysis::new(&engine, preferences, Options { safety, max_level: None });
    let mut found = Vec::new();
    analysis.run(&mut |event| found.push(format!("{event:?}"))).unwrap();
    found.push(format!("{:?}", analysis.result()));
    let engine = analysis.engine();
    let states =
        |what: &str, x: &AnyStates| format!("{what}: {:?}", engine.list_states(x, usize::MAX).unwrap());
    let choices = |what: &str, c: &AnyChoices| {
        let sources = states(what, &engine.sources(c).unwrap());
        format!("{sources}, {} choices", engine.count(c).unwrap())
    };
    let outcomes = analysis.outcomes().unwrap();
    for regions in (0..preferences.objectives.len()).map(|i| outcomes.get(i).unwrap()) {
        found
            .extend([&regions.target, &regions.positive, &regions.almost_sure].map(|x| states("regions", x)));
    }
    for arena in &analysis.improvement().unwrap().arenas {
        found.push(choices("arena", &arena.choices));
    }
    for levels in Kind::ALL.iter().map(|&kind| analysis.levels(kind)) {
        let mut level = |level: &Level<AnyEngine>| {
            found.push(states("level", &level.states));
            found.extend(level.games.iter().map(|game| choices("game", &game.choices)));
        };
        levels.found.iter().for_each(&mut level);
        levels.unbounded().map(level);
        assert!(levels.end.as_ref().is_some_and(|end| !matches!(end, End::Cut)));
    }
    found
}

/// The values of all states, and of the states that the initial ones reach.
fn values((program, preferences): &Case, settings: Settings, safety: Safety) -> Vec<StateValues> {
    let engine = Arc::new(AnyEngine::new(Arc::clone(program), settings).unwrap());
    let mut analysis = Analysis::new(&engine, preferences, Options { safety, max_level: None });
    analysis.run(&mut |_| ()).unwrap();
    let options = ValueOptions { levels: 3, exact: false, within: Some(3) };
    let mut found = Vec::new();
    for starts in [engine.initial_states(), engine.all_states()] {
        let starts = engine.list_states(&starts, usize::MAX).unwrap();
        let values = Values::compute(options, &analysis, program, &starts, &Steps).unwrap();
        found.extend(StateValues::all(&analysis, program, &values, &starts).unwrap());
    }
    found
}

/// Compares the results of one, two and four threads.
fn compare(name: &str, case: &Case, scopes: &[Scope]) {
    for &scope in scopes {
        for storage in Storage::ALL.iter().copied() {
            for &safety in Safety::ALL {
                let settings = |threads| Settings { scope, storage, ..settings(threads) };
                let expected = everything(case, settings(1), safety);
                let expected_values = values(case, settings(1), safety);
                for threads in [2, 4] {
                    let found = everything(case, settings(threads), safety);
                    assert!(found == expected, "{name}, {scope:?}, {safety}, {threads} threads");
                    let found = values(case, settings(threads), safety);
                    assert!(
                        found == expected_values,
                        "{name}, {scope:?}, {safety}, {threads} threads: values"
                    );
                }
            }
        }
    }
}

#[test]
fn random_worlds_have_the_same_results_with_each_number_of_threads() {
    for seed in 0..3 {
        compare("grid", &grid(seed, ""), &[Scope::Reachable]);
    }
}

#[test]
fn requirements_and_temporal_objectives_have_the_same_results_with_each_number_of_threads() {
    for seed in 0..2 {
        compare("grid", &grid(seed, "require G !\"at_A\";"), &[Scope::Reachable]);
        let temporal = "objective Both = F (\"at_A\" & F \"at_C\"); prefer Both > C; history = play;";
        compare("grid", &grid(seed, temporal), &[Scope::Reachable]);
    }
}

#[test]
fn the_models_have_the_same_results_with_each_number_of_threads() {
    for (name, constants) in [
        ("chain", "N=4"),
        ("counter", ""),
        ("courier", ""),
        ("drone", ""),
        ("lateral", ""),
        ("lateral_prefix", ""),
        ("patrol", "N=2"),
        ("pond", ""),
        ("ring", "N=8,T=3"),
        ("toy", ""),
    ] {
        let path = |extension| Path::new("models").join(name).with_extension(extension);
        let [model, preferences] = ["prism", "pref"].map(|e| fs::read_to_string(path(e)).unwrap());
        compare(name, &case(&model, constants, &preferences), Scope::ALL);
    }
}

/// Stops the work of all threads except for one.
struct StopOthers {
    home: ThreadId,
    /// The questions that are answered by "continue" before.
    patience: AtomicU64,
}

impl ProgressSink for StopOthers {
    fn stop(&self) -> Option<Limit> {
        let continues = || self.patience.fetch_update(Relaxed, Relaxed, |left| left.checked_sub(1)).is_ok();
        (thread::current().id() != self.home && !continues()).then_some(Limit::Interrupted)
    }
}

#[test]
fn a_cancellation_inside_a_worker_ends_the_run_and_another_run_completes_it() {
    let case = grid(3, "");
    // How often a worker gets work before the thread of the caller has done it all depends on the system.
    let mut cancelled = 0;
    for &safety in Safety::ALL {
        let expected = everything(&case, settings(1), safety);
        for patience in [0, 3, 20, 60, 150, 400] {
            let sink = Arc::new(StopOthers { home: thread::current().id(), patience: patience.into() });
            let settings = Settings { sink: sink.clone(), ..settings(2) };
            let engine = Arc::new(AnyEngine::new(case.0.clone(), settings).unwrap());
            let mut analysis = Analysis::new(&engine, &case.1, Options { safety, max_level: None });
            match analysis.run(&mut |_| ()) {
                Ok(()) => {}
                Err(Error::Limit(Limit::Interrupted)) => cancelled += 1,
                Err(other) => panic!("{other}"),
            }
            sink.patience.store(u64::MAX, Relaxed);
            analysis.run(&mut |_| ()).unwrap();
            assert!(analysis.is_done(Phase::Spi));
            assert!(expected.contains(&format!("{:?}", analysis.result())), "{safety}, {patience}");
        }
    }
    assert!(cancelled > 0);
}
