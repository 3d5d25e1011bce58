//! The report of `meliora strategy`.

use schemars::JsonSchema;
use serde::Serialize;
use serde_json::value::{RawValue, to_raw_value};

use super::choose::Choosing;
use super::envelope::{Envelope, Findings, Phase};
use super::header::Header;
use super::number::Number;
use super::state::{StateJson, StateReport};
use super::{Style, ranks, state_text};
use meliora_planning::StrategyKind;

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
    /// The states.
    #[schemars(with = "Vec<StateJson>")]
    pub states: Vec<Shown>,
    /// The number of states that are in a table and not in `states`.
    #[serde(skip)]
    pub in_table: u64,
    /// The DOT graph, which replaces the text report.
    #[serde(skip)]
    pub drawing: Option<String>,
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

impl StrategyReport {
    /// Creates a report without results.
    pub fn of_kind(header: Header, kind: StrategyKind, choosing: Choosing) -> Self {
        let (asked, states, drawing, in_table) = (None, Vec::new(), None, 0);
        Envelope::of(header, StrategyFindings { kind, choosing, asked, states, in_table, drawing })
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

    /// Explains the terms of the report.
    fn legend(&self, is_game: bool, style: Style) -> String {
        let lines = match is_game {
            false => [
                "Sure: the objectives that some strategy achieves almost surely, without those",
                "to which another sure objective is preferred. `A or B`: each of them, but not",
                "always both. A step improves if an objective that becomes sure is preferred to",
                "one that was sure before, and weakens in the opposite case. Rank: the number of",
            ],
            true => [
                "Sure: the objectives that we achieve almost surely, whatever the opponent does,",
                "without those to which another sure one is preferred. `A or B`: each, but not",
                "always both. A step improves if an objective that becomes sure is preferred to",
                "one that was sure before, and weakens in the opposite case. Rank: the number of",
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
        if let Some(asked) = &report.asked {
            let listed = Number::from(report.states.len() as u64);
            if report.in_table > 0 {
                let rows = Number::from(report.in_table).grouped();
                out += &format!("\nThe table has {} states, {rows} with their memories.\n", asked.grouped());
            } else if *asked == Number::from(0) {
                out += "\nNo state has this rank.\n";
            } else if *asked > listed {
                let asked = asked.grouped();
                out += &format!("\n{listed} of {asked} states; a larger `--limit` lists more.\n");
            }
        }
        out
    }

    fn text(report: &StrategyReport, style: Style) -> String {
        match &report.drawing {
            Some(drawing) => drawing.clone(),
            None => report.full_text(style),
        }
    }
}
