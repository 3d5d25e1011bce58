//! Values whose states are listed by several threads: the same results, and cancellation.

use std::fs;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::thread::{self, ThreadId};

use meliora::advanced::any::AnyStates;
use meliora::advanced::symbolic::Thresholds;
use meliora::engine::{AnyEngine, Engine, ProgressSink, Scope, Settings, Storage};
use meliora::error::{Error, Limit, SourceFile};
use meliora::generate::{Choices, Parameters, gridworld};
use meliora::lang;
use meliora::model::Program;
use meliora::model::preference::Preferences;
use meliora::planning::{Analysis, Options, Safety};
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

/// The values of all states, and of the states that the initial ones reach.
fn values(case: &Case, settings: Settings, safety: Safety) -> Vec<StateValues> {
    let analysis = analysed(case, settings, safety);
    [analysis.engine().initial_states(), analysis.engine().all_states()]
        .iter()
        .flat_map(|starts| values_of(case, &analysis, starts).unwrap())
        .collect()
}

fn analysed((program, preferences): &Case, settings: Settings, safety: Safety) -> Analysis<AnyEngine> {
    let engine = Arc::new(AnyEngine::new(Arc::clone(program), settings).unwrap());
    let mut analysis = Analysis::new(&engine, preferences, Options { safety, max_level: None });
    analysis.run(&mut |_| ()).unwrap();
    analysis
}

fn values_of(
    (program, _): &Case,
    analysis: &Analysis<AnyEngine>,
    starts: &AnyStates,
) -> Result<Vec<StateValues>, Error> {
    let options = ValueOptions { levels: 3, exact: false, within: Some(3) };
    let starts = analysis.engine().list_states(starts, usize::MAX)?;
    let values = Values::compute(options, analysis, program, &starts, &Steps)?;
    StateValues::all(analysis, program, &values, &starts)
}

/// Compares the values of one, two and four threads.
fn compare(name: &str, case: &Case, scopes: &[Scope]) {
    for &scope in scopes {
        for storage in Storage::ALL.iter().copied() {
            for &safety in Safety::ALL {
                let settings = |threads| Settings { scope, storage, ..settings(threads) };
                let expected = values(case, settings(1), safety);
                for threads in [2, 4] {
                    let found = values(case, settings(threads), safety);
                    assert!(found == expected, "{name}, {scope:?}, {safety}, {threads} threads");
                }
            }
        }
    }
}

#[test]
fn random_worlds_have_the_same_values_with_each_number_of_threads() {
    for seed in 0..3 {
        compare("grid", &grid(seed, ""), &[Scope::Reachable]);
    }
}

#[test]
fn requirements_and_temporal_objectives_have_the_same_values_with_each_number_of_threads() {
    for seed in 0..2 {
        compare("grid", &grid(seed, "require G !\"at_A\";"), &[Scope::Reachable]);
        let temporal = "objective Both = F (\"at_A\" & F \"at_C\"); prefer Both > C; history = play;";
        compare("grid", &grid(seed, temporal), &[Scope::Reachable]);
    }
}

#[test]
fn the_models_have_the_same_values_with_each_number_of_threads() {
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
fn a_cancellation_inside_a_thread_ends_the_run_and_another_run_completes_it() {
    let case = grid(3, "");
    let mut cancelled = 0;
    for &safety in Safety::ALL {
        let expected = values(&case, settings(1), safety);
        for patience in [0, 3, 20, 60, 150, 400] {
            let sink = Arc::new(StopOthers { home: thread::current().id(), patience: patience.into() });
            let analysis = analysed(&case, Settings { sink: sink.clone(), ..settings(2) }, safety);
            match values_of(&case, &analysis, &analysis.engine().all_states()) {
                Ok(_) => {}
                Err(Error::Limit(Limit::Interrupted)) => cancelled += 1,
                Err(other) => panic!("{other}"),
            }
            sink.patience.store(u64::MAX, Relaxed);
            let found = values_of(&case, &analysis, &analysis.engine().all_states()).unwrap();
            assert!(found.iter().all(|values| expected.contains(values)), "{safety}, {patience}");
        }
    }
    assert!(cancelled > 0);
}
