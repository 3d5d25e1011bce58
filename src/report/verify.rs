//! The report of `meliora verify`.

use std::collections::BTreeMap;
use std::fmt::Write;

use schemars::JsonSchema;
use serde::Serialize;

use super::Style;
use super::envelope::{Envelope, Findings};
use super::header::Header;
use meliora_base::escape;
use meliora_certify::{Checked, INFORMATIVE, Verdict};
use meliora_dump::Manifest;
use meliora_model::Program;
use meliora_model::valuation::Valuation;

/// The results of `verify`.
#[derive(Debug, Clone, Default, Serialize, JsonSchema)]
#[schemars(rename = "verify")]
pub struct VerifyFindings {
    /// The directory of the dump.
    pub directory: String,
    /// All conditions hold, and all regions are certified; `null` if unknown.
    pub accepted: Option<bool>,
    /// The settings that the check took from the dump: `constants`, `scope`, `safety`, `empty`, `history`,
    /// `max_level`, and for the values `reward` and `levels`. Nobody proves that the user meant these. Empty if the
    /// dump was not read.
    pub taken: BTreeMap<String, String>,
    /// The regions that were found to be right; empty if the check ended before the first.
    pub checked: Vec<Checked>,
    /// The regions, and `values.csv`, that the certificate does not prove, because a limit ended `export`.
    pub uncertified: Vec<String>,
    /// The fields of the manifest that nothing proves: they inform only. Empty if the check did not end.
    pub unproved: Vec<String>,
    /// The first condition that does not hold; `null` if accepted or unknown.
    pub violation: Option<Violated>,
}

/// The report with times and memory.
pub type VerifyReport = Envelope<VerifyFindings>;

/// A violated condition.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Violated {
    /// The condition.
    pub condition: String,
    /// A state for which it fails; `null` if the condition is not about a state.
    pub state: Option<Valuation>,
}

impl VerifyReport {
    /// Creates a report without results.
    pub fn of_directory(directory: &str) -> Self {
        let directory = directory.to_owned();
        Envelope::with(Header::default(), VerifyFindings { directory, ..VerifyFindings::default() })
    }

    /// Adds what the check takes from the dump; long values are shortened.
    pub fn set_taken(&mut self, manifest: &Manifest) {
        let constants = manifest.given_constants();
        let values = manifest.values.as_ref();
        let all = [
            ("constants", Some(constants).filter(|given| !given.is_empty())),
            ("scope", Some(manifest.scope.clone())),
            ("safety", Some(manifest.safety.name().to_owned())),
            ("empty", Some(manifest.empty.clone())),
            ("history", manifest.history.clone()),
            ("max_level", manifest.max_level.map(|level| level.to_string())),
            ("reward", values.map(|values| values.reward.clone())),
            ("levels", values.map(|values| values.levels.to_string())),
        ];
        let given = all.into_iter().filter_map(|(name, value)| Some((name.to_owned(), value?)));
        self.taken = given.map(|(name, value)| (name, escape::shortened(&value).into_owned())).collect();
    }

    /// Adds the verdict.
    pub fn set(&mut self, program: &Program, verdict: &Verdict) {
        self.checked.clone_from(&verdict.checked);
        self.unproved = INFORMATIVE.iter().map(|&field| field.to_owned()).collect();
        self.uncertified.clone_from(&verdict.uncertified);
        // Uncertified regions are neither accepted nor refused.
        self.accepted = match verdict.violation {
            Some(_) => Some(false),
            None => verdict.is_accepted().then_some(true),
        };
        self.violation = verdict.violation.as_ref().map(|v| Violated {
            condition: v.condition.to_string(),
            state: v.state.as_ref().map(|s| Valuation::new(program, s)),
        });
    }
}

impl Findings for VerifyFindings {
    const SCHEMA: &str = "meliora.verify/1";
    const HEADER: (&[&str], &[&str]) = (&[], &[]);

    fn text(report: &VerifyReport, style: Style) -> String {
        Self::body(report, style) + &report.incomplete(style)
    }

    fn body(report: &VerifyReport, style: Style) -> String {
        let mut out = String::new();
        if !report.taken.is_empty() {
            let one = |(name, value): (&String, &String)| format!("{name} {}", escape::line(value));
            let all: Vec<String> = report.taken.iter().map(one).collect();
            let _ = writeln!(out, "taken from the dump: {}\n", all.join(", "));
        }
        for checked in &report.checked {
            let halves = match (checked.inside, checked.outside) {
                (true, true) => "no wrong states, no missing states",
                (true, false) => "no wrong states",
                (false, true) => "no missing states (wrong ones not checked)",
                (false, false) => "not checked",
            };
            let _ = writeln!(out, "{:<32} {halves}", checked.region);
        }
        for name in &report.uncertified {
            let _ = writeln!(out, "{:<32} not certified", escape::line(name));
        }
        if let Some(violation) = &report.violation {
            let _ = writeln!(
                out,
                "\n{}: this condition is violated: {}",
                style.bad("refused"),
                violation.condition
            );
            if let Some(state) = &violation.state {
                let _ = writeln!(out, "  for example in the state {}", state);
            }
        }
        if report.accepted == Some(true) {
            let _ = writeln!(out, "\n{}: all conditions hold", style.good("accepted"));
            let _ = writeln!(out, "information only, not proved: {}", report.unproved.join(", "));
        }
        out
    }

    fn is_no(&self) -> bool {
        self.accepted == Some(false)
    }
}
