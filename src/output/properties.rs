//! The report of `meliora reach` with several properties.

use std::fmt::Write;

use serde::Serialize;

use super::report::{Counts, Failure, Memory, ModelSummary, Report, is_true, scope_name, scope_word};
use super::text::{self, Grid};
use super::{Number, Style};
use crate::engine::Scope;

/// What is known of the properties of a file or of the command line.
#[derive(Debug, Clone, Serialize)]
pub struct PropertiesReport {
    /// `meliora.reach/1`
    pub schema: &'static str,
    /// Whether the work ran to its end; written only where it did not.
    #[serde(skip_serializing_if = "is_true")]
    pub complete: bool,
    /// The model.
    pub model: ModelSummary,
    /// The property file as the user named it; none for properties of the command line.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// The name of the engine.
    pub engine: &'static str,
    /// Which valuations are states.
    #[serde(serialize_with = "scope_name")]
    pub scope: Scope,
    /// Sizes of the model.
    pub counts: Option<Counts>,
    /// The properties in the order of the file.
    pub properties: Vec<PropertyAnswer>,
    /// Seconds.
    pub time: super::export::Total,
    /// What was used.
    pub memory: Memory,
    /// Why the work ended early.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<Failure>,
}

/// A property with its answer, or why there is none.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct PropertyAnswer {
    /// Its name in the file.
    pub name: Option<String>,
    /// Its text.
    pub property: String,
    /// Whether it holds in all initial states; none where it was not answered.
    pub holds: Option<bool>,
    /// States from which some strategy reaches the target surely.
    pub pmax_one: Option<Number>,
    /// States from which some strategy may reach it.
    pub pmax_positive: Option<Number>,
    /// States from which every strategy reaches it surely.
    pub pmin_one: Option<Number>,
    /// States from which every strategy may reach it.
    pub pmin_positive: Option<Number>,
    /// Why it was not answered.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
}

impl PropertyAnswer {
    /// A property that has no answer yet, or none at all for this reason.
    pub fn open(name: Option<String>, property: String, reason: Option<String>) -> Self {
        PropertyAnswer {
            name,
            property,
            holds: None,
            pmax_one: None,
            pmax_positive: None,
            pmin_one: None,
            pmin_positive: None,
            reason,
        }
    }
}

impl PropertiesReport {
    /// A report of which nothing but the question is known.
    pub fn new(model: &str, file: Option<&str>, engine: &'static str, scope: Scope) -> Self {
        PropertiesReport {
            schema: "meliora.reach/1",
            complete: true,
            model: ModelSummary::of_path(model),
            file: file.map(str::to_owned),
            engine,
            scope,
            counts: None,
            properties: Vec::new(),
            time: super::export::Total::default(),
            memory: Memory::default(),
            error: None,
        }
    }

    fn table(&self, style: Style) -> String {
        let headings = ["property", "Pmax = 1", "Pmax > 0", "Pmin = 1", "Pmin > 0", "in the initial states"];
        let mut grid = Grid::new(&headings, style);
        for answer in self.properties.iter().filter(|p| p.reason.is_none()) {
            let count = |n: &Option<Number>| n.as_ref().map_or_else(String::new, Number::grouped);
            let holds = match answer.holds {
                Some(true) => "holds",
                Some(false) => "does not hold",
                None => "",
            };
            grid.row(vec![
                title(answer),
                count(&answer.pmax_one),
                count(&answer.pmax_positive),
                count(&answer.pmin_one),
                count(&answer.pmin_positive),
                holds.to_owned(),
            ]);
        }
        grid.text(style)
    }
}

/// The name and the text of a property in one line.
fn title(answer: &PropertyAnswer) -> String {
    let text = answer.property.split_whitespace().collect::<Vec<_>>().join(" ");
    answer.name.as_ref().map_or_else(|| text.clone(), |name| format!("\"{name}\": {text}"))
}

impl Report for PropertiesReport {
    fn fail(&mut self, failure: Failure) {
        self.complete = false;
        self.error = Some(failure);
    }

    fn finish(&mut self, seconds: f64, peak_rss_bytes: u64) {
        self.time.total = seconds;
        self.memory.peak_rss_bytes = peak_rss_bytes;
    }

    fn is_no(&self) -> bool {
        self.properties.iter().any(|p| p.holds == Some(false))
    }

    fn text(&self, style: Style) -> String {
        let settings = [("engine", self.engine), ("scope", scope_word(self.scope))];
        let files: Vec<&str> = [self.model.path.as_str()].into_iter().chain(self.file.as_deref()).collect();
        let mut out = text::title(&files, &settings, style);
        if self.model.kind.is_some() {
            out.push_str(&text::model(&self.model, self.counts.as_ref(), style));
        }
        if self.properties.iter().any(|p| p.reason.is_none()) {
            let _ = write!(out, "\n{}\n{}", style.bold("Properties"), self.table(style));
        }
        let others: Vec<_> = self.properties.iter().filter(|p| p.reason.is_some()).collect();
        if !others.is_empty() {
            let _ = write!(out, "\n{}\n", style.bold("Not answered"));
            for answer in others {
                let _ = writeln!(
                    out,
                    "  {}\n    {}",
                    title(answer),
                    answer.reason.as_deref().unwrap_or_default()
                );
            }
        }
        out.push_str(&text::incomplete(self.error.as_ref(), style));
        out.push_str(&text::footer(self.time.total, &[], self.memory, style));
        out
    }
}
