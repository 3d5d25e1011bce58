//! Pieces of text that several reports share.

use std::fmt::Write;

use comfy_table::{CellAlignment, ContentArrangement, Row, Table, presets};

pub(super) use super::number::group;
use super::report::{Counts, Failure, MemoryUse, ModelSummary};
use super::{Number, Style};
use crate::escape;

/// A table with a heading line; the first column is text, the others are numbers.
pub(super) struct Grid {
    table: Table,
    columns: usize,
}

impl Grid {
    /// Creates a table with these headings.
    pub(super) fn new(headings: &[&str], style: Style) -> Self {
        let mut table = Table::new();
        table.load_style(presets::NOTHING).set_content_arrangement(ContentArrangement::Dynamic);
        if let Some(width) = style.width {
            table.set_width(width.saturating_sub(2));
        }
        table.set_header(Row::from(headings));
        Grid { table, columns: headings.len() }
    }

    /// Adds a line.
    pub(super) fn row(&mut self, cells: Vec<String>) {
        self.table.add_row(cells);
    }

    /// Renders the lines, indented, with a dimmed heading.
    pub(super) fn text(mut self, style: Style) -> String {
        for index in 0..self.columns {
            if let Some(column) = self.table.column_mut(index) {
                column.set_padding((0, 2));
                if index > 0 {
                    column.set_cell_alignment(CellAlignment::Right);
                }
            }
        }
        let mut text = String::new();
        for (index, line) in self.table.lines().enumerate() {
            let line = line.trim_end();
            let line = if index == 0 { style.dim(line) } else { line.to_owned() };
            let _ = writeln!(text, "  {line}");
        }
        text
    }
}

/// Renders the inputs, and the settings that decide the results.
pub(super) fn title(inputs: &[&str], settings: &[(&str, &str)], style: Style) -> String {
    let settings = settings.iter().map(|(name, value)| format!("{name} {value}")).collect::<Vec<_>>();
    let inputs = escape::line(&inputs.join(" with ")).into_owned();
    format!("{}\n{}\n", style.bold(&inputs), style.dim(&settings.join(" · ")))
}

/// Renders type, variables, constants and sizes of the model.
pub(super) fn model(model: &ModelSummary, counts: Option<&Counts>, style: Style) -> String {
    let mut text = format!("\n{}\n", style.bold("Model"));
    if let Some(kind) = model.kind {
        let _ = write!(text, "  {kind}, {} in {}", plural(model.variables.len(), "variable"), bits(model));
        if !model.constants.is_empty() {
            let constants = model.constants.iter().map(|(name, value)| format!("{name}={value}"));
            let _ = write!(text, ", {}", constants.collect::<Vec<_>>().join(", "));
        }
        text.push('\n');
    }
    if let Some(counts) = counts {
        let mut numbers = vec![
            ("states", &counts.states),
            ("choices", &counts.choices),
            ("transitions", &counts.transitions),
            ("deadlocks", &counts.deadlocks),
            ("initial states", &counts.initial),
        ];
        if let Some(states) = &counts.model_states {
            numbers.insert(1, ("without monitors", states));
        }
        text.push_str(&aligned(&numbers));
    }
    text
}

fn bits(model: &ModelSummary) -> String {
    plural(usize::try_from(model.bits()).unwrap_or(usize::MAX), "bit")
}

/// Renders names and numbers, the numbers aligned on the right.
pub(super) fn aligned(numbers: &[(&str, &Number)]) -> String {
    let texts: Vec<String> = numbers.iter().map(|(_, n)| n.grouped()).collect();
    let names = numbers.iter().map(|(name, _)| name.chars().count()).max().unwrap_or(0);
    let digits = texts.iter().map(String::len).max().unwrap_or(0);
    let mut text = String::new();
    for ((name, _), number) in numbers.iter().zip(texts) {
        let _ = writeln!(text, "  {name:names$}  {number:>digits$}");
    }
    text
}

/// Returns `1 variable`, `7 variables`.
pub(super) fn plural(count: usize, noun: &str) -> String {
    let s = if count == 1 { "" } else { "s" };
    format!("{} {noun}{s}", group(&count.to_string()))
}

/// Formats a set of names as `A, B`, or `nothing`.
pub(super) fn names(names: &[String]) -> String {
    match names {
        [] => "nothing".to_owned(),
        [one] => one.clone(),
        many => many.join(", "),
    }
}

/// Renders the last lines: seconds by phase, nodes and memory.
pub(super) fn footer(total: f64, phases: &[(&str, Option<f64>)], memory: MemoryUse, style: Style) -> String {
    let phases: Vec<String> =
        phases.iter().filter_map(|(name, time)| time.map(|t| format!("{name} {}", seconds(t)))).collect();
    let mut text = format!("{} in all", seconds(total));
    if !phases.is_empty() {
        let _ = write!(text, ": {}", phases.join(", "));
    }
    let mut used = Vec::new();
    if memory.peak_nodes > 0 {
        used.push(format!("{} nodes at most", group(&memory.peak_nodes.to_string())));
    }
    if memory.peak_rss_bytes > 0 {
        used.push(format!("{} of memory at most", bytes(memory.peak_rss_bytes)));
    }
    let mut text = format!("\n{}\n", style.dim(&text));
    if !used.is_empty() {
        let _ = writeln!(text, "{}", style.dim(&used.join(", ")));
    }
    text
}

/// Formats seconds with the digits that matter.
pub(super) fn seconds(seconds: f64) -> String {
    if seconds < 0.000_95 {
        format!("{:.0} µs", seconds * 1e6)
    } else if seconds < 0.95 {
        format!("{:.0} ms", seconds * 1e3)
    } else if seconds < 60.0 {
        format!("{seconds:.2} s")
    } else {
        format!("{} min {:02.0} s", (seconds / 60.0).floor(), (seconds % 60.0).floor())
    }
}

/// Formats bytes in the largest unit in which the number is at least one.
pub(super) fn bytes(bytes: u64) -> String {
    let mut value = bytes as f64;
    for unit in ["B", "KiB", "MiB", "GiB"] {
        if value < 1024.0 {
            return if unit == "B" { format!("{value} B") } else { format!("{value:.1} {unit}") };
        }
        value /= 1024.0;
    }
    format!("{value:.1} TiB")
}

/// Returns the note for work that ended early.
pub(super) fn incomplete(failure: Option<&Failure>, style: Style) -> String {
    match failure {
        Some(_) => {
            format!("\n{}\n", style.warn("Incomplete: these are the partial results when the work stopped."))
        }
        None => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seconds_have_as_many_digits_as_matter() {
        for (s, text) in [(0.000_012, "12 µs"), (0.25, "250 ms"), (1.5, "1.50 s"), (125.0, "2 min 05 s")] {
            assert_eq!(seconds(s), text);
        }
    }

    #[test]
    fn bytes_use_the_largest_unit() {
        for (b, text) in [(12, "12 B"), (1536, "1.5 KiB"), (3 << 30, "3.0 GiB")] {
            assert_eq!(bytes(b), text);
        }
    }
}
