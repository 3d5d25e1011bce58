//! The command line as users see it: standard output, standard error and exit statuses.

/// Runs the command with formatted arguments.
macro_rules! run {
    ($($arguments:tt)*) => {
        $crate::cli::common::run(&format!($($arguments)*))
    };
}

mod aims;
mod answers;
mod at;
mod boxes;
mod browser;
mod choose;
pub(crate) mod common;
pub(crate) mod direction;
mod dump_files;
mod dumps;
mod exact;
mod exchange;
mod expect;
mod explicit;
#[cfg(unix)]
mod files;
mod foreign;
mod forms;
mod game_report;
mod games;
mod generate;
mod initial;
mod jani;
mod jani_names;
mod jani_properties;
mod json;
mod json_page;
#[cfg(unix)]
mod limits;
mod memory;
mod memory_policies;
mod mix;
mod models;
mod names;
mod nested;
mod optimal;
mod output;
mod partial;
mod pddl_files;
mod phases;
mod planning;
mod policies;
mod promises;
mod properties;
mod prospects;
mod quantities;
mod readme;
mod regions;
mod report;
mod requirements;
mod schema;
mod settings;
mod shield;
mod status;
mod stopping;
mod strategies;
mod sweeps;
mod tables;
mod temporal;
mod values;
mod verdicts;
mod words;
