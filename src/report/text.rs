//! Pieces of text that several reports share.

use std::fmt::{self, Write};

use super::Style;
use meliora_engine::Count;
pub(super) use meliora_question::number::grouped;

/// A table with a heading line; the first column is text, the others are numbers.
pub(super) struct Grid {
    rows: Vec<Vec<String>>,
}

impl Grid {
    /// Creates a table with these headings.
    pub(super) fn new(headings: &[&str]) -> Self {
        Grid { rows: vec![headings.iter().map(|&heading| heading.to_owned()).collect()] }
    }

    /// Adds a line.
    pub(super) fn row(&mut self, cells: Vec<String>) {
        self.rows.push(cells);
    }

    /// Renders a heading and the lines below it.
    pub(super) fn titled(self, heading: &str, style: Style) -> String {
        format!("\n{}\n{}", style.bold(heading), self.text(style))
    }

    /// Renders the lines, indented, with a dimmed heading. If they are too long for the terminal, the texts
    /// of the first column go on in further lines.
    pub(super) fn text(self, style: Style) -> String {
        let count = self.rows[0].len();
        let width =
            |column: usize| self.rows.iter().filter_map(|row| row.get(column)).map(|text| length(text)).max();
        let mut widths: Vec<usize> = (0..count).map(|column| width(column).unwrap_or(0)).collect();
        let others: usize = widths[1..].iter().map(|width| 2 + width).sum();
        let room = style.width.map_or(usize::MAX, |width| usize::from(width).saturating_sub(2 + others));
        widths[0] = widths[0].min(room.max(LEAST_TEXT));
        let mut out = String::new();
        for (index, row) in self.rows.iter().enumerate() {
            let mut first = folded(row.first().map_or("", String::as_str), widths[0]).into_iter();
            let text = first.next().unwrap_or_default();
            let numbers = row.iter().zip(&widths).skip(1).map(|(cell, &width)| format!("  {cell:>width$}"));
            let line = format!("{text:<width$}{}", numbers.collect::<String>(), width = widths[0]);
            for line in [line].into_iter().chain(first) {
                let line = line.trim_end();
                let line = if index == 0 { style.dim(line) } else { line.to_owned() };
                let _ = writeln!(out, "  {line}");
            }
        }
        out
    }
}

/// The minimum width of a column of texts.
const LEAST_TEXT: usize = 12;

fn length(text: &str) -> usize {
    text.chars().count()
}

/// Breaks a text between words into lines of at most `width` characters; a longer word has a line of its own.
fn folded(text: &str, width: usize) -> Vec<String> {
    let words: Vec<String> = text.split(' ').map(str::to_owned).collect();
    wrapped(&words, "", width).lines().map(str::to_owned).collect()
}

/// Renders a heading with a state. A line that is too long for the terminal is broken after commas,
/// and continues two columns further in.
pub(super) fn state_heading(heading: &str, state: &impl fmt::Display, style: Style) -> String {
    let text = state.to_string();
    let width = style.width.map_or(usize::MAX, usize::from);
    let (mut lines, mut line, mut columns) =
        (String::new(), format!("{heading} "), heading.chars().count() + 1);
    let mut is_first = true;
    for part in text.split_inclusive(',') {
        let more = part.chars().count();
        if columns + more > width && !is_first {
            let _ = writeln!(lines, "{}", style.bold(&line));
            (line, columns) = ("  ".to_owned(), 2);
        }
        line += part;
        columns += more;
        is_first = false;
    }
    lines + &style.bold(&line) + "\n"
}

/// Renders names and numbers, the numbers aligned on the right.
pub(super) fn aligned(numbers: &[(&str, &Count)]) -> String {
    let texts: Vec<String> = numbers.iter().map(|(_, n)| grouped(n)).collect();
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
    format!("{} {noun}{s}", grouped(count))
}

/// Formats a set of names as `A, B`, or `nothing`.
pub(super) fn names(names: &[String]) -> String {
    match names {
        [] => "nothing".to_owned(),
        [one] => one.clone(),
        many => many.join(", "),
    }
}

/// Formats most preferred objectives: `A or B`, because each of them is sure, but not all together;
/// `nothing` if there are none.
pub(super) fn either(names: &[String]) -> String {
    match names {
        [] => "nothing".to_owned(),
        [one] => one.clone(),
        [names @ .., last] => format!("{} or {last}", names.join(", ")),
    }
}

/// Maximum number of alternatives that are named.
const MOST_GOALS: usize = 5;

/// Returns what an improvement starts from or leads to: `A`, `A or B`; only a number if they are many.
pub(super) fn goal(names: &[String]) -> String {
    if names.len() > MOST_GOALS {
        return format!("one of {} objectives", names.len());
    }
    either(names)
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

/// A probability with as many digits as it needs, at most four.
pub(super) struct Probability(pub(super) f64);

impl fmt::Display for Probability {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
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

/// Renders cells in indented columns below a dimmed heading.
pub(super) fn listed(rows: &[Vec<String>], style: Style) -> String {
    let mut out = String::new();
    for (index, line) in columns(rows).into_iter().enumerate() {
        let line = if index == 0 { style.dim(&line) } else { line };
        let _ = writeln!(out, "    {line}");
    }
    out
}

/// Joins words with spaces, in indented lines of at most `width` characters.
pub(super) fn wrapped(words: &[String], indent: &str, width: usize) -> String {
    let (mut out, mut line) = (String::new(), String::new());
    for word in words {
        if !line.is_empty() && line.chars().count() + 1 + word.chars().count() > width {
            let _ = writeln!(out, "{indent}{line}");
            line.clear();
        }
        if !line.is_empty() {
            line.push(' ');
        }
        line.push_str(word);
    }
    if !line.is_empty() {
        let _ = writeln!(out, "{indent}{line}");
    }
    out
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
    fn states_are_broken_after_commas_at_the_width() {
        let state = "place=3,wind=3,battery=3,carries=3";
        let at = |width| state_heading("State", &state, Style { color: false, width });
        assert_eq!(at(None), "State place=3,wind=3,battery=3,carries=3\n");
        assert_eq!(at(Some(24)), "State place=3,wind=3,\n  battery=3,carries=3\n");
        assert_eq!(at(Some(5)), "State place=3,\n  wind=3,\n  battery=3,\n  carries=3\n");
    }

    #[test]
    fn bytes_use_the_largest_unit() {
        for (b, text) in [(12, "12 B"), (1536, "1.5 KiB"), (3 << 30, "3.0 GiB")] {
            assert_eq!(bytes(b), text);
        }
    }
}
