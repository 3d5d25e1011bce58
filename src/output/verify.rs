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

/// What `verify` found.
#[derive(Debug, Clone, Serialize)]
pub struct VerifyFindings {
    /// The directory of the dump.
    pub directory: String,
    /// Whether all conditions hold; none where that is not known.
    pub accepted: Option<bool>,
    /// The regions that were found to be right.
    pub checked: Vec<CheckedRegion>,
    /// The first condition that does not hold.
    pub violation: Option<Violated>,
}

/// The report with what it took.
pub type VerifyReport = Envelope<VerifyFindings>;

/// A region that was found to be right.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct CheckedRegion {
    /// Its name.
    pub region: String,
    /// Whether it was shown to have no state too many.
    pub inside: bool,
    /// Whether it was shown to have no state too few.
    pub outside: bool,
}

/// A condition that does not hold.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Violated {
    /// The condition.
    pub condition: String,
    /// A state for which it fails.
    pub state: Option<Map<String, Json>>,
}

impl VerifyReport {
    /// A report of which nothing but the question is known.
    pub fn new(directory: &str) -> Self {
        Envelope::of(VerifyFindings {
            directory: directory.to_owned(),
            accepted: None,
            checked: Vec::new(),
            violation: None,
        })
    }

    /// Notes the verdict.
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
                (true, true) => "no state too many, none too few",
                (true, false) => "no state too many",
                (false, true) => "no state too few (whether it has too many was not checked)",
                (false, false) => "not checked",
            };
            let _ = writeln!(out, "{:<32} {halves}", checked.region);
        }
        if let Some(violation) = &report.violation {
            let _ = writeln!(out, "\n{}: this does not hold: {}", style.bad("refused"), violation.condition);
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
