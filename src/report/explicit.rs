//! The report of `meliora export --format explicit` and `--format drn`.

use schemars::JsonSchema;
use serde::Serialize;

use super::envelope::{Envelope, Findings};
use super::export::ExportedValues;
use super::header::Header;
use super::text::Grid;
use super::{Number, Style};
use meliora_base::escape;
use meliora_export::explicit::{Graph, Quantities};

/// The explicit model that `export` wrote.
#[derive(Debug, Clone, Default, Serialize, JsonSchema)]
#[schemars(rename = "export")]
pub struct ExplicitFindings {
    /// The directory as given by `--out`.
    pub directory: String,
    /// The strategy whose induced model is written, such as `sasi:progress`; absent in a dump, `null`
    /// without `--kind`.
    pub strategy: Option<String>,
    /// The names of the files in the directory; absent in a dump.
    pub files: Vec<String>,
    /// The number of states written; absent in a dump, `null` if not written.
    pub states: Option<Number>,
    /// The number of their choices; as `states`.
    pub choices: Option<Number>,
    /// The number of their transitions; as `states`.
    pub transitions: Option<Number>,
    /// The labels of states; absent in a dump.
    pub labels: Vec<Labelled>,
    /// The bounds of `--values`; absent without `--values`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub values: Option<ExportedValues>,
}

/// The report with times and memory.
pub type ExplicitReport = Envelope<ExplicitFindings>;

/// A label of states.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Labelled {
    /// Its name in the files.
    pub name: String,
    /// The number of states with the label.
    pub states: Number,
}

impl ExplicitReport {
    /// Creates a report without results.
    pub fn to_directory(header: Header, directory: &str, strategy: Option<String>) -> Self {
        let directory = directory.to_owned();
        Envelope::with(header, ExplicitFindings { directory, strategy, ..Default::default() })
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
            ExportedValues::new(rows, quantities.levels, &quantities.reward, width, precision)
        });
    }
}

impl Findings for ExplicitFindings {
    const SCHEMA: &str = "meliora.export/1";
    const HEADER: (&[&str], &[&str]) = (&["model", "scope", "safety"], &[]);

    fn settings(&self) -> Vec<(&'static str, String)> {
        self.strategy.iter().map(|strategy| ("strategy", strategy.clone())).collect()
    }

    fn body(report: &ExplicitReport, style: Style) -> String {
        if report.files.is_empty() {
            return String::new();
        }
        let mut out =
            format!("\nwritten to {}: {}\n", escape::line(&report.directory), report.files.join(", "));
        let mut grid = Grid::new(&["", "number"]);
        let sizes =
            [("states", &report.states), ("choices", &report.choices), ("transitions", &report.transitions)];
        for (name, size) in sizes {
            grid.row(vec![name.to_owned(), size.as_ref().map_or_else(String::new, Number::grouped)]);
        }
        out += &grid.text(style);
        let mut grid = Grid::new(&["label", "states"]);
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
