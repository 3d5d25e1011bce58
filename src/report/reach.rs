//! The report of `meliora reach`.

use std::fmt::Write;

use schemars::JsonSchema;
use serde::Serialize;

use super::envelope::{Envelope, Findings, Phase};
use super::export::WrittenRegions;
use super::header::Header;
use super::properties::{PropertyAnswer, Sizes, shown};
use super::text::Grid;
use super::{Number, Style, unsafe_start};
use meliora_engine::regions::Regions;
pub use meliora_planning::result::Share;
use meliora_planning::result::{Escape, ModelCounts};
use meliora_quantities::answer::Answer;
use meliora_quantities::state_values::Bound;

/// The results of `reach`, in the order of the JSON fields.
#[derive(Debug, Clone, Default, Serialize, JsonSchema)]
#[schemars(rename = "reach")]
pub struct ReachFindings {
    /// The sizes of the model; `null` if unknown.
    pub counts: Option<ModelCounts>,
    /// The states that decide the question are not left (`--stop-at-target`): all counts are those of the
    /// part explored; absent otherwise.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub stops_at_target: bool,
    /// An initial state from which no strategy keeps `--require`: no property holds, and no quantity
    /// has a value; absent without such a state.
    #[serde(rename = "unsafe", skip_serializing_if = "Option::is_none")]
    pub escape: Option<Escape>,
    /// The target or the property.
    #[serde(skip)]
    pub expression: String,
    /// The number of target states; absent with several properties, `null` if unknown or not a
    /// reachability question.
    pub target: Option<Number>,
    /// The sizes of the regions; `None` if unknown, or not needed by the property.
    #[serde(flatten)]
    pub sizes: Sizes,
    /// The share of the initial states in each region; absent with several properties.
    pub initial: Regions<Option<Share>>,
    /// The property holds in all initial states; absent with `--target`, with several properties, or
    /// if unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub holds: Option<bool>,
    /// The value of the property over the initial states.
    #[serde(skip)]
    pub value: Option<Bound>,
    /// The reason why a quantity that was asked for has no value.
    #[serde(skip)]
    pub no_value: Option<&'static str>,
    /// The properties in their order; absent with `--target`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub properties: Vec<PropertyAnswer>,
    /// The dump of `--out`; absent without `--out`, and if it was not written.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub written: Option<WrittenRegions>,
}

/// The report with times and memory.
pub type ReachReport = Envelope<ReachFindings>;

/// The regions in their order.
const NAMES: [&str; 4] = [
    "some strategy, surely     (Pmax = 1)",
    "some strategy, possibly   (Pmax > 0)",
    "every strategy, surely    (Pmin = 1)",
    "every strategy, possibly  (Pmin > 0)",
];

/// The regions of a game in their order.
const NAMES_IN_GAMES: [&str; 4] = [
    "we can enforce it surely              (Pmax = 1)",
    "we can enforce it possibly            (Pmax > 0)",
    "the opponent can enforce it surely    (Pmin = 1)",
    "the opponent can enforce it possibly  (Pmin > 0)",
];

impl ReachReport {
    /// Creates a report without results.
    pub fn of_expression(header: Header, expression: &str) -> Self {
        Envelope::of(header, ReachFindings { expression: expression.to_owned(), ..Default::default() })
    }
}

impl Findings for ReachFindings {
    const SCHEMA: &str = "meliora.reach/1";
    const HEADER: (&[&str], &[&str]) = (&["model", "scope"], &["engine", "engine_reason"]);
    const PHASES: &[Phase] = &[
        Phase::new("parse", "Reading model and target"),
        Phase::BUILD,
        Phase::new("pmax_positive", "The region of this name").labelled("Pmax > 0"),
        Phase::new("pmax_one", "The region of this name").labelled("Pmax = 1"),
        Phase::new("pmin_positive", "The region of this name").labelled("Pmin > 0"),
        Phase::new("pmin_one", "The region of this name").labelled("Pmin = 1"),
        Phase::new("value", "The probability or the reward"),
    ];

    fn is_no(&self) -> bool {
        self.holds == Some(false)
    }

    fn body(report: &ReachReport, style: Style) -> String {
        let mut out = unsafe_start::text(report.escape.as_ref(), style);
        out += &report.header.sizes(report.counts.as_ref(), style);
        if report.stops_at_target && report.counts.is_some() {
            out += "The states behind those that decide the question are not explored, nor counted.\n";
        }
        if let Some(target) = &report.target {
            let _ = write!(out, "\n{}\n", style.bold(&format!("Reaching {}", report.expression)));
            let _ = writeln!(out, "  target states  {}", target.grouped());
            if report.sizes.any() {
                out += &report.regions(report.header.is_game(), style);
            }
        } else if report.sizes.any() {
            let _ = write!(out, "\n{}\n", style.bold(&format!("Satisfying {}", report.expression)));
            out += &report.regions(report.header.is_game(), style);
        }
        if let Some(value) = &report.value {
            let _ = write!(out, "\nThe value in the initial states: {}\n", style.bold(&shown(value)));
        }
        if let Some(reason) = &report.no_value {
            let _ = write!(out, "\nThe property has no value: {}.\n", style.bad(reason));
        }
        if let Some(holds) = report.holds {
            let verdict = if holds { style.good("holds") } else { style.bad("does not hold") };
            let _ = write!(out, "\nThe property {verdict} in all initial states.\n");
        }
        if report.properties.iter().any(PropertyAnswer::is_open) {
            let _ = write!(out, "\nThe property is not decided.\n");
        }
        out + &report.written.as_ref().map(WrittenRegions::text).unwrap_or_default()
    }
}

impl ReachFindings {
    /// Adds the answer to a property; so far, it may be incomplete.
    pub fn answer(&mut self, answer: &Answer) {
        (self.holds, self.value, self.no_value) = (answer.holds, answer.value.clone(), answer.no_value);
        let mut listed = PropertyAnswer::open(None, self.expression.clone(), None);
        listed.answer(answer);
        listed.sizes = self.sizes.clone();
        self.properties = vec![listed];
    }

    fn regions(&self, is_game: bool, style: Style) -> String {
        let mut grid = Grid::new(&["", "states", "of the initial states"], style);
        let (sizes, initial) = (&self.sizes, &self.initial);
        let rows = [
            (&sizes.pmax_one, initial.pmax_one),
            (&sizes.pmax_positive, initial.pmax_positive),
            (&sizes.pmin_one, initial.pmin_one),
            (&sizes.pmin_positive, initial.pmin_positive),
        ];
        let names = if is_game { NAMES_IN_GAMES } else { NAMES };
        for (name, (region, share)) in names.into_iter().zip(rows) {
            if let Some(region) = region {
                let share = share.map_or_else(String::new, |share| share.to_string());
                grid.row(vec![name.to_owned(), region.grouped(), share]);
            }
        }
        grid.text(style)
    }
}
