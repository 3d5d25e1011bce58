//! The report of `meliora compare`.

use std::fmt::Write;

use serde::Serialize;

use super::check::CheckTime;
use super::envelope::{Envelope, Findings, Total};
use super::report::{Counts, ModelSummary};
use super::text::{self, Grid};
use super::{Number, Style};
use crate::engine::Scope;

/// The results of `compare`, in the order of the JSON fields.
#[derive(Debug, Clone, Serialize)]
pub struct CompareFindings {
    /// The model.
    pub model: ModelSummary,
    /// The preference file as the user named it.
    #[serde(skip)]
    pub preferences: String,
    /// The valuations that are states.
    pub scope: Scope,
    /// The name of the safety filter.
    pub safety: &'static str,
    /// The value of nothing: the `empty` statement of the preferences.
    pub empty: Option<&'static str>,
    /// Sizes of the model.
    pub counts: Option<Counts>,
    /// True if both engines have the same results; `None` if this is not known.
    pub equal: Option<bool>,
    /// The first difference.
    pub difference: Option<String>,
    /// Number of compared counts, classes, levels and ranks.
    pub compared: u64,
    /// Number of states that were looked up in every region of both; `None` if there were too many.
    pub membership: Option<Number>,
    /// Times and memory of each engine.
    pub engines: Vec<EngineReport>,
    /// The recommended engine, and the reason.
    pub prefer: Option<Preference>,
}

/// The report with times and memory.
pub type CompareReport = Envelope<CompareFindings>;

/// Times and memory of one engine.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EngineReport {
    /// Its name.
    pub engine: &'static str,
    /// Seconds by phase.
    pub time: CheckTime,
    /// The maximum number of live diagram nodes; 0 without diagrams.
    pub peak_nodes: u64,
    /// The size of its tables in bytes.
    pub table_bytes: u64,
}

/// The recommended engine for this input.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Preference {
    /// Its name.
    pub engine: &'static str,
    /// The reason.
    pub reason: String,
}

impl CompareReport {
    /// Creates a report without results.
    pub fn new(model: &str, preferences: &str, scope: Scope, safety: &'static str) -> Self {
        Envelope::of(CompareFindings {
            model: ModelSummary::of_path(model),
            preferences: preferences.to_owned(),
            scope,
            safety,
            empty: None,
            counts: None,
            equal: None,
            difference: None,
            compared: 0,
            membership: None,
            engines: Vec::new(),
            prefer: None,
        })
    }

    fn verdict(&self, style: Style) -> String {
        match (self.equal, &self.difference) {
            (Some(true), _) => {
                let states = match &self.membership {
                    Some(n) => format!(" and the membership of {} states in every region", n.grouped()),
                    None => String::new(),
                };
                format!("\n{}: {} values{states}\n", style.good("The engines agree"), self.compared)
            }
            (_, Some(difference)) => format!("\n{}: {difference}\n", style.bad("The engines differ")),
            _ => String::new(),
        }
    }

    fn table(&self, style: Style) -> String {
        if self.engines.is_empty() {
            return String::new();
        }
        let headings = ["", "build", "outcomes", "improvement", "SASI", "SPI", "total", "tables", "nodes"];
        let mut grid = Grid::new(&headings, style);
        let time = |t: Option<f64>| t.map_or_else(|| "–".to_owned(), text::seconds);
        for e in &self.engines {
            let t = &e.time;
            let mut row = vec![e.engine.to_owned()];
            row.extend([t.build, t.outcomes, t.improvement, t.sasi, t.spi, Some(t.total)].map(time));
            row.push(text::bytes(e.table_bytes));
            row.push(Number::from(e.peak_nodes).grouped());
            grid.row(row);
        }
        format!("\n{}\n{}", style.bold("Time and memory"), grid.text(style))
    }
}

impl Findings for CompareFindings {
    const SCHEMA: &str = "meliora.compare/1";
    type Time = Total;

    fn is_no(&self) -> bool {
        self.equal == Some(false)
    }

    fn text(report: &CompareReport, style: Style) -> String {
        let mut settings = vec![("scope", report.scope.name()), ("safety", report.safety)];
        if let Some(empty) = report.empty {
            settings.push(("empty", empty));
        }
        let mut out = text::title(&[&report.model.path, &report.preferences], &settings, style);
        if report.model.kind.is_some() {
            out.push_str(&text::model(&report.model, report.counts.as_ref(), style));
        }
        out.push_str(&report.verdict(style));
        out.push_str(&report.table(style));
        if let Some(prefer) = &report.prefer {
            let _ = write!(out, "\nPrefer {} here: {}.\n", style.bold(prefer.engine), prefer.reason);
        }
        out.push_str(&text::incomplete(report.error.as_ref(), style));
        out.push_str(&text::footer(report.time.total, &[], report.memory, style));
        out
    }
}
