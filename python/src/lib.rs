//! The compiled part of the Python package `meliora`: the types of the crate root as classes.
//!
//! Classes are frozen, and keep Python objects only to return them. Long work runs at a `worker`,
//! on a thread that never uses the interpreter. Each class has a file of its own.
//!
//! Each file imports only files of the lines before its own:
//!
//! - `arrays`, `display`, `errors`, `progress`, `region_export`
//! - `files`, `shield_table`, `values`, `worker`
//! - `options`, `preferences`, `region`
//! - `explanation`, `handle`, `shield`, `simulation`
//! - `strategy`, `levels`, `analysis`, `exploration`, `model`, `dump`, each of which may use the others

mod analysis;
mod arrays;
mod asking;
mod display;
mod dump;
mod errors;
mod explanation;
mod exploration;
mod files;
mod handle;
mod levels;
mod model;
mod options;
mod play;
mod preferences;
mod progress;
mod region;
mod region_export;
mod shield;
mod shield_table;
mod simulation;
mod strategy;
mod values;
mod variable;
mod worker;

use pyo3::prelude::*;

#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<model::Model>()?;
    module.add_class::<variable::Variable>()?;
    module.add_class::<preferences::Preferences>()?;
    module.add_class::<exploration::Exploration>()?;
    module.add_class::<exploration::Reachability>()?;
    module.add_class::<analysis::Analysis>()?;
    module.add_class::<levels::Levels>()?;
    module.add_class::<region::Region>()?;
    module.add_class::<region::RegionIterator>()?;
    module.add_class::<shield::Shield>()?;
    module.add_class::<strategy::Strategy>()?;
    module.add_class::<play::Play>()?;
    module.add_class::<explanation::Explanation>()?;
    module.add_class::<explanation::Action>()?;
    module.add_class::<explanation::Successor>()?;
    module.add_class::<simulation::Simulation>()?;
    module.add_class::<progress::Progress>()?;
    module.add_class::<dump::Dump>()?;
    module.add_class::<dump::Verdict>()?;
    module.add_function(wrap_pyfunction!(dump::verify, module)?)?;
    Ok(())
}
