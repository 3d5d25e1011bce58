//! Results as plain data, and their two forms: JSON for programs, text for people.
//!
//! A report is filled in step by step. Unknown values are `None` (JSON `null`), so a run that hits
//! a limit still reports its partial results. Nothing in this module prints.

pub(crate) mod check;
pub mod choose;
pub(crate) mod compare;
pub(crate) mod envelope;
pub(crate) mod explicit;
pub(crate) mod export;
pub(crate) mod header;
pub(crate) mod info;
pub(crate) mod number;
pub mod page;
pub(crate) mod properties;
pub(crate) mod query;
pub(crate) mod reach;
pub mod reason;
pub(crate) mod report;
pub(crate) mod simulate;
pub(crate) mod state;
pub(crate) mod strategy;
pub(crate) mod strategy_table;
pub(crate) mod style;
pub(crate) mod values;
pub(crate) mod verify;

mod ranks;
mod simulate_text;
mod state_text;
mod text;
mod unsafe_start;
mod values_text;

pub use check::CheckReport;
pub(crate) use compare::CompareReport;
pub(crate) use explicit::ExplicitReport;
pub(crate) use export::ExportReport;
pub use header::Header;
pub(crate) use info::InfoReport;
pub use number::Number;
pub(crate) use page::PageReport;
pub(crate) use properties::PropertiesReport;
pub(crate) use query::QueryReport;
pub(crate) use reach::ReachReport;
pub(crate) use report::FailureKind;
pub use report::{Failure, Report};
pub(crate) use simulate::SimulateReport;
pub(crate) use strategy::StrategyReport;
pub use style::Style;
pub(crate) use values::ValuesReport;
pub(crate) use verify::VerifyReport;
