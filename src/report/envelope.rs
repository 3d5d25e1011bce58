//! The common frame of all reports: header, completeness, times and memory.

use std::ops::{Deref, DerefMut};

use serde::{Serialize, Serializer};

use super::header::Header;
use super::report::{Failure, MemoryUse, Report};
use super::style::Style;
use super::text;

/// The results of a command.
pub trait Findings: Serialize + Sized {
    /// The name and version of the report, such as `meliora.check/1`.
    const SCHEMA: &'static str;
    /// The timed phases: their names in JSON and in text.
    const PHASES: &'static [(&'static str, &'static str)] = &[];

    /// Returns the settings of this command, which precede those of the header.
    fn settings(&self) -> Vec<(&'static str, String)> {
        Vec::new()
    }

    /// Renders the results as text.
    fn body(report: &Envelope<Self>, style: Style) -> String;

    /// Renders the whole report as text.
    fn text(report: &Envelope<Self>, style: Style) -> String {
        report.full_text(style)
    }

    /// Returns whether the question was a yes/no question and the answer is no.
    fn is_no(&self) -> bool {
        false
    }
}

/// Seconds by phase; `None` for an unfinished phase.
#[derive(Debug, Clone, PartialEq)]
pub struct Times {
    phases: Vec<(&'static str, &'static str, Option<f64>)>,
    /// The total.
    pub total: f64,
}

impl Times {
    /// Creates the times of a report in which no phase is finished.
    pub fn of<F: Findings>() -> Self {
        Times { phases: F::PHASES.iter().map(|&(name, label)| (name, label, None)).collect(), total: 0.0 }
    }

    /// Adds seconds to a phase. Phases that the report does not list are not timed.
    pub fn add(&mut self, phase: &str, seconds: f64) {
        if let Some((_, _, sum)) = self.phases.iter_mut().find(|(name, ..)| *name == phase) {
            *sum = Some(sum.unwrap_or(0.0) + seconds);
        }
    }

    /// Returns the phases with their labels in text.
    pub fn phases(&self) -> impl Iterator<Item = (&'static str, Option<f64>)> {
        self.phases.iter().map(|&(_, label, seconds)| (label, seconds))
    }
}

impl Serialize for Times {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let phases = self.phases.iter().map(|&(name, _, seconds)| (name, seconds));
        serializer.collect_map(phases.chain([("total", Some(self.total))]))
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
    /// The model and the settings.
    #[serde(flatten)]
    pub header: Header,
    /// The results.
    #[serde(flatten)]
    pub findings: F,
    /// Seconds by phase.
    pub time: Times,
    /// The memory used.
    pub memory: MemoryUse,
    /// The reason why the work ended early.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<Failure>,
}

impl<F: Findings> Envelope<F> {
    /// Creates a report with these results.
    pub(crate) fn of(header: Header, findings: F) -> Self {
        let (time, memory) = (Times::of::<F>(), MemoryUse::default());
        Envelope { schema: F::SCHEMA, complete: true, header, findings, time, memory, error: None }
    }
}

impl<F: Findings> Envelope<F> {
    /// Renders the inputs and settings, the results, times and memory.
    pub(super) fn full_text(&self, style: Style) -> String {
        let mut out = self.header.title(self.settings(), style);
        out += &F::body(self, style);
        out += &self.incomplete(style);
        out + &self.footer(style)
    }

    /// Renders the note for work that ended early.
    pub(super) fn incomplete(&self, style: Style) -> String {
        incomplete(self.error.as_ref(), style)
    }

    /// Renders the last lines: seconds by phase, nodes and memory.
    fn footer(&self, style: Style) -> String {
        let phases = self.time.phases();
        let phases = phases.filter_map(|(name, took)| Some(format!("{name} {}", text::seconds(took?))));
        let (phases, total) = (phases.collect::<Vec<_>>().join(", "), text::seconds(self.time.total));
        let colon = if phases.is_empty() { "" } else { ": " };
        let mut out = format!("\n{}\n", style.dim(&format!("{total} in all{colon}{phases}")));
        let mut used = Vec::new();
        if self.memory.peak_nodes > 0 {
            used.push(format!("{} nodes at most", text::grouped(self.memory.peak_nodes)));
        }
        if self.memory.peak_rss_bytes > 0 {
            used.push(format!("{} of memory at most", text::bytes(self.memory.peak_rss_bytes)));
        }
        if !used.is_empty() {
            out += &format!("{}\n", style.dim(&used.join(", ")));
        }
        out
    }
}

impl<F: Findings + Default> Envelope<F> {
    /// Creates a report without results.
    pub fn new(header: Header) -> Self {
        Envelope::of(header, F::default())
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
        self.time.total = seconds;
        self.memory.peak_rss_bytes = peak_rss_bytes;
    }

    fn text(&self, style: Style) -> String {
        F::text(self, style)
    }

    fn is_no(&self) -> bool {
        self.findings.is_no()
    }
}

/// Renders the note for work that ended early.
pub(super) fn incomplete(failure: Option<&Failure>, style: Style) -> String {
    let note = "Incomplete: these are the partial results when the work stopped.";
    failure.map_or_else(String::new, |_| format!("\n{}\n", style.warn(note)))
}

/// Returns true for `complete` fields that are left out of JSON.
#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde hands out references")]
pub(super) fn is_true(flag: &bool) -> bool {
    *flag
}
