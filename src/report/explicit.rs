//! The report of `meliora export --format explicit` and `--format drn`.

use serde::Serialize;

use super::envelope::{Envelope, Findings};
use super::export::ExportedValues;
use super::header::Header;
use super::text::Grid;
use super::{Number, Style};
use meliora_export::explicit::{Graph, Quantities};

/// The explicit model that `export` wrote.
#[derive(Debug, Clone, Default, Serialize)]
pub struct ExplicitFindings {
    /// The directory.
    pub directory: String,
    /// The strategy that induces the model, such as `sasi:progress`; `None` for the model itself.
    pub strategy: Option<String>,
    /// The files in the directory.
    pub files: Vec<String>,
    /// Number of written states.
    pub states: Option<Number>,
    /// Number of their choices.
    pub choices: Option<Number>,
    /// Number of their transitions.
    pub transitions: Option<Number>,
    /// The labels, each with the number of its states.
    pub labels: Vec<Labelled>,
    /// The bounds of quantities, if they were written.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub values: Option<ExportedValues>,
}

/// The report with times and memory.
pub type ExplicitReport = Envelope<ExplicitFindings>;

/// A label of states.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Labelled {
    /// Its name in the files.
    pub name: String,
    /// Number of states with this label.
    pub states: Number,
}

impl ExplicitReport {
    /// Creates a report without results.
    pub fn to_directory(header: Header, directory: &str, strategy: Option<String>) -> Self {
        let directory = directory.to_owned();
        Envelope::of(header, ExplicitFindings { directory, strategy, ..Default::default() })
    }

    /// Adds the written model and files.
    pub fn set(&mut self, graph: &Graph, files: Vec<String>) {
        let number = |n: usize| Number((n as u64).into());
        self.files = files;
        self.states = Some(number(graph.states.len()));
        self.choices = Some(number(graph.choices()));
        self.transitions = Some(number(graph.transitions()));
        let labelled = |(name, states): &(String, Vec<usize>)| Labelled {
            name: name.clone(),
            states: number(states.len()),
        };
        self.labels = graph.labels.iter().map(labelled).collect();
    }

    /// Adds the quantities that were written, with the width that is wanted.
    pub fn set_values(&mut self, written: Option<(&Quantities, f64)>) {
        self.values = written.map(|(quantities, precision)| {
            let rows = quantities.list.first().map_or(0, |q| q.bounds.len());
            let width = quantities.widest();
            ExportedValues::new((rows, quantities.levels), &quantities.reward, width, precision)
        });
    }
}

impl Findings for ExplicitFindings {
    const SCHEMA: &str = "meliora.export/1";

    fn settings(&self) -> Vec<(&'static str, String)> {
        self.strategy.iter().map(|strategy| ("strategy", strategy.clone())).collect()
    }

    fn body(report: &ExplicitReport, style: Style) -> String {
        if report.files.is_empty() {
            return String::new();
        }
        let mut out = format!("\nwritten to {}: {}\n", report.directory, report.files.join(", "));
        let mut grid = Grid::new(&["", "number"], style);
        let sizes =
            [("states", &report.states), ("choices", &report.choices), ("transitions", &report.transitions)];
        for (name, size) in sizes {
            grid.row(vec![name.to_owned(), size.as_ref().map_or_else(String::new, Number::grouped)]);
        }
        out += &grid.text(style);
        let mut grid = Grid::new(&["label", "states"], style);
        for label in &report.labels {
            grid.row(vec![label.name.clone(), label.states.grouped()]);
        }
        out += "\n";
        out += &grid.text(style);
        if let Some(values) = &report.values {
            out += "\n";
            out += &values.text();
        }
        out
    }
}
