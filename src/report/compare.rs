//! The report of `meliora compare`.

use std::fmt::Write;

use serde::Serialize;

use super::envelope::{Envelope, Findings, Times};
use super::number::grouped;
use super::text::{self, Grid};
use super::{Number, Style};
use meliora_planning::result::ModelCounts;

/// The results of `compare`, in the order of the JSON fields.
#[derive(Debug, Clone, Default, Serialize)]
pub struct CompareFindings {
    /// Sizes of the model.
    pub counts: Option<ModelCounts>,
    /// True if both engines have the same results; `None` if this is not known.
    pub equal: Option<bool>,
    /// The first difference.
    pub difference: Option<String>,
    /// Number of compared counts, classes, levels and ranks.
    pub compared: u64,
    /// Number of states at which the strategies of all kinds were compared; `None` if this is not
    /// known.
    pub strategies: Option<u64>,
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
    pub time: Times,
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
    fn verdict(&self, style: Style) -> String {
        match (self.equal, &self.difference) {
            (Some(true), _) => {
                let good = style.good("The engines agree");
                let mut out = format!("\n{good}: {} values", grouped(self.compared));
                if let Some(n) = self.strategies {
                    let _ = write!(out, ", the strategies at {}", text::plural(n as usize, "state"));
                }
                if let Some(n) = &self.membership {
                    let _ = write!(out, ",\nand the membership of {} states in every region", n.grouped());
                }
                out + "\n"
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
            let mut row = vec![e.engine.to_owned()];
            // Reading is shared.
            let own = e.time.phases().skip(1).map(|(_, seconds)| seconds);
            row.extend(own.chain([Some(e.time.total)]).map(time));
            row.push(text::bytes(e.table_bytes));
            row.push(grouped(e.peak_nodes));
            grid.row(row);
        }
        grid.titled("Time and memory", style)
    }
}

impl Findings for CompareFindings {
    const SCHEMA: &str = "meliora.compare/1";

    fn is_no(&self) -> bool {
        self.equal == Some(false)
    }

    fn body(report: &CompareReport, style: Style) -> String {
        let mut out = report.header.sizes(report.counts.as_ref(), style);
        out += &report.verdict(style);
        out += &report.table(style);
        if let Some(prefer) = &report.prefer {
            let _ = write!(out, "\nPrefer {} here: {}.\n", style.bold(prefer.engine), prefer.reason);
        }
        out
    }
}
