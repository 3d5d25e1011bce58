//! The report of `check` as text.

use std::fmt::Write;

use super::check::{CheckReport, LevelsReport};
use super::report::show_state;
use super::text::{self, Grid};
use super::{Number, Style, ranks};
use crate::planning::Rank;

/// Renders the whole report.
pub(super) fn render(report: &CheckReport, style: Style) -> String {
    let mut settings =
        vec![("engine", report.engine), ("scope", report.scope.name()), ("safety", report.safety)];
    if let Some(empty) = report.empty {
        settings.push(("empty", empty));
    }
    if let Some(history) = report.history {
        settings.push(("history", history));
    }
    let mut out = text::title(&[&report.model.path, &report.preferences], &settings, style);
    if report.model.kind.is_some() {
        out.push_str(&text::model(&report.model, report.counts.as_ref(), style));
    }
    out.push_str(&objectives(report, style));
    out.push_str(&classes(report, style));
    out.push_str(&improvement(report, style));
    out.push_str(&levels(report, style));
    out.push_str(&initial(report, style));
    out.push_str(&text::incomplete(report.error.as_ref(), style));
    out.push_str(&times(report, style));
    out
}

fn objectives(report: &CheckReport, style: Style) -> String {
    if report.objectives.is_empty() {
        return String::new();
    }
    let target = if report.history.is_some() { "secured" } else { "target" };
    let mut grid = Grid::new(&["", target, "almost surely", "possibly"], style);
    for objective in &report.objectives {
        let numbers = [&objective.target, &objective.almost_sure, &objective.positive];
        let mut row = vec![objective.name.clone()];
        row.extend(numbers.map(Number::grouped));
        grid.row(row);
    }
    format!(
        "\n{}\n{}",
        style.bold(if report.history.is_some() {
            "Objectives, and the number of states from which paths satisfy them"
        } else {
            "Objectives, and the number of states that reach them"
        }),
        grid.text(style)
    )
}

fn classes(report: &CheckReport, style: Style) -> String {
    let Some(classes) = &report.classes else { return String::new() };
    let mut grid = Grid::new(&["", "states"], style);
    for class in classes {
        grid.row(vec![text::names(&class.most_preferred), class.states.grouped()]);
    }
    format!(
        "\n{}\n{}",
        style.bold("Classes: number of states by most preferred almost-sure objectives"),
        grid.text(style)
    )
}

fn improvement(report: &CheckReport, style: Style) -> String {
    let Some(improvement) = &report.improvement else { return String::new() };
    let numbers = [
        ("states", &improvement.states),
        ("transitions", &improvement.transitions),
        ("dropped", &improvement.dropped),
    ];
    format!("\n{}\n{}", style.bold("Improvement MDP"), text::aligned(&numbers))
}

/// Shows the SASI and SPI levels side by side, one line per number of improvements.
fn levels(report: &CheckReport, style: Style) -> String {
    if report.sasi.is_none() && report.spi.is_none() {
        return String::new();
    }
    let none = LevelsReport::default();
    let (sasi, spi) = (report.sasi.as_ref().unwrap_or(&none), report.spi.as_ref().unwrap_or(&none));
    let mut grid = Grid::new(&["improvements", "SASI, almost surely", "SPI, possibly"], style);
    for level in 0..sasi.levels.len().max(spi.levels.len()) {
        let cell = |levels: &LevelsReport| level_cell(levels, level);
        grid.row(vec![format!("{} or more", level + 1), cell(sasi), cell(spi)]);
    }
    let unbounded = |known: bool, levels: &LevelsReport| match &levels.unbounded {
        Some(n) => n.grouped(),
        None if known => "?".to_owned(),
        None => String::new(),
    };
    grid.row(vec![
        "any number".to_owned(),
        unbounded(report.sasi.is_some(), sasi),
        unbounded(report.spi.is_some(), spi),
    ]);
    format!(
        "\n{}\n{}",
        style.bold("Levels: number of states that can improve this many times"),
        grid.text(style)
    )
}

fn level_cell(levels: &LevelsReport, level: usize) -> String {
    match (levels.levels.get(level), &levels.unbounded) {
        (Some(n), _) => n.grouped(),
        (None, Some(fixpoint)) => fixpoint.grouped(),
        (None, None) => String::new(),
    }
}

fn initial(report: &CheckReport, style: Style) -> String {
    let mut out = String::new();
    for initial in &report.initial {
        let _ = write!(out, "\n{}\n", style.bold(&format!("Initial state {}", show_state(&initial.state))));
        let _ = writeln!(out, "  sure: {}", text::names(&initial.most_preferred));
        prospect(&mut out, "SASI", "guaranteed", initial.sasi_rank, initial.sasi_actions.as_ref(), style);
        prospect(&mut out, "SPI ", "possible", initial.spi_rank, initial.spi_actions.as_ref(), style);
    }
    if let Some(counts) = &report.counts {
        let listed = Number::from(report.initial.len() as u64);
        if !report.initial.is_empty() && counts.initial > listed {
            let _ = writeln!(out, "\n  … and {} more initial states", more(&counts.initial, &listed));
        }
    }
    out
}

fn more(all: &Number, listed: &Number) -> String {
    Number(&all.0 - &listed.0).grouped()
}

/// Writes one line: the improvements of a state, and the permitted actions.
fn prospect(
    out: &mut String,
    name: &str,
    how: &str,
    rank: Option<Rank>,
    actions: Option<&Vec<String>>,
    style: Style,
) {
    let Some(rank) = rank else { return };
    let verdict = ranks::ability(rank, how);
    let verdict = if rank == Rank::Finite(0) { style.dim(&verdict) } else { style.good(&verdict) };
    let _ = write!(out, "  {name}  {verdict}");
    match actions {
        Some(actions) if !actions.is_empty() => {
            let _ = writeln!(out, "; permitted: {}", style.bold(&actions.join(", ")));
        }
        _ => out.push('\n'),
    }
}

fn times(report: &CheckReport, style: Style) -> String {
    let time = &report.time;
    let phases = [
        ("parse", time.parse),
        ("build", time.build),
        ("outcomes", time.outcomes),
        ("improvement", time.improvement),
        ("SASI", time.sasi),
        ("SPI", time.spi),
    ];
    text::footer(time.total, &phases, report.memory, style)
}
