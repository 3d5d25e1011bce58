//! The report of `meliora reach`.

use std::fmt::Write;
use std::ops::{Deref, DerefMut};

use schemars::{JsonSchema, Schema};
use serde::Serialize;
use serde_json::Value as Json;

use super::columns::{Column, Place};
use super::envelope::{Envelope, Findings, Phase};
use super::export::WrittenRegions;
use super::fields::is_nullable;
use super::properties::{self, shown};
use super::text::Grid;
use super::{Number, Style, unsafe_start};
use meliora_planning::result::ModelCounts;
use meliora_question::answers::{Answers, OneQuestion, Plan, PropertyAnswer};

/// The results of `reach`, in the order of the JSON fields.
#[derive(Debug, Clone, Default, Serialize, JsonSchema)]
#[schemars(rename = "reach", transform = keep_null)]
pub struct ReachFindings {
    /// The answers.
    #[serde(flatten)]
    pub answers: Answers,
    /// The dump of `--out`; absent without `--out`, and if it was not written.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub written: Option<WrittenRegions>,
}

impl Deref for ReachFindings {
    type Target = Answers;

    fn deref(&self) -> &Answers {
        &self.answers
    }
}

impl DerefMut for ReachFindings {
    fn deref_mut(&mut self) -> &mut Answers {
        &mut self.answers
    }
}

/// The fields of one question that may be `null`: a report of several questions does not have them.
const OF_ONE: [&str; 6] = ["target", "pmax_one", "pmax_positive", "pmin_one", "pmin_positive", "initial"];

/// Says of the fields of one question that may be `null` that they are so even where they may be absent.
fn keep_null(schema: &mut Schema) {
    let properties = schema.get_mut("properties").and_then(Json::as_object_mut);
    for (name, field) in properties.into_iter().flatten() {
        if OF_ONE.contains(&name.as_str())
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
        self.properties.iter().map(|answer| (properties::cell(answer), properties::note(answer))).collect()
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
            out += early(report);
        }
        out += &match (&report.one, report.properties.first()) {
            (Some(one), Some(answer)) => text_of_one(one, answer, report.header.is_game(), style),
            _ => properties::list(&report.properties, style),
        };
        out + &report.written.as_ref().map(WrittenRegions::text).unwrap_or_default()
    }
}

/// Says how properties were decided before the reachable states were known.
fn early(answers: &Answers) -> &'static str {
    match (answers.over_all_valuations, answers.by_guided_search) {
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

/// Formats the answer to one question.
fn text_of_one(one: &OneQuestion, answer: &PropertyAnswer, is_game: bool, style: Style) -> String {
    let mut out = String::new();
    if let Some(target) = &one.target {
        let _ = write!(out, "\n{}\n", style.bold(&format!("Reaching {}", answer.property)));
        let _ = writeln!(out, "  target states  {}", target.grouped());
    } else if one.sizes.any() {
        let _ = write!(out, "\n{}\n", style.bold(&format!("Satisfying {}", answer.property)));
    }
    if one.sizes.any() {
        out += &regions(one, is_game, style);
    }
    if let Some(value) = answer.value.iter().flatten().next() {
        let _ = write!(out, "\nThe value in the initial states: {}\n", style.bold(&shown(value)));
    }
    if answer.front.is_some() {
        let _ = write!(out, "\nThe Pareto front in the initial state: {}\n", properties::text(answer));
    }
    out += &properties::listing(answer, style);
    if let Some(reason) = &answer.reason {
        let _ = write!(out, "\nThe property has no value: {}.\n", style.bad(reason));
    }
    if let Some(holds) = answer.holds {
        let verdict = if holds { style.good("holds") } else { style.bad("does not hold") };
        let _ = write!(out, "\nThe property {verdict} in all initial states.\n");
    }
    out += &one.plan.as_ref().map(|plan| plan_text(plan, style)).unwrap_or_default();
    if answer.is_open() && !one.is_target {
        let _ = write!(out, "\nThe property is not decided.\n");
    }
    out
}

fn regions(one: &OneQuestion, is_game: bool, style: Style) -> String {
    let mut grid = Grid::new(&["", "states", "of the initial states"]);
    let (sizes, initial) = (&one.sizes, &one.initial);
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

/// Formats the plans for a target.
fn plan_text(plan: &Plan, style: Style) -> String {
    let mut out = String::new();
    let mut line = |what: &str, exists: Option<bool>| {
        if let Some(exists) = exists {
            let verdict = if exists { style.good("exists") } else { style.bad("does not exist") };
            let _ = writeln!(out, "{what} {verdict}.");
        }
    };
    line("A strong cyclic plan", plan.strong_cyclic);
    line("A strong plan", plan.strong);
    if let Some(states) = &plan.strong_states {
        let _ = writeln!(out, "States with a strong plan: {}", states.grouped());
    }
    if let Some(states) = &plan.policy_states {
        let _ =
            writeln!(out, "States with an action in the policy, checked one by one: {}", states.grouped());
    }
    if out.is_empty() { out } else { format!("\n{out}") }
}
