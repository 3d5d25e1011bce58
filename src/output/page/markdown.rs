//! The report as Markdown: for issues, wikis and terminals.

use std::fmt::Write;

use super::super::check::{CheckReport, LevelsReport};
use super::super::report::show_state;
use super::super::{ranks, text};
use super::map::view_text;
use super::{Content, Number, words};
use crate::escape;
use crate::model::hasse::Hasse;
use crate::projections::Projections;

/// Maximum number of columns of a map; wider ones fit no screen.
const WIDEST: usize = 64;

/// Renders the whole report.
pub(super) fn render(content: &Content<'_>) -> String {
    let check = content.check;
    let mut out = format!("# {} with {}\n\n", plain(&check.model.path), plain(&check.preferences));
    let empty = check.empty.unwrap_or_default();
    let _ = writeln!(out, "scope {}, safety {}, empty {empty}\n", check.scope.name(), check.safety);
    for initial in &check.initial {
        let _ = writeln!(out, "**{}**", words::verdict(initial));
        let _ = writeln!(out, "At `{}`, {}.", show_state(&initial.state), words::sure(initial));
        for (name, actions) in [("SASI", &initial.sasi_actions), ("SPI", &initial.spi_actions)] {
            if let Some(begin) = words::begin(actions.as_ref()) {
                let _ = writeln!(out, "{name} permits {begin}.");
            }
        }
        out.push('\n');
    }
    if let Some(projections) = content.projections {
        out.push_str(&map(projections));
    }
    out.push_str(&levels(check));
    out.push_str(&objectives(check));
    out.push_str(&classes(check));
    out.push_str(&order(content));
    out
}

/// Escapes a text, so that Markdown shows it as it is.
fn plain(text: &str) -> String {
    let mut out = String::new();
    for c in escape::line(text).chars() {
        if "\\`*_[]<>&#|~$".contains(c) {
            out.push('\\');
        }
        out.push(c);
    }
    out
}

/// Renders a table. The first row is the heading; the first column is text, the others are numbers.
fn table(rows: &[Vec<String>]) -> String {
    let mut out = String::new();
    for (index, row) in rows.iter().enumerate() {
        let cells: Vec<String> = row.iter().map(|cell| cell.replace('|', "\\|")).collect();
        let _ = writeln!(out, "| {} |", cells.join(" | "));
        if index == 0 {
            let _ = writeln!(out, "| --- |{}", " ---: |".repeat(row.len() - 1));
        }
    }
    out.push('\n');
    out
}

fn heading(cells: &[&str]) -> Vec<Vec<String>> {
    vec![cells.iter().map(|&cell| cell.to_owned()).collect()]
}

/// Renders a map of the SASI ranks.
fn map(projections: &Projections) -> String {
    let (rows, columns) = (projections.rows(), projections.columns());
    if columns.len() > WIDEST {
        return String::new();
    }
    let opening = projections.opening();
    let view = view_text(projections, &opening);
    let view = if view.is_empty() { view } else { format!(" for {view}") };
    let mut out = format!("## Guaranteed improvements (SASI ranks){view}\n\n```text\n");
    let mut others = false;
    for row in rows {
        let mark = |&column: &i64| match projections.found(&opening, row, column) {
            Some((cell, exact)) => {
                others |= !exact;
                ranks::mark(Some(cell.sasi))
            }
            None => "·".to_owned(),
        };
        let line: Vec<String> = columns.iter().map(mark).collect();
        let label = projections.plane.row.map_or_else(String::new, |_| format!("{row:>4}  "));
        let _ = writeln!(out, "{label}{}", line.join(" "));
    }
    out.push_str("```\n\n");
    if others {
        out.push_str("Cells that are unreachable with these values show the best over all others.\n\n");
    }
    out
}

fn levels(check: &CheckReport) -> String {
    let none = LevelsReport::default();
    let (sasi, spi) = (check.sasi.as_ref().unwrap_or(&none), check.spi.as_ref().unwrap_or(&none));
    let cell = |levels: &LevelsReport, k: usize| {
        let states = levels.levels.get(k).or(levels.unbounded.as_ref());
        states.map_or_else(|| "?".to_owned(), Number::grouped)
    };
    let mut rows = heading(&["improvements", "guaranteed (SASI)", "possible (SPI)"]);
    for k in 0..sasi.levels.len().max(spi.levels.len()) {
        rows.push(vec![format!("{} or more", k + 1), cell(sasi, k), cell(spi, k)]);
    }
    rows.push(vec!["any number".to_owned(), cell(sasi, usize::MAX), cell(spi, usize::MAX)]);
    format!("## Levels\n\n{}", table(&rows))
}

fn objectives(check: &CheckReport) -> String {
    let mut rows = heading(&["objective", "target", "almost surely", "possibly"]);
    for o in &check.objectives {
        rows.push(vec![o.name.clone(), o.target.grouped(), o.almost_sure.grouped(), o.positive.grouped()]);
    }
    format!("## Objectives\n\n{}", table(&rows))
}

fn classes(check: &CheckReport) -> String {
    let mut rows = heading(&["sure", "states"]);
    for class in check.classes.iter().flatten() {
        rows.push(vec![text::names(&class.most_preferred), class.states.grouped()]);
    }
    format!("## Classes\n\n{}", table(&rows))
}

/// Renders the direct preferences between groups.
fn order(content: &Content<'_>) -> String {
    let hasse = Hasse::new(&content.preferences.order);
    let name = |group: usize| {
        let names = hasse.groups[group].iter().filter_map(|&i| content.preferences.objectives.get(i));
        names.map(|o| o.name.as_str()).collect::<Vec<_>>().join(" ~ ")
    };
    let mut out = String::from("## Preferences\n\n");
    for group in 0..hasse.groups.len() {
        let below = hasse.covers.iter().filter(|&&(high, _)| high == group);
        let below: Vec<String> = below.map(|&(_, low)| name(low)).collect();
        if !below.is_empty() {
            let _ = writeln!(out, "- {} > {}", name(group), below.join(", "));
        }
    }
    let alone = (0..hasse.groups.len()).filter(|g| hasse.covers.iter().all(|(h, l)| h != g && l != g));
    for group in alone {
        let _ = writeln!(out, "- {} is incomparable to all others", name(group));
    }
    let _ = writeln!(out, "- empty = {}", content.preferences.empty);
    out
}
