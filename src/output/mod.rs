//! Results as plain data, and their two forms: JSON for programs, text for people.
//!
//! A report is filled in step by step. Unknown values are `None` (JSON `null`), so a run that hits
//! a limit still reports its partial results. Nothing in this module prints.

pub mod check;
pub mod choose;
pub mod compare;
pub mod envelope;
pub mod explicit;
pub mod export;
pub mod header;
pub mod info;
pub mod number;
pub mod page;
pub mod properties;
pub mod query;
pub mod reach;
pub mod reason;
pub mod report;
pub mod simulate;
pub mod state;
pub mod strategy;
pub mod strategy_table;
pub mod style;
pub mod values;
pub mod verify;

mod ranks;
mod simulate_text;
mod state_text;
mod text;
mod unsafe_start;
mod values_text;

pub use check::CheckReport;
pub use compare::CompareReport;
pub use explicit::ExplicitReport;
pub use export::ExportReport;
pub use header::Header;
pub use info::InfoReport;
pub use number::Number;
pub use page::PageReport;
pub use properties::PropertiesReport;
pub use query::QueryReport;
pub use reach::ReachReport;
pub use report::{Failure, FailureKind, Report};
pub use simulate::SimulateReport;
pub use strategy::StrategyReport;
pub use style::Style;
pub use values::ValuesReport;
pub use verify::VerifyReport;
