//! The report of `meliora export --format explicit` and `--format drn`.

use serde::Serialize;

use super::export::Total;
use super::report::{Failure, Memory, ModelSummary, Report, is_true, scope_name, scope_word};
use super::text::{self, Grid};
use super::{Number, Style};
use crate::engine::Scope;
use crate::export::explicit::Graph;

/// What `export` wrote state by state.
#[derive(Debug, Clone, Serialize)]
pub struct ExplicitReport {
    /// `meliora.export/1`
    pub schema: &'static str,
    /// Whether the work ran to its end; written only where it did not.
    #[serde(skip_serializing_if = "is_true")]
    pub complete: bool,
    /// The model.
    pub model: ModelSummary,
    /// Which valuations are states.
    #[serde(serialize_with = "scope_name")]
    pub scope: Scope,
    /// What is kept of a choice that may weaken.
    pub safety: &'static str,
    /// The directory.
    pub directory: String,
    /// The strategy whose model it is, such as `sasi:progress`; none for the model itself.
    pub strategy: Option<String>,
    /// The files in the directory.
    pub files: Vec<String>,
    /// States that were written.
    pub states: Option<Number>,
    /// Their choices.
    pub choices: Option<Number>,
    /// Their transitions.
    pub transitions: Option<Number>,
    /// The labels, each with the number of its states.
    pub labels: Vec<Labelled>,
    /// Seconds.
    pub time: Total,
    /// What was used.
    pub memory: Memory,
    /// Why the work ended early.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<Failure>,
}

/// A label of states.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Labelled {
    /// Its name in the files.
    pub name: String,
    /// How many states have it.
    pub states: Number,
}

impl ExplicitReport {
    /// A report of which nothing but the question is known.
    pub fn new(
        model: &str,
        scope: Scope,
        safety: &'static str,
        directory: &str,
        strategy: Option<String>,
    ) -> Self {
        ExplicitReport {
            schema: "meliora.export/1",
            complete: true,
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
            time: Total::default(),
            memory: Memory::default(),
            error: None,
        }
    }

    /// Notes what was written.
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

impl Report for ExplicitReport {
    fn fail(&mut self, failure: Failure) {
        self.complete = false;
        self.error = Some(failure);
    }

    fn finish(&mut self, seconds: f64, peak_rss_bytes: u64) {
        self.time.total = seconds;
        self.memory.peak_rss_bytes = peak_rss_bytes;
    }

    fn text(&self, style: Style) -> String {
        let mut settings = vec![("scope", scope_word(self.scope)), ("safety", self.safety)];
        if let Some(strategy) = &self.strategy {
            settings.push(("strategy", strategy));
        }
        let mut out = text::title(&[&self.model.path], &settings, style);
        if !self.files.is_empty() {
            out.push_str(&format!("\nWritten to {}: {}\n", self.directory, self.files.join(", ")));
            let mut grid = Grid::new(&["", "number"], style);
            let sizes =
                [("states", &self.states), ("choices", &self.choices), ("transitions", &self.transitions)];
            for (name, size) in sizes {
                let size = size.as_ref().map_or_else(String::new, Number::grouped);
                grid.row(vec![name.to_owned(), size]);
            }
            out.push_str(&grid.text(style));
            let mut grid = Grid::new(&["label", "states"], style);
            for label in &self.labels {
                grid.row(vec![label.name.clone(), label.states.grouped()]);
            }
            out.push_str(&format!("\n{}", grid.text(style)));
        }
        out.push_str(&text::incomplete(self.error.as_ref(), style));
        out.push_str(&text::footer(self.time.total, &[], self.memory, style));
        out
    }
}
