//! The report of `meliora compare`.

use std::fmt::Write;

use schemars::JsonSchema;
use serde::Serialize;

use super::check::CheckFindings;
use super::columns::{Column, Place};
use super::envelope::{Envelope, Findings, Times};
use super::text::{self, Grid};
use super::{Number, Style};
use meliora_engine::Storage;
use meliora_planning::result::ModelCounts;
use meliora_question::number::grouped;

/// The results of `compare`, in the order of the JSON fields.
#[derive(Debug, Clone, Default, Serialize, JsonSchema)]
#[schemars(rename = "compare")]
pub struct CompareFindings {
    /// The sizes of the model; `null` if unknown.
    pub counts: Option<ModelCounts>,
    /// Both engines give the same results; `null` if unknown.
    pub equal: Option<bool>,
    /// The first difference; `null` without a difference.
    pub difference: Option<String>,
    /// The number of compared values in the reports of `check`.
    pub compared: u64,
    /// The number of states at which the strategies of all kinds were compared: kept, permitted and
    /// progress actions, reasons and successors; `null` if unknown.
    pub strategies: Option<u64>,
    /// The number of states that were looked up in every region of both engines; `null` if there are
    /// more than `--membership`, or if unknown.
    pub membership: Option<Number>,
    /// Time and memory by engine.
    pub engines: Vec<EngineReport>,
    /// The engine to prefer for this input; `null` if unknown.
    pub prefer: Option<Preference>,
}

/// The report with times and memory.
pub type CompareReport = Envelope<CompareFindings>;

/// Times and memory of one engine.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct EngineReport {
    /// Its name.
    #[schemars(with = "Storage")]
    pub engine: &'static str,
    /// Seconds by phase, as in `check`.
    #[schemars(schema_with = "Times::schema::<CheckFindings>")]
    pub time: Times,
    /// The largest number of diagram nodes at once; 0 for `explicit`.
    pub peak_nodes: u64,
    /// The bytes of its own tables.
    pub table_bytes: u64,
}

/// The recommended engine for this input.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Preference {
    /// Its name.
    #[schemars(with = "Storage")]
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
        let mut grid = Grid::new(&headings);
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
    const HEADER: (&[&str], &[&str]) = (&["model", "scope", "safety", "empty"], &[]);

    fn is_no(&self) -> bool {
        self.equal == Some(false)
    }

    fn counts(&self) -> Option<&ModelCounts> {
        self.counts.as_ref()
    }

    fn columns(&self) -> Vec<Column<Envelope<Self>>> {
        let seconds = |storage: Storage| {
            let cell = move |r: &CompareReport| {
                let own = r.engines.iter().find(|own| own.engine == storage.name())?;
                Some(own.time.total.to_string())
            };
            Column::new(format!("seconds_{}", storage.name()), cell).plotted()
        };
        vec![
            Column::new("equal", |r: &CompareReport| r.equal.map(|equal| equal.to_string())).verdict(),
            seconds(Storage::Symbolic),
            seconds(Storage::Explicit).at(Place::Room(7)),
            Column::new("prefer", |r: &CompareReport| Some(r.prefer.as_ref()?.engine.to_owned()))
                .wide("symbolic"),
        ]
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
