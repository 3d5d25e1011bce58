//! The report of `meliora query`.

use std::fmt::Write;
use std::sync::Arc;

use serde::{Serialize, Serializer};
use serde_json::{Map, Value as Json};

use super::export::Total;
use super::report::{Failure, Memory, Report, is_true, json_state, show_state};
use super::{Number, Style};
use crate::escape;
use crate::model::Program;
use crate::query::Member;

/// What `query` found.
#[derive(Debug, Clone, Serialize)]
pub struct QueryReport {
    /// `meliora.query/1`
    pub schema: &'static str,
    /// Whether the work ran to its end; written only where it did not.
    #[serde(skip_serializing_if = "is_true")]
    pub complete: bool,
    /// The directory of the dump.
    pub directory: String,
    /// The region expression.
    pub region: String,
    /// The condition of `--where`.
    #[serde(rename = "where", skip_serializing_if = "Option::is_none")]
    pub condition: Option<String>,
    /// What the region has: `states` or `choices`.
    pub kind: Option<&'static str>,
    /// How many.
    pub count: Option<Number>,
    /// The states of `--contains`, and whether they are members.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub contains: Vec<Contained>,
    /// The states of `--list`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub states: Option<Rows>,
    /// Whether the number alone is wanted.
    #[serde(skip)]
    pub plain: bool,
    /// Seconds.
    pub time: Total,
    /// What was used.
    pub memory: Memory,
    /// Why the work ended early.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<Failure>,
}

/// States of the selection, as many as are asked for: each is spelled out when it is written.
#[derive(Debug, Clone)]
pub struct Rows {
    program: Arc<Program>,
    members: Arc<Vec<Member>>,
}

impl Rows {
    /// The states of `program` that were found.
    pub fn new(program: &Arc<Program>, members: Vec<Member>) -> Self {
        Rows { program: Arc::clone(program), members: Arc::new(members) }
    }

    fn listed(&self) -> impl Iterator<Item = Listed> {
        self.members.iter().map(|member| Listed::of(&self.program, member))
    }
}

impl Serialize for Rows {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.listed())
    }
}

/// A state of the selection.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Listed {
    /// Its values.
    pub state: Map<String, Json>,
    /// The names of its choices, where the selection has choices.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub choices: Option<Vec<String>>,
}

/// Whether a state is in the selection.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Contained {
    /// Its values.
    pub state: Map<String, Json>,
    /// The answer.
    pub contained: bool,
    /// The names of its choices, where the selection has choices.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub choices: Option<Vec<String>>,
}

impl Listed {
    /// A member with the values of its variables.
    pub fn of(program: &Program, member: &Member) -> Self {
        Listed { state: json_state(program, &member.state), choices: member.choices.clone() }
    }
}

impl QueryReport {
    /// A report of which nothing but the question is known.
    pub fn new(directory: &str, region: &str, condition: Option<&str>) -> Self {
        QueryReport {
            schema: "meliora.query/1",
            complete: true,
            directory: directory.to_owned(),
            region: region.to_owned(),
            condition: condition.map(str::to_owned),
            kind: None,
            count: None,
            contains: Vec::new(),
            states: None,
            plain: false,
            time: Total::default(),
            memory: Memory::default(),
            error: None,
        }
    }
}

impl Report for QueryReport {
    fn fail(&mut self, failure: Failure) {
        self.complete = false;
        self.error = Some(failure);
    }

    fn finish(&mut self, seconds: f64, peak_rss_bytes: u64) {
        self.time.total = seconds;
        self.memory.peak_rss_bytes = peak_rss_bytes;
    }

    fn text(&self, _style: Style) -> String {
        let mut out = String::new();
        let what = if self.kind == Some("choices") { "pairs of states and choices" } else { "states" };
        match &self.count {
            Some(count) if self.plain => drop(writeln!(out, "{}", count.0)),
            Some(count) => drop(writeln!(out, "{}: {} {what}", escape::line(&self.region), count.grouped())),
            None => {}
        }
        for found in &self.contains {
            let verdict = if found.contained { "yes" } else { "no" };
            let _ =
                writeln!(out, "{}: {verdict}{}", show_state(&found.state), choices(found.choices.as_ref()));
        }
        for listed in self.states.iter().flat_map(Rows::listed) {
            let _ = writeln!(out, "{}{}", show_state(&listed.state), choices(listed.choices.as_ref()));
        }
        out
    }

    fn is_no(&self) -> bool {
        self.contains.iter().any(|c| !c.contained)
    }
}

fn choices(names: Option<&Vec<String>>) -> String {
    names.map_or_else(String::new, |names| format!("  {}", names.join(" ")))
}
