//! What all reports have around what they found: which report it is, whether it is whole, what it took.

use std::ops::{Deref, DerefMut};

use serde::Serialize;

use super::report::{Failure, MemoryUse, Report};
use super::style::Style;

/// What a command found.
pub trait Findings: Serialize + Sized {
    /// The name and version of the report, such as `meliora.check/1`.
    const SCHEMA: &'static str;
    /// Seconds by phase.
    type Time: Time;

    /// The report for people.
    fn text(report: &Envelope<Self>, style: Style) -> String;

    /// Whether the question asked for a yes or a no, and the answer is no.
    fn is_no(&self) -> bool {
        false
    }
}

/// Seconds by phase.
pub trait Time: Serialize + Default {
    /// Those of everything.
    fn total(&mut self) -> &mut f64;
}

/// The seconds of a run.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Total {
    /// Everything.
    pub total: f64,
}

impl Time for Total {
    fn total(&mut self) -> &mut f64 {
        &mut self.total
    }
}

/// A report, in the order in which JSON has it.
#[derive(Debug, Clone, Serialize)]
pub struct Envelope<F: Findings> {
    /// Which report it is.
    pub schema: &'static str,
    /// Whether the work ran to its end; written only where it did not.
    #[serde(skip_serializing_if = "is_true")]
    pub complete: bool,
    /// What was found.
    #[serde(flatten)]
    pub findings: F,
    /// Seconds by phase.
    pub time: F::Time,
    /// What was used.
    pub memory: MemoryUse,
    /// Why the work ended early.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<Failure>,
}

impl<F: Findings> Envelope<F> {
    /// A report of which nothing else is known.
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

/// For `complete`, which is written only where it is false.
#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde hands out references")]
pub(super) fn is_true(flag: &bool) -> bool {
    *flag
}
