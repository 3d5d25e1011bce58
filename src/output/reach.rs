//! The report of `meliora reach`.

use std::fmt::Write;

use serde::Serialize;

use super::envelope::{Envelope, Findings, Time};
use super::properties::PropertyAnswer;
use super::report::{Counts, ModelSummary};
use super::text::{self, Grid};
use super::{Number, Style};
use crate::engine::Scope;

/// What `reach` found, in the order in which JSON has it.
#[derive(Debug, Clone, Serialize)]
pub struct ReachFindings {
    /// The model.
    pub model: ModelSummary,
    /// The name of the engine.
    pub engine: &'static str,
    /// Which valuations are states.
    pub scope: Scope,
    /// Sizes of the model.
    pub counts: Option<Counts>,
    /// The expression that was asked for.
    #[serde(skip)]
    pub expression: String,
    /// States of the target.
    pub target: Option<Number>,
    /// States where some strategy reaches it with probability 1.
    pub pmax_one: Option<Number>,
    /// States where some strategy reaches it with probability > 0.
    pub pmax_positive: Option<Number>,
    /// States where every strategy reaches it with probability 1.
    pub pmin_one: Option<Number>,
    /// States where every strategy reaches it with probability > 0.
    pub pmin_positive: Option<Number>,
    /// How many of the initial states lie in each region.
    pub initial: InitialShare,
    /// The verdict on `--property`: whether it holds in all initial states.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub holds: Option<bool>,
    /// The property with its answer, as where several are asked.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub properties: Vec<PropertyAnswer>,
}

/// The report with what it took.
pub type ReachReport = Envelope<ReachFindings>;

/// How many of the initial states lie in each region.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct InitialShare {
    /// Of `pmax_one`.
    pub pmax_one: Option<Share>,
    /// Of `pmax_positive`.
    pub pmax_positive: Option<Share>,
    /// Of `pmin_one`.
    pub pmin_one: Option<Share>,
    /// Of `pmin_positive`.
    pub pmin_positive: Option<Share>,
}

/// How many of the initial states.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Share {
    /// All of them.
    All,
    /// Some but not all.
    Some,
    /// None.
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

/// Seconds by phase; none for a phase that was not finished.
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
    /// Everything.
    pub total: f64,
}

impl Time for ReachTime {
    fn total(&mut self) -> &mut f64 {
        &mut self.total
    }
}

impl ReachReport {
    /// A report of which nothing but the question is known.
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
            let _ = writeln!(out, "  states of the target  {}", target.grouped());
            out.push_str(&report.regions(style));
        } else if report.pmax_positive.is_some() {
            let _ = write!(out, "\n{}\n", style.bold(&format!("Where {}", report.expression)));
            out.push_str(&report.regions(style));
        }
        if let Some(holds) = report.holds {
            let verdict = if holds { style.good("holds") } else { style.bad("does not hold") };
            let _ = write!(out, "\nIn the initial states it {verdict}.\n");
        }
        out.push_str(&text::incomplete(report.error.as_ref(), style));
        out.push_str(&report.times(style));
        out
    }
}

impl ReachReport {
    /// Lists the property that was asked, with its answer.
    pub fn list_property(&mut self) {
        let mut answer = PropertyAnswer::open(None, self.expression.clone(), None);
        answer.holds = self.holds;
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
        ];
        text::footer(time.total, &phases, self.memory, style)
    }
}
