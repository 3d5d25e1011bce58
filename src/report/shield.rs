//! The report of `meliora shield`.

use std::fmt::Write;

use schemars::JsonSchema;
use serde::Serialize;

use super::Style;
use super::envelope::{Envelope, Findings, Phase};
use super::text::{listed, plural};
use super::values_text::{digits, number};
use meliora_model::Program;
use meliora_model::valuation::Valuation;
use meliora_planning::{Shield, ShieldNode};
use meliora_quantities::state_values::Bound;

/// The results of `shield`, in the order of the JSON fields.
#[derive(Debug, Clone, Default, Serialize, JsonSchema)]
#[schemars(rename = "shield")]
pub struct ShieldFindings {
    /// The property whose values are listed; `null` until it is read.
    pub property: Option<String>,
    /// The name of a shield expression; absent without one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// The least safety of a permitted action; for `Pmin`, the safety is 1 minus the value.
    pub threshold: Option<f64>,
    /// True if the threshold is a factor of the best safety of the state.
    pub relative: Option<bool>,
    /// Number of steps that a bounded property looks ahead; absent if it is not bounded.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub horizon: Option<u64>,
    /// The sizes of the shield; `null` until it is computed.
    pub sizes: Option<ShieldSizes>,
    /// The first states, with monitors if the property needs some.
    pub states: Vec<ShieldedState>,
    /// Number of states that are not listed here.
    pub more: usize,
    /// The directory of the shield (`--out`); absent if none is written.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub written: Option<String>,
}

/// The sizes of a shield.
#[derive(Debug, Clone, Serialize, JsonSchema)]
#[schemars(rename = "shield_sizes")]
pub struct ShieldSizes {
    /// Number of states.
    pub states: usize,
    /// Number of actions of all states.
    pub actions: usize,
    /// Number of actions that are permitted.
    pub permitted: usize,
    /// Number of states in which no action reaches the threshold, so that those with the best safety are permitted.
    pub below: usize,
}

/// A state with its actions.
#[derive(Debug, Clone, Serialize, JsonSchema)]
#[schemars(rename = "shielded_state")]
pub struct ShieldedState {
    /// The values of its variables.
    pub state: Valuation,
    /// `true`: the opponent chooses here, and may do so freely; absent for other states.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub theirs: bool,
    /// `true`: the formula is true or false here, whatever follows; absent for other states.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub decided: bool,
    /// `true` if the permitted actions reach the threshold.
    pub secure: bool,
    /// The actions, in the order of the program.
    pub actions: Vec<ShieldedAction>,
}

/// An action with its value.
#[derive(Debug, Clone, Serialize, JsonSchema)]
#[schemars(rename = "shielded_action")]
pub struct ShieldedAction {
    /// Its name.
    pub action: String,
    /// The best probability of the formula after it.
    pub value: Bound,
    /// True if it is permitted.
    pub permitted: bool,
    /// The action that is taken instead, if this one is not permitted; absent for others.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub instead: Option<String>,
}

/// The report with times and memory.
pub type ShieldReport = Envelope<ShieldFindings>;

impl ShieldFindings {
    /// Adds the shield of a program, with its first states.
    pub fn add(&mut self, shield: &Shield, program: &Program, shown: usize) {
        let actions = || shield.nodes.iter().flat_map(|node| &node.actions);
        if let Some(rule) = &shield.rule {
            self.property = Some(rule.property.clone());
            (self.threshold, self.relative) = (Some(rule.threshold), Some(rule.relative));
            self.horizon = rule.horizon;
        }
        self.sizes = Some(ShieldSizes {
            states: shield.nodes.len(),
            actions: actions().count(),
            permitted: actions().filter(|action| action.permitted).count(),
            below: shield.nodes.iter().filter(|node| !node.secure).count(),
        });
        let listed = shield.nodes.iter().take(shown);
        self.states = listed.map(|node| ShieldedState::of(shield, program, node)).collect();
        self.more = shield.nodes.len() - self.states.len();
    }
}

impl ShieldedState {
    /// Copies a node of a shield.
    pub fn of(shield: &Shield, program: &Program, node: &ShieldNode) -> Self {
        let name = |at: usize| shield.actions[node.actions[at].action].clone();
        let action = |at: usize| {
            let [lower, upper] = node.actions[at].value.unwrap_or([0.0, 1.0]);
            let permitted = node.actions[at].permitted;
            ShieldedAction {
                action: name(at),
                value: Bound { lower, upper, exact: None },
                permitted,
                instead: (!permitted).then(|| name(node.pick)),
            }
        };
        ShieldedState {
            state: Valuation::new(program, &node.state),
            theirs: node.theirs,
            decided: node.decided,
            secure: node.secure,
            actions: (0..node.actions.len()).map(action).collect(),
        }
    }

    /// Returns the cells of the lines of a table: one for each action.
    pub fn rows(&self) -> impl Iterator<Item = Vec<String>> {
        self.actions.iter().map(|action| {
            let mut cells: Vec<String> = self.state.cells().collect();
            let Bound { lower, upper, .. } = action.value;
            cells.extend([action.action.clone(), lower.to_string(), upper.to_string()]);
            cells.extend([action.permitted.to_string(), action.instead.clone().unwrap_or_default()]);
            cells
        })
    }
}

/// Returns the heading of [`ShieldedState::rows`].
pub fn heading(program: &Program) -> impl Iterator<Item = &str> {
    let columns = ["action", "value_lower", "value_upper", "permitted", "instead"];
    program.variables.iter().map(|variable| variable.name.as_str()).chain(columns)
}

impl Findings for ShieldFindings {
    const SCHEMA: &str = "meliora.shield/1";
    const HEADER: (&[&str], &[&str]) = (&["model", "scope"], &["engine", "engine_reason"]);
    const PHASES: &[Phase] = &[
        Phase::new("parse", "Reading model and property"),
        Phase::BUILD,
        Phase::new("values", "Computing the values of all actions"),
        Phase::new("write", "Writing the shield"),
    ];

    fn body(report: &ShieldReport, style: Style) -> String {
        let Some(sizes) = &report.sizes else { return String::new() };
        let (property, threshold) =
            (report.property.as_deref().unwrap_or("?"), report.threshold.unwrap_or(0.0));
        let mut text = format!("\n{}\n", style.bold(&format!("Shield by {property}")));
        let of = if report.relative == Some(true) { " times the best safety" } else { "" };
        let _ = writeln!(text, "  permitted: safety of at least {}{of}", digits(threshold));
        let (states, actions) = (plural(sizes.states, "state"), plural(sizes.actions, "action"));
        let _ = writeln!(text, "  {states}, {actions}, {} permitted", sizes.permitted);
        if sizes.below > 0 {
            let _ = writeln!(
                text,
                "  below the threshold, only the best is permitted: {}",
                plural(sizes.below, "state")
            );
        }
        if !report.states.is_empty() {
            let mut rows = vec![["state", "action", "value", "permitted"].map(str::to_owned).to_vec()];
            report.states.iter().for_each(|state| state.lines(&mut rows));
            text += "\n";
            text += &listed(&rows, style);
        }
        if report.more > 0 {
            let _ = writeln!(text, "    and {}", plural(report.more, "more state"));
        }
        if let Some(directory) = &report.written {
            let _ = writeln!(text, "\nWritten to {directory}");
        }
        text
    }
}

impl ShieldedState {
    /// Adds the lines of the state to a table for people.
    fn lines(&self, rows: &mut Vec<Vec<String>>) {
        for (at, action) in self.actions.iter().enumerate() {
            let state = if at == 0 { self.state.to_string() } else { String::new() };
            let permitted = match &action.instead {
                Some(instead) => format!("no: {instead}"),
                None if self.theirs => "opponent".to_owned(),
                None if !self.secure => "best".to_owned(),
                None => "yes".to_owned(),
            };
            rows.push(vec![state, action.action.clone(), number(&action.value), permitted]);
        }
    }
}
