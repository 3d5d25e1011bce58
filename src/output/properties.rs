//! The report of `meliora reach` with several properties.

use std::fmt::Write;

use serde::Serialize;

use super::envelope::{Envelope, Findings, Total};
use super::report::{Counts, ModelSummary};
use super::text::{self, Grid};
use super::values::Bound;
use super::{Number, Style};
use crate::engine::Scope;

/// The answers to the properties of a file or of the command line.
#[derive(Debug, Clone, Serialize)]
pub struct PropertiesFindings {
    /// The model.
    pub model: ModelSummary,
    /// The property file as the user named it; `None` for properties of the command line.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// The name of the engine.
    pub engine: &'static str,
    /// The valuations that are states.
    pub scope: Scope,
    /// Sizes of the model.
    pub counts: Option<Counts>,
    /// The properties in the order of the file.
    pub properties: Vec<PropertyAnswer>,
}

/// The report with times and memory.
pub type PropertiesReport = Envelope<PropertiesFindings>;

/// A property with its answer, or the reason for no answer.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PropertyAnswer {
    /// Its name in the file.
    pub name: Option<String>,
    /// Its text.
    pub property: String,
    /// True if it holds in all initial states; `None` if it was not answered.
    pub holds: Option<bool>,
    /// The probability or the reward over the initial states, if it was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub value: Option<Bound>,
    /// Number of states from which some strategy satisfies the formula surely.
    pub pmax_one: Option<Number>,
    /// Number of states from which some strategy possibly satisfies it.
    pub pmax_positive: Option<Number>,
    /// Number of states from which every strategy satisfies it surely.
    pub pmin_one: Option<Number>,
    /// Number of states from which every strategy possibly satisfies it.
    pub pmin_positive: Option<Number>,
    /// The reason for no answer.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
}

impl PropertyAnswer {
    /// Creates a property without an answer; `reason` says why it will have none.
    pub fn open(name: Option<String>, property: String, reason: Option<String>) -> Self {
        PropertyAnswer {
            name,
            property,
            holds: None,
            value: None,
            pmax_one: None,
            pmax_positive: None,
            pmin_one: None,
            pmin_positive: None,
            reason,
        }
    }
}

impl PropertiesReport {
    /// Creates a report without results.
    pub fn new(model: &str, file: Option<&str>, engine: &'static str, scope: Scope) -> Self {
        Envelope::of(PropertiesFindings {
            model: ModelSummary::of_path(model),
            file: file.map(str::to_owned),
            engine,
            scope,
            counts: None,
            properties: Vec::new(),
        })
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
            let value = answer.value.as_ref().map_or_else(String::new, shown);
            let words = [holds.to_owned(), value];
            let answered: Vec<String> = words.into_iter().filter(|w| !w.is_empty()).collect();
            grid.row(vec![
                title(answer),
                count(&answer.pmax_one),
                count(&answer.pmax_positive),
                count(&answer.pmin_one),
                count(&answer.pmin_positive),
                answered.join(": "),
            ]);
        }
        grid.text(style)
    }
}

/// Formats the bounds of a value: one number if they are equal, otherwise an interval.
pub(super) fn shown(value: &Bound) -> String {
    match value.lower == value.upper {
        true => value.lower.to_string(),
        false => format!("[{}, {}]", value.lower, value.upper),
    }
}

/// Formats the name and the text of a property in one line.
fn title(answer: &PropertyAnswer) -> String {
    let text = answer.property.split_whitespace().collect::<Vec<_>>().join(" ");
    answer.name.as_ref().map_or_else(|| text.clone(), |name| format!("\"{name}\": {text}"))
}

impl Findings for PropertiesFindings {
    const SCHEMA: &str = "meliora.reach/1";
    type Time = Total;

    fn is_no(&self) -> bool {
        self.properties.iter().any(|p| p.holds == Some(false))
    }

    fn text(report: &PropertiesReport, style: Style) -> String {
        let settings = [("engine", report.engine), ("scope", report.scope.name())];
        let files: Vec<&str> =
            [report.model.path.as_str()].into_iter().chain(report.file.as_deref()).collect();
        let mut out = text::title(&files, &settings, style);
        if report.model.kind.is_some() {
            out.push_str(&text::model(&report.model, report.counts.as_ref(), style));
        }
        if report.properties.iter().any(|p| p.reason.is_none()) {
            let _ = write!(out, "\n{}\n{}", style.bold("Properties"), report.table(style));
        }
        let others: Vec<_> = report.properties.iter().filter(|p| p.reason.is_some()).collect();
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
        out.push_str(&text::incomplete(report.error.as_ref(), style));
        out.push_str(&text::footer(report.time.total, &[], report.memory, style));
        out
    }
}
