//! The report of `meliora query`.

use std::fmt::Write;
use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Serialize, Serializer};

use super::envelope::{Envelope, Findings};
use super::header::Header;
use super::{Number, Style};
use meliora_base::escape;
use meliora_dump::manifest::RootKind;
use meliora_model::Program;
use meliora_model::valuation::Valuation;
use meliora_query::Member;

/// The text between the actions of a list, whose names may have blanks.
const BETWEEN: &str = " | ";

/// The results of `query`.
#[derive(Debug, Clone, Default, Serialize, JsonSchema)]
#[schemars(rename = "query")]
pub struct QueryFindings {
    /// The directory of the dump.
    pub directory: String,
    /// The region expression.
    pub region: String,
    /// The condition of `--where`; absent without it.
    #[serde(rename = "where", skip_serializing_if = "Option::is_none")]
    pub condition: Option<String>,
    /// The members of the region: `states` or `choices`; `null` if unknown.
    #[schemars(with = "Option<RootKind>")]
    pub kind: Option<&'static str>,
    /// The number of members; `null` with `--contains` or `--list`, unless `--count` is given too.
    pub count: Option<Number>,
    /// The answers to `--contains`; absent without it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub contains: Vec<Contained>,
    /// The states of `--list`; absent without it.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Vec<Listed>")]
    pub states: Option<Rows>,
    /// True if only the number is printed.
    #[serde(skip)]
    pub plain: bool,
}

/// The report with times and memory.
pub type QueryReport = Envelope<QueryFindings>;

/// Listed states of the selection. Each is formatted only when it is written.
#[derive(Debug, Clone)]
pub struct Rows {
    program: Arc<Program>,
    members: Arc<Vec<Member>>,
}

impl Rows {
    /// Creates the list of these members.
    pub fn new(program: &Arc<Program>, members: Vec<Member>) -> Self {
        Rows { program: Arc::clone(program), members: Arc::new(members) }
    }

    /// Returns the states as lines of comma-separated values, with a heading; `choices` says whether
    /// each has its actions in the last column, separated by ` | `.
    pub fn csv(&self, choices: bool) -> String {
        let variables = self.program.variables.iter().map(|variable| variable.name.clone());
        let heading: Vec<String> = variables.chain(choices.then(|| "choices".to_owned())).collect();
        let rows = self.listed().map(|listed| {
            let actions = listed.choices.map(|names| names.join(BETWEEN));
            listed.state.cells().chain(actions).collect::<Vec<_>>()
        });
        meliora_base::csv::lines([heading].into_iter().chain(rows))
    }

    fn listed(&self) -> impl Iterator<Item = Listed> {
        self.members.iter().map(|member| Listed::new(&self.program, member))
    }
}

impl Serialize for Rows {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.listed())
    }
}

/// A state of the selection.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub(crate) struct Listed {
    /// The values of the state.
    pub state: Valuation,
    /// The actions of its choices in the region; absent for a region of states.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub choices: Option<Vec<String>>,
}

/// A state with the answer whether it is in the selection.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Contained {
    /// The values of the state.
    pub state: Valuation,
    /// The state is a member.
    pub contained: bool,
    /// The actions of its choices in the region; absent for a region of states, and for
    /// a state that is not a member.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub choices: Option<Vec<String>>,
}

impl Listed {
    /// Returns a member with the values of its variables.
    pub(crate) fn new(program: &Program, member: &Member) -> Self {
        Listed { state: Valuation::new(program, &member.state), choices: member.choices.clone() }
    }
}

impl QueryReport {
    /// Creates a report without results.
    pub fn of_region(directory: &str, region: &str, condition: Option<&str>) -> Self {
        let (directory, region) = (directory.to_owned(), region.to_owned());
        let condition = condition.map(str::to_owned);
        let findings = QueryFindings { directory, region, condition, ..QueryFindings::default() };
        Envelope::with(Header::default(), findings)
    }
}

impl Findings for QueryFindings {
    const SCHEMA: &str = "meliora.query/1";
    const HEADER: (&[&str], &[&str]) = (&[], &[]);

    fn text(report: &QueryReport, style: Style) -> String {
        Self::body(report, style)
    }

    fn body(report: &QueryReport, _style: Style) -> String {
        let mut out = String::new();
        let what = if report.kind == Some("choices") { "pairs of states and choices" } else { "states" };
        if let Some(count) = &report.count {
            let line = match report.plain {
                true => count.0.to_string(),
                false => format!("{}: {} {what}", escape::line(&report.region), count.grouped()),
            };
            let _ = writeln!(out, "{line}");
        }
        for found in &report.contains {
            let verdict = if found.contained { "yes" } else { "no" };
            let _ = writeln!(out, "{}: {verdict}{}", found.state, choices(found.choices.as_ref()));
        }
        for listed in report.states.iter().flat_map(Rows::listed) {
            let _ = writeln!(out, "{}{}", listed.state, choices(listed.choices.as_ref()));
        }
        out
    }

    fn is_no(&self) -> bool {
        self.contains.iter().any(|c| !c.contained)
    }
}

fn choices(names: Option<&Vec<String>>) -> String {
    names.map_or_else(String::new, |names| format!("  {}", names.join(BETWEEN)))
}
