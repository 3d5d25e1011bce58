//! The report of `meliora reach`.

use std::fmt::Write;

use schemars::{JsonSchema, Schema};
use serde::Serialize;
use serde_json::Value as Json;

use super::columns::{Column, Place};
use super::envelope::{Envelope, Findings, Phase};
use super::export::WrittenRegions;
use super::fields::is_nullable;
use super::properties::{self, PropertyAnswer, Sizes, shown};
use super::text::Grid;
use super::{Number, Style, unsafe_start};
use meliora_engine::regions::Regions;
pub use meliora_planning::result::Share;
use meliora_planning::result::{Escape, ModelCounts};
use meliora_quantities::answer::Answer;

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
    /// A property, or an operator of one, was decided over all combinations of values, before the reachable states
    /// were known: the sizes of its regions are `null`, and so is `counts` unless another one needs all states; absent
    /// otherwise.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub over_all_valuations: bool,
    /// A property, or an operator of one, was decided by a guided search, before the reachable states were known: the
    /// sizes of its regions are `null`, and so is `counts` unless another one needs all states; absent otherwise.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub by_guided_search: bool,
    /// An initial state from which no strategy keeps `--require`: no property holds, and no quantity
    /// has a value; absent without such a state.
    #[serde(rename = "unsafe", skip_serializing_if = "Option::is_none")]
    pub escape: Option<Escape>,
    /// The fields of one question; absent with several properties.
    #[serde(flatten)]
    pub one: Option<OneQuestion>,
    /// The questions in their order: the properties, or the target.
    pub properties: Vec<PropertyAnswer>,
    /// The dump of `--out`; absent without `--out`, and if it was not written.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub written: Option<WrittenRegions>,
}

/// The fields of a run with one question, a target or a property.
#[derive(Debug, Clone, Default, Serialize, JsonSchema)]
#[schemars(transform = keep_null)]
pub struct OneQuestion {
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
    /// The plans for the target; absent without `--strong` and `--policy`, if the question is not the goal
    /// of a planning problem.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub plan: Option<Plan>,
    /// True for a target, which has no verdict.
    #[serde(skip)]
    pub is_target: bool,
}

/// Plans for a target, as planners ask for them.
#[derive(Debug, Clone, Default, Serialize, JsonSchema)]
#[schemars(inline)]
pub struct Plan {
    /// A strong cyclic plan exists from all initial states: it reaches the target almost surely if every
    /// outcome of an action has a positive probability; `null` if unknown.
    pub strong_cyclic: Option<bool>,
    /// A strong plan exists from all initial states: every path reaches the target within a bound; `null`
    /// without `--strong`, or if unknown.
    pub strong: Option<bool>,
    /// The number of states with a strong plan; `null` without `--strong`, or if unknown.
    pub strong_states: Option<Number>,
    /// The number of states outside the target that the policy of `--policy` visits; `null` without it, and if
    /// no plan exists.
    pub policy_states: Option<Number>,
}

impl Plan {
    fn text(&self, style: Style) -> String {
        let mut out = String::new();
        let mut line = |what: &str, exists: Option<bool>| {
            if let Some(exists) = exists {
                let verdict = if exists { style.good("exists") } else { style.bad("does not exist") };
                let _ = writeln!(out, "{what} {verdict}.");
            }
        };
        line("A strong cyclic plan", self.strong_cyclic);
        line("A strong plan", self.strong);
        if let Some(states) = &self.strong_states {
            let _ = writeln!(out, "States with a strong plan: {}", states.grouped());
        }
        if let Some(states) = &self.policy_states {
            let _ = writeln!(
                out,
                "States with an action in the policy, checked one by one: {}",
                states.grouped()
            );
        }
        if out.is_empty() { out } else { format!("\n{out}") }
    }
}

/// Says of the fields that may be `null` that they are so even where they may be absent.
fn keep_null(schema: &mut Schema) {
    let properties = schema.get_mut("properties").and_then(Json::as_object_mut);
    for (name, field) in properties.into_iter().flatten() {
        if name != "holds"
            && name != "plan"
            && is_nullable(field)
            && let Json::Object(field) = field
        {
            field.insert("nullable".to_owned(), true.into());
        }
    }
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

impl Findings for ReachFindings {
    const SCHEMA: &str = "meliora.reach/1";
    const HEADER: (&[&str], &[&str]) = (&["model", "scope"], &["file", "engine", "engine_reason"]);
    const PHASES: &[Phase] = &[
        Phase::new("parse", "Reading model and target"),
        Phase::BUILD,
        Phase::new("pmax_positive", "The region of this name").labelled("Pmax > 0"),
        Phase::new("pmax_one", "The region of this name").labelled("Pmax = 1"),
        Phase::new("pmin_positive", "The region of this name").labelled("Pmin > 0"),
        Phase::new("pmin_one", "The region of this name").labelled("Pmin = 1"),
        Phase::new("value", "The probability or the reward"),
        Phase::new("strong", "The region of `--strong`"),
        Phase::new("policy", "Finding and checking the policy of `--policy`"),
    ];

    fn is_no(&self) -> bool {
        self.properties.iter().any(|p| p.holds == Some(false))
    }

    fn counts(&self) -> Option<&ModelCounts> {
        self.counts.as_ref()
    }

    fn columns(&self) -> Vec<Column<Envelope<Self>>> {
        let of = |of: fn(&OneQuestion) -> &Option<Number>| {
            move |r: &ReachReport| of(r.one.as_ref()?).as_ref().map(ToString::to_string)
        };
        let region = |name: &'static str, size| Column::new(name, of(size)).yielding();
        if self.one.is_none() {
            return Vec::new();
        }
        vec![
            region("target", |one| &one.target).at(Place::Room(6)),
            region("pmax_one", |one| &one.sizes.pmax_one).plotted(),
            region("pmax_positive", |one| &one.sizes.pmax_positive).plotted(),
            region("pmin_one", |one| &one.sizes.pmin_one).plotted(),
            region("pmin_positive", |one| &one.sizes.pmin_positive).plotted(),
        ]
    }

    fn answers(&self) -> Vec<(String, Option<String>)> {
        self.properties.iter().map(|property| (property.cell(), property.note())).collect()
    }

    fn is_unread(&self) -> bool {
        let no_answer = |p: &PropertyAnswer| {
            p.reason.is_some() && p.value.is_none() && p.holds.is_none() && p.front.is_none()
        };
        !self.properties.is_empty() && self.properties.iter().all(no_answer)
    }

    fn body(report: &ReachReport, style: Style) -> String {
        let mut out = unsafe_start::text(report.escape.as_ref(), style);
        out += &report.header.sizes(report.counts.as_ref(), style);
        if report.stops_at_target && report.counts.is_some() {
            out += "The states behind those that decide the question are not explored, nor counted.\n";
        }
        if report.counts.is_none() {
            out += report.early();
        }
        out += &match (&report.one, report.properties.first()) {
            (Some(one), Some(answer)) => one.text(answer, report.header.is_game(), style),
            _ => properties::list(&report.properties, style),
        };
        out + &report.written.as_ref().map(WrittenRegions::text).unwrap_or_default()
    }
}

impl ReachFindings {
    /// Says how properties were decided before the reachable states were known.
    fn early(&self) -> &'static str {
        match (self.over_all_valuations, self.by_guided_search) {
            (true, true) => {
                "Properties were decided by guided searches and over all combinations of values, before the reachable\n\
                 states were known; these are not counted.\n"
            }
            (true, false) => {
                "The property was decided over all combinations of values, before the reachable states were\n\
                 known; these are not counted.\n"
            }
            (false, true) => {
                "The property was decided by a guided search, before the reachable states were known; these are not\n\
                 counted.\n"
            }
            (false, false) => "",
        }
    }

    /// Adds the answer to a question; so far, it may be incomplete.
    pub fn answer(&mut self, position: usize, answer: &Answer) {
        self.properties[position].answer(answer);
        if let Some(one) = &mut self.one {
            one.holds = answer.holds;
        }
    }
}

impl OneQuestion {
    fn text(&self, answer: &PropertyAnswer, is_game: bool, style: Style) -> String {
        let mut out = String::new();
        if let Some(target) = &self.target {
            let _ = write!(out, "\n{}\n", style.bold(&format!("Reaching {}", answer.property)));
            let _ = writeln!(out, "  target states  {}", target.grouped());
        } else if self.sizes.any() {
            let _ = write!(out, "\n{}\n", style.bold(&format!("Satisfying {}", answer.property)));
        }
        if self.sizes.any() {
            out += &self.regions(is_game, style);
        }
        if let Some(value) = answer.value.iter().flatten().next() {
            let _ = write!(out, "\nThe value in the initial states: {}\n", style.bold(&shown(value)));
        }
        if answer.front.is_some() {
            let _ = write!(out, "\nThe Pareto front in the initial state: {}\n", answer.text());
        }
        out += &properties::listing(answer, style);
        if let Some(reason) = &answer.reason {
            let _ = write!(out, "\nThe property has no value: {}.\n", style.bad(reason));
        }
        if let Some(holds) = answer.holds {
            let verdict = if holds { style.good("holds") } else { style.bad("does not hold") };
            let _ = write!(out, "\nThe property {verdict} in all initial states.\n");
        }
        out += &self.plan.as_ref().map(|plan| plan.text(style)).unwrap_or_default();
        if answer.is_open() && !self.is_target {
            let _ = write!(out, "\nThe property is not decided.\n");
        }
        out
    }

    fn regions(&self, is_game: bool, style: Style) -> String {
        let mut grid = Grid::new(&["", "states", "of the initial states"]);
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
