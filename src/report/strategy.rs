//! The report of `meliora strategy`.

use schemars::JsonSchema;
use serde::Serialize;
use serde_json::value::{RawValue, to_raw_value};

use super::choose::Choosing;
use super::envelope::{Envelope, Findings, Phase};
use super::header::Header;
use super::state::{StateJson, StateReport};
use super::{Style, ranks, state_text, text};
use meliora_base::escape;
use meliora_planning::StrategyKind;
use meliora_question::number::{Number, grouped};

/// The results of `strategy`, in the order of the JSON fields.
#[derive(Debug, Clone, Serialize, JsonSchema)]
#[schemars(rename = "strategy")]
pub struct StrategyFindings {
    /// The kind of the strategy.
    pub kind: StrategyKind,
    /// The choice among permitted actions.
    #[serde(flatten)]
    pub choosing: Choosing,
    /// The number of states that were asked for; `states` may have fewer, because of `--limit`; `null`
    /// with `--at`, or if unknown.
    pub asked: Option<Number>,
    /// The states; empty if `asked` is 0, and before the first is known.
    #[schemars(with = "Vec<StateJson>")]
    pub states: Vec<Shown>,
    /// The policy that was written; absent without `--policy`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub policy: Option<WrittenPolicy>,
    /// The number of states with memory that were printed or added to a table, and are not in `states`.
    #[serde(skip)]
    pub written: u64,
    /// The place of these states.
    #[serde(skip)]
    pub place: Written,
    /// True if the whole strategy was asked for: all states, first without a past, then with other memories.
    #[serde(skip)]
    pub whole: bool,
    /// The DOT graph, which replaces the text report.
    #[serde(skip)]
    pub drawing: Option<String>,
}

/// A policy that was written.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct WrittenPolicy {
    /// The file.
    pub file: String,
    /// The number of nodes where paths may start.
    pub starts: u64,
    /// The number of nodes: states with memory.
    pub nodes: u64,
}

/// The report with times and memory.
pub type StrategyReport = Envelope<StrategyFindings>;

/// A state in its final form. There may be millions, and this form takes a fraction of the memory
/// of a [`StateReport`].
#[derive(Debug, Clone, Serialize)]
#[serde(untagged)]
pub enum Shown {
    /// For the JSON output.
    Json(Box<RawValue>),
    /// For the text output.
    Text(String),
}

/// The place of states that are not in the report.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Written {
    /// They were printed as text after [`StrategyReport::head`].
    Text,
    /// Their lines were written as they were found, to a pipe for example.
    #[default]
    Lines,
    /// Their lines are in a file, which appears once it is complete.
    File,
}

impl StrategyReport {
    /// Creates a report without results.
    pub fn of_kind(header: Header, kind: StrategyKind, choosing: Choosing) -> Self {
        let findings = StrategyFindings {
            kind,
            choosing,
            asked: None,
            states: Vec::new(),
            policy: None,
            written: 0,
            place: Written::default(),
            whole: false,
            drawing: None,
        };
        Envelope::with(header, findings)
    }

    /// Renders a state.
    pub fn state_text(state: &StateReport<'_>, style: Style) -> String {
        state_text::render(state, style)
    }

    /// Returns the text before the states, if they are printed before the report.
    pub fn head(&self, style: Style) -> String {
        self.header.title(self.settings(), style) + &self.legend(self.header.is_game(), style)
    }
}

impl StrategyFindings {
    /// Adds a state: as text if there is a style, else as JSON.
    pub fn push(&mut self, state: &StateReport<'_>, style: Option<Style>) {
        self.states.push(match style {
            Some(style) => Shown::Text(state_text::render(state, style)),
            // The keys are strings and the values plain, so the conversion cannot fail.
            None => Shown::Json(to_raw_value(&state.json()).unwrap_or_default()),
        });
    }

    /// Says how many of the states that were asked for are listed.
    fn coverage(report: &StrategyReport) -> Option<String> {
        let asked = report.asked.as_ref()?;
        let listed = report.states.len() as u64 + report.written;
        let (listed, all) = (Number::from(listed), asked.grouped());
        let text = match (report.whole, report.error.is_some()) {
            (true, false) => {
                let what = if report.place == Written::Text { "These are" } else { "The table has" };
                format!("{what} {all} states, {} with their memories.", listed.grouped())
            }
            (true, true) => {
                let first = listed.clone().min(asked.clone());
                let more = match Number(&listed.0 - &first.0) {
                    none if none == Number::from(0) => String::new(),
                    more => format!(", and {} more with other memories", more.grouped()),
                };
                let unwritten = match report.place {
                    Written::File => "; the table was not written, because it is not complete",
                    Written::Text | Written::Lines => "",
                };
                format!("{} of {all} states{more} before the work stopped{unwritten}.", first.grouped())
            }
            (false, _) if *asked == Number::from(0) => "No state has this rank.".to_owned(),
            (false, true) if *asked > listed => {
                format!("{} of {all} states before the work stopped.", listed.grouped())
            }
            (false, false) if *asked > listed => {
                format!("{} of {all} states; a larger `--limit` lists more.", listed.grouped())
            }
            (false, _) => return None,
        };
        Some(format!("\n{text}\n"))
    }

    /// Explains the terms of the report.
    fn legend(&self, is_game: bool, style: Style) -> String {
        let lines = match is_game {
            false => [
                "Most preferred: the objectives that some strategy achieves almost surely, without",
                "those to which another such objective is preferred. `A or B`: each of them, but",
                "not always both. A step improves if an objective that becomes most preferred is",
                "preferred to one that was, and weakens in the opposite case. Rank: the number of",
            ],
            true => [
                "Most preferred: the objectives that we achieve almost surely, whatever the opponent",
                "does, without those to which another such one is preferred. `A or B`: each, but",
                "not always both. A step improves if an objective that becomes most preferred is",
                "preferred to one that was, and weakens in the opposite case. Rank: the number of",
            ],
        };
        let how = ranks::how(self.choosing.choose.levels(self.kind));
        style.dim(&format!("\n{}\n{how} improvements.\n", lines.join("\n")))
    }
}

impl Findings for StrategyFindings {
    const SCHEMA: &str = "meliora.strategy/1";
    const HEADER: (&[&str], &[&str]) = (&["model", "scope", "safety", "empty"], &["engine", "engine_reason"]);
    const PHASES: &[Phase] = &[
        Phase::PARSE_STATES,
        Phase::BUILD,
        Phase::LEVELS,
        Phase::VALUES,
        Phase::new("answer", "Explaining the states"),
    ];

    fn settings(&self) -> Vec<(&'static str, String)> {
        std::iter::once(("strategy", self.kind.to_string())).chain(self.choosing.settings()).collect()
    }

    fn body(report: &StrategyReport, style: Style) -> String {
        let legend = match report.states.is_empty() {
            true => String::new(),
            false => report.legend(report.header.is_game(), style),
        };
        let texts = report.states.iter().map(|state| match state {
            Shown::Text(text) => text.as_str(),
            Shown::Json(_) => "",
        });
        let mut out: String = std::iter::once(legend.as_str()).chain(texts).collect();
        out.extend(Self::coverage(report));
        if let Some(WrittenPolicy { file, starts, nodes }) = &report.policy {
            let (starts, nodes) = (text::plural(*starts as usize, "start"), grouped(*nodes));
            let file = escape::line(file);
            out += &format!(
                "\nA policy with {nodes} states with memory, from {starts}, was written to {file}.\n"
            );
            out += "`meliora verify` checks it, and `meliora simulate --policy` runs it.\n";
        }
        out
    }

    fn text(report: &StrategyReport, style: Style) -> String {
        match &report.drawing {
            Some(drawing) => drawing.clone(),
            // The head and the states were printed before.
            None if report.place == Written::Text && report.whole => {
                Self::coverage(report).unwrap_or_default() + &report.tail(style)
            }
            None => report.full_text(style),
        }
    }
}
