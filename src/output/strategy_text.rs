//! The report of `strategy` as text.

use std::fmt::Write;

use super::Style;
use super::reason::Words;
use super::report::show_state;
use super::strategy::{ActionReport, CourseLine, Shown, StateReport, StrategyReport, SuccessorReport};
use super::{ranks, text};
use crate::planning::{self, InducedModel, Kind};

/// Renders the whole report.
pub(super) fn render(report: &StrategyReport, style: Style) -> String {
    let kind = report.kind.to_string();
    let mut settings = vec![
        ("strategy", kind.as_str()),
        ("engine", report.engine),
        ("scope", report.scope.name()),
        ("safety", report.safety),
    ];
    if let Some(empty) = report.empty {
        settings.push(("empty", empty));
    }
    let mut out = text::title(&[&report.model.path, &report.preferences], &settings, style);
    if !report.states.is_empty() {
        out.push_str(&legend(report, style));
    }
    for state in &report.states {
        if let Shown::Text(text) = state {
            out.push_str(text);
        }
    }
    if let Some(asked) = &report.asked {
        let listed = super::Number::from(report.states.len() as u64);
        if *asked == super::Number::from(0) {
            out.push_str("\nNo state has this rank.\n");
        } else if *asked > listed {
            let _ =
                writeln!(out, "\n{} of {} states; a larger `--limit` lists more.", listed, asked.grouped());
        }
    }
    out.push_str(&text::incomplete(report.error.as_ref(), style));
    out.push_str(&times(report, style));
    out
}

/// Explains the terms of the report.
fn legend(report: &StrategyReport, style: Style) -> String {
    let lines = [
        "Sure: the objectives that some strategy achieves almost surely, without those",
        "to which another sure objective is preferred. A step improves if an objective",
        "that becomes sure is preferred to one that was sure before, and weakens in the",
        "opposite case. Rank: the number of",
    ];
    style.dim(&format!("\n{} {} improvements.\n", lines.join("\n"), ranks::how(report.kind)))
}

/// Renders a state.
pub(super) fn one(kind: Kind, state: &StateReport, style: Style) -> String {
    let mut out = format!("\n{}\n", style.bold(&format!("State {}", show_state(&state.state))));
    let _ = writeln!(out, "  Sure: {}", text::names(&state.most_preferred));
    let _ = writeln!(out, "  {}", ranks::both(state.sasi_rank, state.spi_rank));
    for action in &state.actions {
        let pick = state.progress_action.as_deref() == Some(action.name.as_str());
        out.push_str(&action_text(kind, action, pick, style));
    }
    if let Some(course) = &state.course {
        out.push_str(&course_text(course, state.longest_play, style));
    }
    out
}

fn action_text(kind: Kind, action: &ActionReport, pick: bool, style: Style) -> String {
    let verdict = match (action.permitted, pick) {
        (true, true) => style.good("permitted, progress action"),
        (true, false) => style.good("permitted"),
        (false, _) => style.dim("not permitted"),
    };
    let mut out = format!("\n  {}  {verdict}: {}\n", style.bold(&action.name), action.reason);
    let row = |s: &SuccessorReport| {
        vec![
            format!("{}", Probability(s.probability)),
            s.changed.clone(),
            format!("sure: {}", text::names(&s.most_preferred)),
            change(s),
            format!("{kind} rank {}", ranks::cell(s.rank)),
        ]
    };
    let rows: Vec<Vec<String>> = action.successors.iter().map(row).collect();
    for line in columns(&rows) {
        let _ = writeln!(out, "       {line}");
    }
    out
}

/// Describes a step, with its gains and losses.
fn change(s: &SuccessorReport) -> String {
    let mut text = s.change.to_owned();
    if s.change != "lateral" {
        if !s.gained.is_empty() {
            let _ = write!(text, ", {} gained", text::names(&s.gained));
        }
        if !s.lost.is_empty() {
            let _ = write!(text, ", {} lost", text::names(&s.lost));
        }
    }
    if s.dropped {
        text.push_str(" (dropped)");
    }
    text
}

/// A probability with as many digits as it needs, at most four.
pub(super) struct Probability(pub(super) f64);

impl std::fmt::Display for Probability {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.0 > 0.0 && self.0 < 5e-5 {
            return write!(f, "{:.1e}", self.0);
        }
        let text = format!("{:.4}", self.0);
        f.write_str(text.trim_end_matches('0').trim_end_matches('.'))
    }
}

/// Aligns cells in columns, with two blanks between them.
pub(super) fn columns(rows: &[Vec<String>]) -> Vec<String> {
    let count = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |c: usize| rows.iter().filter_map(|r| r.get(c)).map(|x| x.chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..count).map(width).collect();
    let line = |row: &Vec<String>| {
        let cells = row.iter().zip(&widths).map(|(cell, &w)| format!("{cell:w$}"));
        cells.collect::<Vec<_>>().join("  ").trim_end().to_owned()
    };
    rows.iter().map(line).collect()
}

/// Returns the paths under a strategy, one line per node.
pub(super) fn course(words: Words<'_>, course: &InducedModel) -> Vec<CourseLine> {
    let Some(start) = course.nodes.first() else { return Vec::new() };
    let line = |(index, node): (usize, &planning::induced_model::Node)| CourseLine {
        place: match index {
            0 => "start".to_owned(),
            _ => words.changed(&start.at.state, &node.at.state),
        },
        most_preferred: words.list(&node.at.most_preferred),
        ahead: ranks::cell(node.at.memory.level),
        then: then(words, node),
    };
    course.nodes.iter().enumerate().map(line).collect()
}

/// Formats the actions and successors as `W to 3, 4 (B gained) or 5 (C gained)`.
fn then(words: Words<'_>, node: &planning::induced_model::Node) -> String {
    let mut played = Vec::new();
    for (action, next) in node.at.actions.iter().zip(&node.next) {
        let mut goes = Vec::new();
        for (successor, to) in action.successors.iter().zip(next) {
            let Some(to) = to else { continue };
            let note = match (successor.improves, successor.dropped) {
                (true, _) => format!(" ({} gained)", words.list(&successor.gained)),
                (_, true) => format!(" ({} lost)", words.list(&successor.lost)),
                _ => String::new(),
            };
            goes.push(format!("{}{note}", to + 1));
        }
        if let Some(last) = goes.pop() {
            let to = if goes.is_empty() { last } else { format!("{} or {last}", goes.join(", ")) };
            played.push(format!("{} to {to}", action.name));
        }
    }
    match (played.is_empty(), node.at.pick) {
        (false, _) => played.join("; "),
        (true, None) => "end".to_owned(),
        (true, Some(_)) => "…".to_owned(),
    }
}

fn course_text(course: &[CourseLine], longest: Option<usize>, style: Style) -> String {
    let title = "Paths under the progress strategy";
    let mut out = format!("\n  {}\n", style.bold(title));
    let mut rows = vec![["", "state", "sure", "level", "next"].map(str::to_owned).to_vec()];
    for (index, line) in course.iter().enumerate() {
        rows.push(vec![
            (index + 1).to_string(),
            line.place.clone(),
            line.most_preferred.clone(),
            line.ahead.clone(),
            line.then.clone(),
        ]);
    }
    for (index, line) in columns(&rows).into_iter().enumerate() {
        let line = if index == 0 { style.dim(&line) } else { line };
        let _ = writeln!(out, "    {line}");
    }
    if let Some(steps) = longest {
        let _ = writeln!(out, "    Every such path ends after at most {}.", text::plural(steps, "step"));
    }
    out
}

fn times(report: &StrategyReport, style: Style) -> String {
    let time = &report.time;
    let phases =
        [("parse", time.parse), ("build", time.build), ("levels", time.levels), ("answer", time.answer)];
    text::footer(time.total, &phases, report.memory, style)
}
