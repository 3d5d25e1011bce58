//! Comma-separated values.
//!
//! A cell is a number, or a text of one line: escapes replace the characters that terminals do not
//! display. A spreadsheet runs texts that begin with `=`, `+`, `-` or `@`, so these get a `'` before
//! them, as spreadsheets do for texts.

use std::borrow::Cow;

use super::escape;

/// Returns a text as a cell.
pub fn cell(text: &str) -> Cow<'_, str> {
    let text = escape::line(text);
    match is_run(&text) && !is_number(&text) {
        true => Cow::Owned(format!("'{text}")),
        false => text,
    }
}

/// Returns the text of a cell, as [`escape::line`] gives it.
pub fn text(cell: &str) -> &str {
    cell.strip_prefix('\'').filter(|text| is_run(text)).unwrap_or(cell)
}

/// Returns true for a text that a spreadsheet runs, with or without `'` before it.
fn is_run(text: &str) -> bool {
    text.trim_start_matches('\'').starts_with(['=', '+', '-', '@'])
}

/// Returns true for a decimal number, a fraction, or bounds such as `-1..0.5`.
fn is_number(text: &str) -> bool {
    let is_decimal = |text: &str| {
        let first = text.strip_prefix(['+', '-']).unwrap_or(text);
        first == "inf" || first.starts_with(|c: char| c.is_ascii_digit()) && text.parse::<f64>().is_ok()
    };
    let is_fraction = |text: &str| {
        let (numerator, denominator) = text.split_once('/').unwrap_or((text, text));
        is_decimal(numerator) && is_decimal(denominator)
    };
    let (lower, upper) = text.split_once("..").unwrap_or((text, text));
    is_fraction(lower) && is_fraction(upper)
}

/// Returns rows as lines, quoted where RFC 4180 requires it; lines end with a line feed.
pub fn lines<R: IntoIterator<Item: AsRef<str>>>(rows: impl IntoIterator<Item = R>) -> String {
    let mut lines = Lines::default();
    rows.into_iter().for_each(|row| lines.push(row));
    lines.text()
}

/// Returns the cells of a line, without the quotes of [`lines`].
pub fn cells(line: &str) -> Vec<String> {
    let (mut cells, mut cell, mut is_quoted) = (Vec::new(), String::new(), false);
    let mut characters = line.chars().peekable();
    while let Some(c) = characters.next() {
        match c {
            '"' if is_quoted && characters.next_if_eq(&'"').is_some() => cell.push('"'),
            '"' if is_quoted || cell.is_empty() => is_quoted = !is_quoted,
            ',' if !is_quoted => cells.push(std::mem::take(&mut cell)),
            other => cell.push(other),
        }
    }
    cells.push(cell);
    cells
}

/// Lines that are written row by row.
#[derive(Default)]
pub struct Lines(String);

impl Lines {
    /// Adds a row of texts, each of which becomes a [`cell`].
    pub fn push<R: IntoIterator<Item: AsRef<str>>>(&mut self, row: R) {
        let start = self.0.len();
        for (at, text) in row.into_iter().enumerate() {
            self.0 += if at == 0 { "" } else { "," };
            let cell = cell(text.as_ref());
            match cell.contains(['"', ',']) {
                true => self.0 += &format!("\"{}\"", cell.replace('"', "\"\"")),
                false => self.0 += &cell,
            }
        }
        // Readers skip an empty line.
        self.0 += if self.0.len() == start { "\"\"\n" } else { "\n" };
    }

    /// Returns all lines.
    pub fn text(self) -> String {
        self.0
    }
}

#[cfg(test)]
mod tests {
    use super::{cell, cells, lines, text};

    #[test]
    fn cells_are_quoted_where_needed_and_rows_may_differ_in_length() {
        let rows = [vec!["a", "b,c", "say \"d\""], vec!["two\nlines", ""]];
        assert_eq!(lines(rows.clone()), "a,\"b,c\",\"say \"\"d\"\"\"\ntwo\\nlines,\n");
        assert_eq!(lines([[""]]), "\"\"\n", "an empty line would be no row");
        let read: Vec<_> = lines(rows).lines().map(cells).collect();
        assert_eq!(read, [vec!["a", "b,c", "say \"d\""], vec!["two\\nlines", ""]]);
        assert_eq!(cells("\"\""), [""]);
        assert_eq!(cells("a \"b\",,"), ["a \"b\"", "", ""], "a quote inside of a cell is a character");
    }

    #[test]
    fn a_spreadsheet_runs_no_text_and_numbers_stay_numbers() {
        for number in ["-1", "+1", "-0.5", "-1e-7", "-1/3", "-1..0.5", "-inf", "-1/3..-1/4", "1"] {
            assert_eq!(cell(number), number);
        }
        for run in ["=cmd|' /C calc'!A0", "-go", "+1+2", "@SUM(A1)", "-", "-1..cmd", "-1/3..x", "-1..2..3"] {
            assert_eq!(cell(run), format!("'{run}"));
            assert_eq!(text(&cell(run)), run);
            assert_eq!(text(&cell(&format!("'{run}"))), format!("'{run}"));
        }
        assert_eq!(cell("\t=1"), "\\t=1");
        assert_eq!(text(&cell("'a")), "'a");
    }
}
