//! The report of `meliora reach`.

use std::fmt::Write;

use serde::Serialize;

use super::envelope::{Envelope, Findings, Time};
use super::properties::{PropertyAnswer, shown};
use super::report::{Counts, ModelSummary};
use super::text::{self, Grid};
use super::values::Bound;
use super::{Number, Style};
use crate::engine::Scope;

/// The results of `reach`, in the order of the JSON fields.
#[derive(Debug, Clone, Serialize)]
pub struct ReachFindings {
    /// The model.
    pub model: ModelSummary,
    /// The name of the engine.
    pub engine: &'static str,
    /// The valuations that are states.
    pub scope: Scope,
    /// Sizes of the model.
    pub counts: Option<Counts>,
    /// The target or the property.
    #[serde(skip)]
    pub expression: String,
    /// Number of target states.
    pub target: Option<Number>,
    /// Number of states from which some strategy satisfies it with probability 1.
    pub pmax_one: Option<Number>,
    /// Number of states from which some strategy satisfies it with probability > 0.
    pub pmax_positive: Option<Number>,
    /// Number of states from which every strategy satisfies it with probability 1.
    pub pmin_one: Option<Number>,
    /// Number of states from which every strategy satisfies it with probability > 0.
    pub pmin_positive: Option<Number>,
    /// The share of initial states in each region.
    pub initial: InitialShare,
    /// True if the property of `--property` holds in all initial states.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub holds: Option<bool>,
    /// The value of the property over the initial states.
    #[serde(skip)]
    pub value: Option<Bound>,
    /// The property with its answer, as for several properties.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub properties: Vec<PropertyAnswer>,
}

/// The report with times and memory.
pub type ReachReport = Envelope<ReachFindings>;

/// The share of initial states in each region.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct InitialShare {
    /// The share in `pmax_one`.
    pub pmax_one: Option<Share>,
    /// The share in `pmax_positive`.
    pub pmax_positive: Option<Share>,
    /// The share in `pmin_one`.
    pub pmin_one: Option<Share>,
    /// The share in `pmin_positive`.
    pub pmin_positive: Option<Share>,
}

/// A share of the initial states.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Share {
    /// All initial states.
    All,
    /// Some initial states, but not all.
    Some,
    /// Not a single initial state.
    None,
}

impl Share {
    fn word(self) -> &'static str {
        match self {
            Share::All => "all",
            Share::Some => "some",
            Share::None => "none",
        }
    }
}

/// Seconds by phase; `None` for an unfinished phase.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct ReachTime {
    /// Reading the model and the target.
    pub parse: Option<f64>,
    /// Encoding the model and finding the reachable states.
    pub build: Option<f64>,
    /// The region of that name.
    pub pmax_positive: Option<f64>,
    /// The region of that name.
    pub pmax_one: Option<f64>,
    /// The region of that name.
    pub pmin_positive: Option<f64>,
    /// The region of that name.
    pub pmin_one: Option<f64>,
    /// The value of a probability or a reward.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub value: Option<f64>,
    /// The total.
    pub total: f64,
}

impl Time for ReachTime {
    fn total(&mut self) -> &mut f64 {
        &mut self.total
    }
}

impl ReachReport {
    /// Creates a report without results.
    pub fn new(model: &str, engine: &'static str, scope: Scope, expression: &str) -> Self {
        Envelope::of(ReachFindings {
            model: ModelSummary::of_path(model),
            engine,
            scope,
            counts: None,
            expression: expression.to_owned(),
            target: None,
            pmax_one: None,
            pmax_positive: None,
            pmin_one: None,
            pmin_positive: None,
            initial: InitialShare::default(),
            holds: None,
            value: None,
            properties: Vec::new(),
        })
    }
}

impl Findings for ReachFindings {
    const SCHEMA: &str = "meliora.reach/1";
    type Time = ReachTime;

    fn is_no(&self) -> bool {
        self.holds == Some(false)
    }

    fn text(report: &ReachReport, style: Style) -> String {
        let settings = [("engine", report.engine), ("scope", report.scope.name())];
        let mut out = text::title(&[&report.model.path], &settings, style);
        if report.model.kind.is_some() {
            out.push_str(&text::model(&report.model, report.counts.as_ref(), style));
        }
        if let Some(target) = &report.target {
            let _ = write!(out, "\n{}\n", style.bold(&format!("Reaching {}", report.expression)));
            let _ = writeln!(out, "  target states  {}", target.grouped());
            out.push_str(&report.regions(style));
        } else if report.pmax_positive.is_some() {
            let _ = write!(out, "\n{}\n", style.bold(&format!("Satisfying {}", report.expression)));
            out.push_str(&report.regions(style));
        }
        if let Some(value) = &report.value {
            let _ = write!(out, "\nThe value in the initial states: {}\n", style.bold(&shown(value)));
        }
        if let Some(holds) = report.holds {
            let verdict = if holds { style.good("holds") } else { style.bad("does not hold") };
            let _ = write!(out, "\nThe property {verdict} in all initial states.\n");
        }
        out.push_str(&text::incomplete(report.error.as_ref(), style));
        out.push_str(&report.times(style));
        out
    }
}

impl ReachReport {
    /// Adds the property with its answer to the list.
    pub fn list_property(&mut self) {
        let mut answer = PropertyAnswer::open(None, self.expression.clone(), None);
        (answer.holds, answer.value) = (self.holds, self.value.clone());
        (answer.pmax_one, answer.pmax_positive) = (self.pmax_one.clone(), self.pmax_positive.clone());
        (answer.pmin_one, answer.pmin_positive) = (self.pmin_one.clone(), self.pmin_positive.clone());
        self.properties = vec![answer];
    }

    fn regions(&self, style: Style) -> String {
        let mut grid = Grid::new(&["", "states", "of the initial states"], style);
        let initial = &self.initial;
        let rows = [
            ("some strategy, surely     (Pmax = 1)", &self.pmax_one, initial.pmax_one),
            ("some strategy, possibly   (Pmax > 0)", &self.pmax_positive, initial.pmax_positive),
            ("every strategy, surely    (Pmin = 1)", &self.pmin_one, initial.pmin_one),
            ("every strategy, possibly  (Pmin > 0)", &self.pmin_positive, initial.pmin_positive),
        ];
        for (name, region, share) in rows {
            if let Some(region) = region {
                let share = share.map_or("", Share::word).to_owned();
                grid.row(vec![name.to_owned(), region.grouped(), share]);
            }
        }
        grid.text(style)
    }

    fn times(&self, style: Style) -> String {
        let time = &self.time;
        let phases = [
            ("parse", time.parse),
            ("build", time.build),
            ("Pmax > 0", time.pmax_positive),
            ("Pmax = 1", time.pmax_one),
            ("Pmin > 0", time.pmin_positive),
            ("Pmin = 1", time.pmin_one),
            ("value", time.value),
        ];
        text::footer(time.total, &phases, self.memory, style)
    }
}
