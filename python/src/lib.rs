//! The compiled part of the Python package `meliora`: the types of the crate root as classes.
//!
//! Classes are frozen, and keep Python objects only to return them. Long work runs at a `worker`,
//! on a thread that never uses the interpreter. Each class has a file of its own.
//!
//! Each file imports only files of the lines before its own:
//!
//! - `arrays`, `display`, `errors`, `progress`, `region_export`
//! - `files`, `values`, `worker`
//! - `options`, `preferences`, `region`
//! - `explanation`, `handle`, `shield`, `simulation`
//! - `strategy`, `levels`, `analysis`, `exploration`, `model`, `asking`, `policies`, `dump`, `export`, `sweep`, each of which may use the others

mod analysis;
mod arrays;
mod asking;
mod display;
mod dump;
mod errors;
mod explanation;
mod exploration;
mod export;
mod files;
mod handle;
mod levels;
mod model;
mod options;
mod play;
mod policies;
mod preferences;
mod progress;
mod region;
mod region_export;
mod shield;
mod simulation;
mod strategy;
mod sweep;
mod values;
mod variable;
mod worker;

/// The compiled part of the package.
#[pyo3::pymodule]
mod _native {
    #[pymodule_export]
    #[expect(non_upper_case_globals, reason = "the name is that of Python")]
    const __version__: &str = env!("CARGO_PKG_VERSION");

    #[pymodule_export]
    use crate::{
        analysis::Analysis,
        dump::{Dump, Verdict, verify},
        explanation::{Action, Explanation, Successor},
        exploration::{Exploration, Reachability},
        levels::Levels,
        model::Model,
        play::Play,
        preferences::Preferences,
        progress::Progress,
        region::{Region, RegionIterator},
        shield::Shield,
        simulation::Simulation,
        strategy::Strategy,
        sweep::{Answers, Columns, Rows},
        variable::Variable,
    };
}
