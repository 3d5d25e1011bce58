//! The report of `meliora export --format explicit` and `--format drn`.

use serde::Serialize;

use super::envelope::{Envelope, Findings, Total};
use super::report::ModelSummary;
use super::text::{self, Grid};
use super::{Number, Style};
use crate::engine::Scope;
use crate::export::explicit::Graph;

/// The explicit model that `export` wrote.
#[derive(Debug, Clone, Serialize)]
pub struct ExplicitFindings {
    /// The model.
    pub model: ModelSummary,
    /// The valuations that are states.
    pub scope: Scope,
    /// The name of the safety filter.
    pub safety: &'static str,
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
    pub fn new(
        model: &str,
        scope: Scope,
        safety: &'static str,
        directory: &str,
        strategy: Option<String>,
    ) -> Self {
        Envelope::of(ExplicitFindings {
            model: ModelSummary::of_path(model),
            scope,
            safety,
            directory: directory.to_owned(),
            strategy,
            files: Vec::new(),
            states: None,
            choices: None,
            transitions: None,
            labels: Vec::new(),
        })
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
}

impl Findings for ExplicitFindings {
    const SCHEMA: &str = "meliora.export/1";
    type Time = Total;

    fn text(report: &ExplicitReport, style: Style) -> String {
        let mut settings = vec![("scope", report.scope.name()), ("safety", report.safety)];
        if let Some(strategy) = &report.strategy {
            settings.push(("strategy", strategy));
        }
        let mut out = text::title(&[&report.model.path], &settings, style);
        if !report.files.is_empty() {
            out.push_str(&format!("\nwritten to {}: {}\n", report.directory, report.files.join(", ")));
            let mut grid = Grid::new(&["", "number"], style);
            let sizes = [
                ("states", &report.states),
                ("choices", &report.choices),
                ("transitions", &report.transitions),
            ];
            for (name, size) in sizes {
                let size = size.as_ref().map_or_else(String::new, Number::grouped);
                grid.row(vec![name.to_owned(), size]);
            }
            out.push_str(&grid.text(style));
            let mut grid = Grid::new(&["label", "states"], style);
            for label in &report.labels {
                grid.row(vec![label.name.clone(), label.states.grouped()]);
            }
            out.push_str(&format!("\n{}", grid.text(style)));
        }
        out.push_str(&text::incomplete(report.error.as_ref(), style));
        out.push_str(&text::footer(report.time.total, &[], report.memory, style));
        out
    }
}
