//! The common frame of all reports: schema, completeness, times and memory.

use std::ops::{Deref, DerefMut};

use serde::Serialize;

use super::report::{Failure, MemoryUse, Report};
use super::style::Style;

/// The results of a command.
pub trait Findings: Serialize + Sized {
    /// The name and version of the report, such as `meliora.check/1`.
    const SCHEMA: &'static str;
    /// Seconds by phase.
    type Time: Time;

    /// Renders the report as text.
    fn text(report: &Envelope<Self>, style: Style) -> String;

    /// Returns whether the question was a yes/no question and the answer is no.
    fn is_no(&self) -> bool {
        false
    }
}

/// Seconds by phase.
pub trait Time: Serialize + Default {
    /// Returns the total seconds.
    fn total(&mut self) -> &mut f64;
}

/// The seconds of a command.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Total {
    /// The total.
    pub total: f64,
}

impl Time for Total {
    fn total(&mut self) -> &mut f64 {
        &mut self.total
    }
}

/// A report, in the order of the JSON fields.
#[derive(Debug, Clone, Serialize)]
pub struct Envelope<F: Findings> {
    /// The name and version of the report.
    pub schema: &'static str,
    /// False if the work ended early; written only in that case.
    #[serde(skip_serializing_if = "is_true")]
    pub complete: bool,
    /// The results.
    #[serde(flatten)]
    pub findings: F,
    /// Seconds by phase.
    pub time: F::Time,
    /// The memory used.
    pub memory: MemoryUse,
    /// The reason why the work ended early.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<Failure>,
}

impl<F: Findings> Envelope<F> {
    /// Creates a report with these results.
    pub(super) fn of(findings: F) -> Self {
        let (time, memory) = (F::Time::default(), MemoryUse::default());
        Envelope { schema: F::SCHEMA, complete: true, findings, time, memory, error: None }
    }
}

impl<F: Findings> Deref for Envelope<F> {
    type Target = F;

    fn deref(&self) -> &F {
        &self.findings
    }
}

impl<F: Findings> DerefMut for Envelope<F> {
    fn deref_mut(&mut self) -> &mut F {
        &mut self.findings
    }
}

impl<F: Findings> Report for Envelope<F> {
    fn fail(&mut self, failure: Failure) {
        self.complete = false;
        self.error = Some(failure);
    }

    fn finish(&mut self, seconds: f64, peak_rss_bytes: u64) {
        *self.time.total() = seconds;
        self.memory.peak_rss_bytes = peak_rss_bytes;
    }

    fn text(&self, style: Style) -> String {
        F::text(self, style)
    }

    fn is_no(&self) -> bool {
        self.findings.is_no()
    }
}

/// Returns true for `complete` fields that are left out of JSON.
#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde hands out references")]
pub(super) fn is_true(flag: &bool) -> bool {
    *flag
}
