//! The answers to the questions of `meliora reach`.

use std::fmt::Write;

use schemars::JsonSchema;
use serde::Serialize;

use super::text::Grid;
use super::{Number, Style};
use meliora_base::decimal::{readable, rounded};
use meliora_engine::regions::{Regions, Which};
use meliora_model::valuation::Valuation;
use meliora_quantities::answer::Answer;
use meliora_quantities::state_values::Bound;

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
    /// between these bounds; for the filter `min` or `max` of a JANI model, bounds of the least or the
    /// greatest of them; `null` if an initial state is unsafe, absent if not asked for, or unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("nullable" = true))]
    pub value: Option<Option<Bound>>,
    /// The values of the states that the filter of the property lists; absent without such a filter.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub values: Option<Vec<ListedState>>,
    /// Points of the Pareto front of several objectives, each with their values: one strategy attains them, and
    /// no strategy attains values that are better than the means of points by more than the precision; absent
    /// for other properties.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub front: Option<Vec<Vec<f64>>>,
    /// A strong cyclic plan exists for the goal of the planning problem, about which the property asks; absent if
    /// it is about something else, and with one question, which has `plan`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub strong_cyclic: Option<bool>,
    /// The sizes of its regions.
    #[serde(flatten)]
    pub sizes: Sizes,
    /// The reason for no answer, or for no value; absent if there are both.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// The line of the file of properties, or of the JANI model, that the reason is about, from 1; absent
    /// if it is about no place.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub line: Option<usize>,
    /// The column, from 1; absent if `line` is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub column: Option<usize>,
}

/// The value of a property in a state.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct ListedState {
    /// The values of its variables.
    pub state: Valuation,
    /// True if the condition holds there; absent for a number.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub holds: Option<bool>,
    /// The number; absent for a condition.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub value: Option<Bound>,
}

impl PropertyAnswer {
    /// Creates a property without an answer; `reason` says why it will have none.
    pub fn open(name: Option<String>, property: String, reason: Option<String>) -> Self {
        PropertyAnswer {
            name,
            property,
            holds: None,
            value: None,
            values: None,
            front: None,
            strong_cyclic: None,
            sizes: Sizes::default(),
            reason,
            line: None,
            column: None,
        }
    }

    /// Adds the place of the reason, a line and a column.
    #[must_use]
    pub fn at(mut self, place: Option<(usize, usize)>) -> Self {
        (self.line, self.column) = place.unzip();
        self
    }

    /// Takes the answer to the same property.
    pub fn take(&mut self, other: PropertyAnswer) {
        let (name, property) = (self.name.take(), std::mem::take(&mut self.property));
        *self = PropertyAnswer { name, property, ..other };
    }

    /// Adds the answer; so far, it may be incomplete.
    pub fn answer(&mut self, answer: &Answer) {
        self.holds = answer.holds;
        self.value = answer.value.clone().map(Some).or(answer.no_value.map(|_| None));
        self.reason = answer.no_value.map(str::to_owned);
    }
}

impl PropertyAnswer {
    /// Returns whether there is neither an answer nor a reason for none: a limit was hit.
    pub(super) fn is_open(&self) -> bool {
        self.holds.is_none() && self.value.is_none() && self.front.is_none() && self.reason.is_none()
    }

    /// Returns the cell of a sweep: a verdict, the bounds of a value, a front, or why there is none. It is empty
    /// if a limit or an error came first.
    pub(super) fn cell(&self) -> String {
        match (self.holds, &self.value, &self.front) {
            (Some(holds), ..) => holds.to_string(),
            (_, Some(Some(Bound { lower, upper, .. })), _) if lower == upper => lower.to_string(),
            (_, Some(Some(Bound { lower, upper, .. })), _) => format!("{lower}..{upper}"),
            (_, _, Some(_)) => self.text(),
            (_, Some(None), _) if self.reason.is_some() => "no value".to_owned(),
            _ if self.reason.is_some() => "not answered".to_owned(),
            _ => String::new(),
        }
    }

    /// Says why an answer or a value is missing; `None` if there are both.
    pub(super) fn note(&self) -> Option<String> {
        let reason = self.reason.as_ref()?;
        let text = self.property.split_whitespace().collect::<Vec<_>>().join(" ");
        Some(format!("no answer to {text}: {reason}"))
    }

    /// Formats the answer: the verdict, the value, or both.
    pub(super) fn text(&self) -> String {
        let holds = self.holds.map(|holds| if holds { "holds" } else { "does not hold" }.to_owned());
        let value = self.value.iter().flatten().map(shown);
        let front = self.front.as_ref().map(|points| {
            let numbers = |point: &Vec<f64>| point.iter().map(|x| rounded(*x)).collect::<Vec<_>>().join(", ");
            points.iter().map(|point| format!("({})", numbers(point))).collect::<Vec<_>>().join(" ")
        });
        let words: Vec<String> = holds.into_iter().chain(value).chain(front).collect();
        if words.is_empty() { "not decided".to_owned() } else { words.join(": ") }
    }
}

/// Formats the bounds of a value: one number if they are equal, otherwise an interval.
pub(super) fn shown(value: &Bound) -> String {
    match value.lower == value.upper {
        true => readable(value.lower),
        false => format!("[{}, {}]", readable(value.lower), readable(value.upper)),
    }
}

/// Maximum number of states in the text of a property that lists its values.
const MOST_LISTED: usize = 100;

/// Formats the states that a filter lists, with their values.
pub(super) fn listing(answer: &PropertyAnswer, style: Style) -> String {
    let Some(values) = &answer.values else { return String::new() };
    let mut grid = Grid::new(&["state", "value"]);
    for ListedState { state, holds, value } in values.iter().take(MOST_LISTED) {
        let value = value.as_ref().map(shown).or(holds.map(|holds| holds.to_string()));
        grid.row(vec![state.to_string(), value.unwrap_or_default()]);
    }
    let mut out = format!("\n{}\n{}", style.bold(&title(answer)), grid.text(style));
    if values.len() > MOST_LISTED {
        let _ = writeln!(out, "the first {MOST_LISTED} of {} states; `--json` has all", values.len());
    }
    out
}

/// Formats the name and the text of a property in one line.
fn title(answer: &PropertyAnswer) -> String {
    let text = answer.property.split_whitespace().collect::<Vec<_>>().join(" ");
    answer.name.as_ref().map_or_else(|| text.clone(), |name| format!("\"{name}\": {text}"))
}

/// Lists the answers: a table, and the reasons why others have none.
pub(super) fn list(answers: &[PropertyAnswer], style: Style) -> String {
    let mut out = String::new();
    if answers.iter().any(|p| p.reason.is_none()) {
        let _ = write!(out, "\n{}\n{}", style.bold("Properties"), table(answers, style));
    }
    answers.iter().for_each(|answer| out += &listing(answer, style));
    if let Some(exists) = answers.iter().find_map(|answer| answer.strong_cyclic) {
        let verdict = if exists { style.good("exists") } else { style.bad("does not exist") };
        let _ = writeln!(out, "\nA strong cyclic plan {verdict}.");
    }
    let others = answers.iter().filter_map(|p| Some((p, p.reason.as_deref()?)));
    for (index, (answer, reason)) in others.enumerate() {
        if index == 0 {
            let _ = write!(out, "\n{}\n", style.bold("Not answered"));
        }
        let place = answer.line.zip(answer.column);
        let place =
            place.map_or_else(String::new, |(line, column)| format!("line {line}, column {column}: "));
        let _ = writeln!(out, "  {}\n    {place}{reason}", title(answer));
    }
    out
}

fn table(answers: &[PropertyAnswer], style: Style) -> String {
    let answered = || answers.iter().filter(|p| p.reason.is_none());
    let columns = [Which::PmaxOne, Which::PmaxPositive, Which::PminOne, Which::PminPositive];
    let is_known = |which: &Which| answered().any(|p| p.sizes.get(*which).is_some());
    let columns: Vec<Which> = columns.into_iter().filter(is_known).collect();
    let names = columns.iter().map(|which| which.formula());
    let headings: Vec<&str> =
        ["property"].into_iter().chain(names).chain(["in the initial states"]).collect();
    let mut grid = Grid::new(&headings);
    for answer in answered() {
        let count =
            |which: &Which| answer.sizes.get(*which).as_ref().map_or_else(String::new, Number::grouped);
        let mut row = vec![title(answer)];
        row.extend(columns.iter().map(count));
        row.push(answer.text());
        grid.row(row);
    }
    grid.text(style)
}
