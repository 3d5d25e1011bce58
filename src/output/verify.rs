//! The report of `meliora verify`.

use std::fmt::Write;

use serde::Serialize;
use serde_json::{Map, Value as Json};

use super::Style;
use super::envelope::{Envelope, Findings, Total};
use super::report::{json_state, show_state};
use super::text;
use crate::certify::Verdict;
use crate::model::Program;

/// The results of `verify`.
#[derive(Debug, Clone, Serialize)]
pub struct VerifyFindings {
    /// The directory of the dump.
    pub directory: String,
    /// True if all conditions hold; `None` if this is not known.
    pub accepted: Option<bool>,
    /// The regions that were found correct.
    pub checked: Vec<CheckedRegion>,
    /// The first violated condition.
    pub violation: Option<Violated>,
}

/// The report with times and memory.
pub type VerifyReport = Envelope<VerifyFindings>;

/// A region that was found correct.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct CheckedRegion {
    /// Its name.
    pub region: String,
    /// True if the region was shown to contain no wrong state.
    pub inside: bool,
    /// True if the region was shown to miss no state.
    pub outside: bool,
}

/// A violated condition.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Violated {
    /// The condition.
    pub condition: String,
    /// A state that violates it.
    pub state: Option<Map<String, Json>>,
}

impl VerifyReport {
    /// Creates a report without results.
    pub fn new(directory: &str) -> Self {
        Envelope::of(VerifyFindings {
            directory: directory.to_owned(),
            accepted: None,
            checked: Vec::new(),
            violation: None,
        })
    }

    /// Adds the verdict.
    pub fn set(&mut self, program: &Program, verdict: &Verdict) {
        let region = |c: &crate::certify::Checked| CheckedRegion {
            region: c.region.clone(),
            inside: c.inside,
            outside: c.outside,
        };
        self.checked = verdict.checked.iter().map(region).collect();
        self.accepted = Some(verdict.violation.is_none());
        self.violation = verdict.violation.as_ref().map(|v| Violated {
            condition: v.condition.clone(),
            state: v.state.as_ref().map(|s| json_state(program, s)),
        });
    }
}

impl Findings for VerifyFindings {
    const SCHEMA: &str = "meliora.verify/1";
    type Time = Total;

    fn text(report: &VerifyReport, style: Style) -> String {
        let mut out = String::new();
        for checked in &report.checked {
            let halves = match (checked.inside, checked.outside) {
                (true, true) => "no wrong states, no missing states",
                (true, false) => "no wrong states",
                (false, true) => "no missing states (wrong ones not checked)",
                (false, false) => "not checked",
            };
            let _ = writeln!(out, "{:<32} {halves}", checked.region);
        }
        if let Some(violation) = &report.violation {
            let _ = writeln!(
                out,
                "\n{}: this condition is violated: {}",
                style.bad("refused"),
                violation.condition
            );
            if let Some(state) = &violation.state {
                let _ = writeln!(out, "  for example in the state {}", show_state(state));
            }
        }
        if report.accepted == Some(true) {
            let _ = writeln!(out, "\n{}: all conditions hold", style.good("accepted"));
        }
        out.push_str(&text::incomplete(report.error.as_ref(), style));
        out
    }

    fn is_no(&self) -> bool {
        self.accepted == Some(false)
    }
}
