//! The report of `meliora info`.

use std::fmt::Write;
use std::io;

use schemars::JsonSchema;
use serde::Serialize;

use super::Style;
use super::envelope::{Envelope, Findings, Phase};
use super::players::{self, PlayerSummary};
use super::report::{Failure, Report};
use super::text::{self, Grid};
use meliora_lang::flat::Flat;
use meliora_model::Program;
use meliora_model::rewards::{Earner, RewardStructure};
use meliora_planning::result::ModelCounts;

/// Maximum number of value names shown for one variable.
const MOST_NAMES: usize = 6;

/// The results of `info`, in the order of the JSON fields.
#[derive(Debug, Clone, Default, Serialize, JsonSchema)]
#[schemars(rename = "info")]
pub struct InfoFindings {
    /// The sizes of the model; `null` if unknown.
    pub counts: Option<ModelCounts>,
    /// The variables of the diagrams from the root down: `x.2` is bit 2 of `x`, a Boolean has its name; `null` for the
    /// explicit engine, or if unknown.
    pub order: Option<Vec<String>>,
    /// The sizes of diagrams; `null` for the explicit engine, or if unknown.
    pub nodes: Option<Nodes>,
    /// The reason for the order; absent if it was not computed from the model.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub order_reason: Option<String>,
    /// The reward structures; empty if unknown.
    pub rewards: Vec<RewardSummary>,
    /// The players of a game; absent for other models, and if unknown.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub players: Vec<PlayerSummary>,
}

/// The report with times and memory.
pub type InfoReport = Envelope<InfoFindings>;

/// A reward structure.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct RewardSummary {
    /// Its name; `null` without a name.
    pub name: Option<String>,
    /// The number of items that states earn.
    pub states: usize,
    /// The number of items that choices earn, by their action or by a command.
    pub choices: usize,
    /// The reason why it cannot be used; absent if it can.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<String>,
}

impl RewardSummary {
    /// Describes the reward structures of a program.
    pub fn all(program: &Program) -> Vec<RewardSummary> {
        let summary = |structure: &RewardStructure| {
            let states = structure.items.iter().filter(|i| i.earner == Earner::State).count();
            RewardSummary {
                name: structure.name.clone(),
                states,
                choices: structure.items.len() - states,
                error: structure.errors.first().map(|e| e.message.clone()),
            }
        };
        program.rewards.iter().map(summary).collect()
    }
}

/// Sizes of diagrams.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Nodes {
    /// The nodes of all transition relations together.
    pub transition: u64,
    /// The nodes of the set of states.
    pub reachable: u64,
}

impl InfoReport {
    fn variables(&self, style: Style) -> String {
        if self.header.model.as_ref().is_some_and(|model| model.variables.is_empty()) {
            return format!("\n{}\n  none\n", style.bold("Variables"));
        }
        let mut grid = Grid::new(&["variable", "range", "bits"]);
        for v in self.header.model.iter().flat_map(|model| &model.variables) {
            let range = match v.ty {
                "bool" => "bool".to_owned(),
                _ if !v.values.is_empty() => locations(&v.values),
                _ => format!("[{}..{}]", v.low, v.high),
            };
            grid.row(vec![v.name.clone(), range, v.bits.to_string()]);
        }
        grid.titled("Variables", style)
    }

    fn reward_structures(&self, style: Style) -> String {
        if self.rewards.is_empty() {
            return String::new();
        }
        let mut grid = Grid::new(&["rewards", "of states", "of choices", ""]);
        for structure in &self.rewards {
            let name = structure.name.clone().unwrap_or_else(|| "(no name)".to_owned());
            let note = if structure.error.is_some() { "cannot be used" } else { "" };
            let (states, choices) = (structure.states.to_string(), structure.choices.to_string());
            grid.row(vec![name, states, choices, note.to_owned()]);
        }
        grid.titled("Reward structures", style)
    }

    fn diagrams(&self, style: Style) -> String {
        let mut out = String::new();
        if let Some(nodes) = self.nodes {
            let numbers = [("transition relations", nodes.transition), ("states", nodes.reachable)];
            let numbers = numbers.map(|(name, n)| (name, n.into()));
            let numbers = numbers.each_ref().map(|(name, n)| (*name, n));
            let _ = write!(out, "\n{}\n{}", style.bold("Nodes"), text::aligned(&numbers));
        }
        if let Some(order) = &self.order {
            let width = usize::from(style.width.unwrap_or(100)).saturating_sub(2).max(20);
            let _ = write!(
                out,
                "\n{}\n{}",
                style.bold("Order of the BDD variables"),
                text::wrapped(order, "  ", width)
            );
            if let Some(reason) = &self.order_reason {
                let words: Vec<String> = reason.split(' ').map(str::to_owned).collect();
                out += &text::wrapped(&words, "  ", width);
            }
        }
        out
    }
}

impl Findings for InfoFindings {
    const SCHEMA: &str = "meliora.info/1";
    const HEADER: (&[&str], &[&str]) = (&["model", "engine", "scope"], &["engine_reason"]);
    const PHASES: &[Phase] =
        &[Phase::new("parse", "Reading the model"), Phase::BUILD, Phase::new("count", "Counting")];

    fn body(report: &InfoReport, style: Style) -> String {
        let sizes = report.header.sizes(report.counts.as_ref(), style);
        let variables = match sizes.is_empty() {
            true => String::new(),
            false => report.variables(style) + &report.reward_structures(style),
        };
        sizes + &players::text(&report.players, style) + &variables + &report.diagrams(style)
    }
}

/// A flat program as text: a report without numbers.
#[derive(Default, Serialize)]
pub struct FlatReport {
    /// The program; `None` until it is read.
    #[serde(skip)]
    pub flat: Option<Flat>,
}

impl Report for FlatReport {
    fn fail(&mut self, _: Failure) {}

    fn finish(&mut self, _: f64, _: u64) {}

    fn text(&self, _: Style) -> String {
        self.flat.as_ref().map_or_else(String::new, Flat::to_string)
    }

    fn write(&self, _: Style, out: &mut dyn io::Write) -> io::Result<()> {
        self.flat.as_ref().map_or(Ok(()), |flat| write!(out, "{flat}"))
    }
}

/// Formats names of values as `{idle, busy}`, the first ones only if there are many.
fn locations(names: &[String]) -> String {
    let shown = names.iter().take(MOST_NAMES).map(String::as_str).collect::<Vec<_>>().join(", ");
    match names.len().saturating_sub(MOST_NAMES) {
        0 => format!("{{{shown}}}"),
        more => format!("{{{shown}, … {more} more}}"),
    }
}
