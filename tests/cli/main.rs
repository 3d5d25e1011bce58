//! The command line as users see it: standard output, standard error and exit statuses.

mod at;
mod browser;
mod choose;
mod common;
mod compare;
mod dumps;
mod exact;
mod exchange;
mod expect;
mod explicit;
#[cfg(unix)]
mod files;
mod games;
mod generate;
mod jani;
mod json;
mod json_page;
#[cfg(unix)]
mod limits;
mod memory;
mod output;
mod properties;
mod quantities;
mod readme;
mod report;
mod requirements;
mod settings;
mod status;
mod strategies;
mod sweeps;
mod temporal;
mod values;
