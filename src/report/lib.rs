//! Results as plain data, and their forms: JSON for programs, text for people, pages and pictures.
//!
//! - [`Report`]: what all reports have; [`CheckReport`] is that of `meliora check`.
//! - [`Header`]: the model and the settings of a report.
//! - [`page::Content`]: an interactive page, or a picture.
//!
//! A report is filled in step by step. Unknown values are `None` (JSON `null`), so a run that hits
//! a limit still reports its partial results. Nothing in this module prints.
//!
//! # An example
//!
//! ```
//! use meliora_report::{CheckReport, Header, Report, Style};
//!
//! let report = CheckReport::new(Header::of_model("grid.prism"));
//! assert!(report.text(Style::PLAIN).starts_with("grid.prism"));
//! assert_eq!(serde_json::to_value(&report).unwrap()["schema"], "meliora.check/1");
//! ```

pub mod check;
pub mod choose;
pub mod columns;
pub mod compare;
pub mod cycle;
pub mod envelope;
pub(crate) mod explicit;
pub(crate) mod export;
pub mod fields;
pub(crate) mod header;
pub mod info;
pub mod mix;
pub mod node_file;
mod node_lines;
pub mod page;
pub mod players;
pub mod plot;
pub mod policy;
pub mod policy_file;
mod policy_names;
pub mod policy_report;
pub mod promised;
pub mod properties;
pub mod property_policy;
pub mod query;
pub mod reach;
pub mod reason;
pub mod report;
pub mod schema;
pub mod shield;
pub mod simulate;
pub mod simulate_csv;
pub mod state;
pub mod strategy;
pub mod strategy_table;
pub(crate) mod style;
pub mod sweep;
pub mod values;
pub(crate) mod verify;

#[cfg(test)]
mod python_types;
mod ranks;
mod simulate_text;
mod state_text;
#[cfg(test)]
mod tables;
mod text;
mod unsafe_start;
mod values_text;
#[cfg(test)]
mod written;

pub use check::CheckReport;
pub use compare::CompareReport;
pub use explicit::ExplicitReport;
pub use export::{ExportReport, WrittenRegions};
pub use header::Header;
pub use info::InfoReport;
pub use meliora_question::Number;
pub use page::PageReport;
pub use policy_report::PolicyReport;
pub use query::QueryReport;
pub use reach::ReachReport;
pub use report::FailureKind;
pub use report::{Failure, Report};
pub use shield::ShieldReport;
pub use simulate::SimulateReport;
pub use strategy::{StrategyReport, Written};
pub use style::Style;
pub use values::ValuesReport;
pub use verify::VerifyReport;

/// The derivation of the schema of a report.
type Raw = fn(&mut schemars::SchemaGenerator) -> serde_json::Value;

/// The reports with the names of their schemas.
const REPORTS: &[(&str, Raw)] = &[
    ("check", schema::raw::<CheckReport>),
    ("compare", schema::raw::<CompareReport>),
    ("error", schema::raw::<Failure>),
    ("export", schema::raw::<ExportReport>),
    ("export", schema::raw::<ExplicitReport>),
    ("info", schema::raw::<InfoReport>),
    ("policy", schema::raw::<PolicyReport>),
    ("query", schema::raw::<QueryReport>),
    ("reach", schema::raw::<ReachReport>),
    ("report", schema::raw::<PageReport>),
    ("shield", schema::raw::<ShieldReport>),
    ("simulate", schema::raw::<SimulateReport>),
    ("strategy", schema::raw::<StrategyReport>),
    ("sweep", schema::raw::<sweep::SweepReport>),
    ("values", schema::raw::<ValuesReport>),
    ("verify", schema::raw::<VerifyReport>),
];
