//! The answers to the questions of `meliora reach`.

use std::fmt::Write;

use super::text::Grid;
use super::{Number, Style};
use meliora_base::decimal::{readable, rounded};
use meliora_engine::regions::Which;
use meliora_quantities::state_values::Bound;
use meliora_question::answers::{ListedState, PropertyAnswer};

/// Returns the cell of a sweep: a verdict, the bounds of a value, a front, or why there is none. It is empty
/// if a limit or an error came first.
pub(super) fn cell(answer: &PropertyAnswer) -> String {
    match (answer.holds, &answer.value, &answer.front) {
        (Some(holds), ..) => holds.to_string(),
        (_, Some(Some(Bound { lower, upper, .. })), _) if lower == upper => lower.to_string(),
        (_, Some(Some(Bound { lower, upper, .. })), _) => format!("{lower}..{upper}"),
        (_, _, Some(_)) => text(answer),
        (_, Some(None), _) if answer.reason.is_some() => "no value".to_owned(),
        _ if answer.reason.is_some() => "not answered".to_owned(),
        _ => String::new(),
    }
}

/// Says why an answer or a value is missing; `None` if there are both.
pub(super) fn note(answer: &PropertyAnswer) -> Option<String> {
    let reason = answer.reason.as_ref()?;
    let text = answer.property.split_whitespace().collect::<Vec<_>>().join(" ");
    Some(format!("no answer to {text}: {reason}"))
}

/// Formats the answer: the verdict, the value, or both.
pub(super) fn text(answer: &PropertyAnswer) -> String {
    let holds = answer.holds.map(|holds| if holds { "holds" } else { "does not hold" }.to_owned());
    let value = answer.value.iter().flatten().map(shown);
    let front = answer.front.as_ref().map(|points| {
        let numbers = |point: &Vec<f64>| point.iter().map(|x| rounded(*x)).collect::<Vec<_>>().join(", ");
        points.iter().map(|point| format!("({})", numbers(point))).collect::<Vec<_>>().join(" ")
    });
    let words: Vec<String> = holds.into_iter().chain(value).chain(front).collect();
    if words.is_empty() { "not decided".to_owned() } else { words.join(": ") }
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
        row.push(text(answer));
        grid.row(row);
    }
    grid.text(style)
}
