//! The report of `meliora reach` with several properties.

use std::fmt::Write;

use schemars::JsonSchema;
use serde::Serialize;

use super::envelope::{Envelope, Findings};
use super::text::Grid;
use super::{Number, Style, unsafe_start};
use meliora_engine::regions::Regions;
use meliora_model::decimal::readable;
use meliora_planning::result::{Escape, ModelCounts};
use meliora_quantities::state_values::Bound;

/// The answers to the properties of a file or of the command line.
#[derive(Debug, Clone, Default, Serialize, JsonSchema)]
#[schemars(rename = "reach")]
pub struct PropertiesFindings {
    /// The sizes of the model; `null` if unknown.
    pub counts: Option<ModelCounts>,
    /// An initial state from which no strategy keeps `--require`: no property holds, and no quantity
    /// has a value; absent without such a state.
    #[serde(rename = "unsafe", skip_serializing_if = "Option::is_none")]
    pub escape: Option<Escape>,
    /// The properties in their order.
    pub properties: Vec<PropertyAnswer>,
}

/// The report with times and memory.
pub type PropertiesReport = Envelope<PropertiesFindings>;

/// The numbers of states of the four regions; `None` while a region is not known.
pub type Sizes = Regions<Option<Number>>;

/// A property with its answer, or the reason for no answer.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct PropertyAnswer {
    /// Its name in the file; `null` without a name.
    pub name: Option<String>,
    /// Its text.
    pub property: String,
    /// It holds in all initial states; `null` if not answered.
    pub holds: Option<bool>,
    /// The probability or the expected reward over the initial states: in each of them, the value lies
    /// between these bounds; `null` if an initial state is unsafe, absent if not asked for, or unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("nullable" = true))]
    pub value: Option<Option<Bound>>,
    /// The sizes of its regions.
    #[serde(flatten)]
    pub sizes: Sizes,
    /// The reason for no answer, or for no value; absent if there are both.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
}

impl PropertyAnswer {
    /// Creates a property without an answer; `reason` says why it will have none.
    pub fn open(name: Option<String>, property: String, reason: Option<String>) -> Self {
        PropertyAnswer { name, property, holds: None, value: None, sizes: Sizes::default(), reason }
    }

    /// Adds the answer; `no_value` is the reason why a quantity that was asked for has no value.
    pub fn answer(&mut self, holds: Option<bool>, value: Option<Bound>, no_value: Option<&str>) {
        self.holds = holds;
        self.value = value.map(Some).or(no_value.map(|_| None));
        self.reason = no_value.map(str::to_owned);
    }
}

impl PropertiesFindings {
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
            let value = answer.value.iter().flatten().map(shown).collect();
            let words = [holds.to_owned(), value];
            let answered: Vec<String> = words.into_iter().filter(|w| !w.is_empty()).collect();
            grid.row(vec![
                title(answer),
                count(&answer.sizes.pmax_one),
                count(&answer.sizes.pmax_positive),
                count(&answer.sizes.pmin_one),
                count(&answer.sizes.pmin_positive),
                answered.join(": "),
            ]);
        }
        grid.text(style)
    }
}

/// Formats the bounds of a value: one number if they are equal, otherwise an interval.
pub(super) fn shown(value: &Bound) -> String {
    match value.lower == value.upper {
        true => readable(value.lower),
        false => format!("[{}, {}]", readable(value.lower), readable(value.upper)),
    }
}

/// Formats the name and the text of a property in one line.
fn title(answer: &PropertyAnswer) -> String {
    let text = answer.property.split_whitespace().collect::<Vec<_>>().join(" ");
    answer.name.as_ref().map_or_else(|| text.clone(), |name| format!("\"{name}\": {text}"))
}

impl Findings for PropertiesFindings {
    const SCHEMA: &str = "meliora.reach/1";
    const HEADER: (&[&str], &[&str]) = (&["model", "scope"], &["file", "engine", "engine_reason"]);

    fn is_no(&self) -> bool {
        self.properties.iter().any(|p| p.holds == Some(false))
    }

    fn body(report: &PropertiesReport, style: Style) -> String {
        let mut out = unsafe_start::text(report.escape.as_ref(), style);
        out += &report.header.sizes(report.counts.as_ref(), style);
        if report.properties.iter().any(|p| p.reason.is_none()) {
            let _ = write!(out, "\n{}\n{}", style.bold("Properties"), report.table(style));
        }
        let others = report.properties.iter().filter_map(|p| Some((p, p.reason.as_deref()?)));
        for (index, (answer, reason)) in others.enumerate() {
            if index == 0 {
                let _ = write!(out, "\n{}\n", style.bold("Not answered"));
            }
            let _ = writeln!(out, "  {}\n    {reason}", title(answer));
        }
        out
    }
}
