//! Conditions on row and column for sets of cells, short as text and small as diagrams.

use std::collections::BTreeMap;

use super::world::CellSet;

/// The maximum length of a line of a condition, in bytes.
const WIDTH: usize = 100;

/// A maximal range of numbers, including both ends.
type Range = (usize, usize);

/// Returns the set as a disjunction over bands of equal rows, or of equal columns if that is
/// shorter: `r=4`, `(r=1 | r=3) & (c<=2 | c=5)`. Returns one disjunct per line, and no line for the
/// empty set.
pub(super) fn condition(set: &CellSet, row: &str, col: &str) -> Vec<String> {
    let mut rest = Rest::new(set);
    let (full_rows, full_cols) = rest.take_full();
    let mut whole: Vec<String> = full_rows.iter().map(|&own| range(row, own, rest.rows)).collect();
    whole.extend(full_cols.iter().map(|&own| range(col, own, rest.cols)));
    let by_row = bands(&rest.lines(false), [(row, rest.rows), (col, rest.cols)]);
    let by_col = bands(&rest.lines(true), [(col, rest.cols), (row, rest.rows)]);
    let length = |lines: &[String]| lines.iter().map(|line| line.len() + 5).sum::<usize>();
    let parts = if length(&by_col) < length(&by_row) { by_col } else { by_row };
    let whole = (!whole.is_empty()).then(|| whole.join(" | "));
    whole.into_iter().chain(parts).collect()
}

/// The cells of a set that no disjunct covers yet.
struct Rest {
    rows: usize,
    cols: usize,
    members: Vec<bool>,
}

impl Rest {
    fn new(set: &CellSet) -> Self {
        let cols = set.cols.max(1);
        Rest { rows: set.members.len() / cols, cols, members: set.members.clone() }
    }

    fn line(&self, number: usize, transposed: bool) -> Vec<bool> {
        if transposed {
            (0..self.rows).map(|row| self.members[row * self.cols + number]).collect()
        } else {
            self.members[number * self.cols..(number + 1) * self.cols].to_vec()
        }
    }

    fn lines(&self, transposed: bool) -> Vec<Vec<bool>> {
        let count = if transposed { self.cols } else { self.rows };
        (0..count).map(|number| self.line(number, transposed)).collect()
    }

    /// Removes the rows that are completely in the set, then the columns whose cells outside of
    /// these rows are all in the set: `r=4 | c=0` describes both.
    fn take_full(&mut self) -> (Vec<Range>, Vec<Range>) {
        let full_rows: Vec<bool> = self.lines(false).iter().map(|line| !line.contains(&false)).collect();
        let some_left = full_rows.contains(&false);
        let is_full =
            |line: &Vec<bool>| some_left && line.iter().zip(&full_rows).all(|(&m, &full)| m || full);
        let full_cols: Vec<bool> = self.lines(true).iter().map(is_full).collect();
        for (at, member) in self.members.iter_mut().enumerate() {
            *member &= !full_rows[at / self.cols] && !full_cols[at % self.cols];
        }
        (maximal_ranges(&full_rows), maximal_ranges(&full_cols))
    }
}

/// Returns the maximal ranges of members.
fn maximal_ranges(line: &[bool]) -> Vec<Range> {
    let mut ranges: Vec<Range> = Vec::new();
    for (at, _) in line.iter().enumerate().filter(|(_, member)| **member) {
        match ranges.last_mut() {
            Some((_, end)) if *end + 1 == at => *end = at,
            _ => ranges.push((at, at)),
        }
    }
    ranges
}

/// Returns one condition for each kind of line that occurs, sorted by the ranges along the lines.
fn bands(lines: &[Vec<bool>], names: [(&str, usize); 2]) -> Vec<String> {
    let mut kinds: BTreeMap<Vec<Range>, Vec<bool>> = BTreeMap::new();
    for (number, line) in lines.iter().enumerate() {
        let across = maximal_ranges(line);
        if !across.is_empty() {
            kinds.entry(across).or_insert_with(|| vec![false; lines.len()])[number] = true;
        }
    }
    let mut bands: Vec<(Vec<Range>, Vec<Range>)> =
        kinds.into_iter().map(|(a, along)| (maximal_ranges(&along), a)).collect();
    bands.sort();
    let [(along, end), (across, across_end)] = names;
    let text = |(a, b): &(Vec<Range>, Vec<Range>)| {
        format!("{} & {}", ranges(along, a, end), ranges(across, b, across_end))
    };
    bands.iter().map(text).collect()
}

/// Returns `c<=2`, or `(c<=2 | c=5)` with brackets, as an adjacent `&` binds tighter.
fn ranges(name: &str, ranges: &[Range], count: usize) -> String {
    let parts: Vec<String> = ranges.iter().map(|&own| range(name, own, count)).collect();
    match &parts[..] {
        [one] => one.clone(),
        _ => format!("({})", parts.join(" | ")),
    }
}

fn range(name: &str, (first, last): Range, count: usize) -> String {
    match (first, last) {
        _ if first == last => format!("{name}={first}"),
        _ if last + 1 == count && first == 0 => "true".to_owned(),
        (0, _) => format!("{name}<={last}"),
        _ if last + 1 == count => format!("{name}>={first}"),
        _ => format!("{name}>={first} & {name}<={last}"),
    }
}

/// Breaks a long line after ` | ` and ` & `; continuation lines start with `indent`.
pub(super) fn wrap(line: &str, indent: &str) -> String {
    let mut text = String::new();
    let mut width = 0;
    for word in line.split_inclusive(' ') {
        let breaks = width + word.len() > WIDTH && (text.ends_with("| ") || text.ends_with("& "));
        if breaks {
            text.truncate(text.trim_end().len());
            text.push('\n');
            text.push_str(indent);
            width = indent.len();
        }
        text.push_str(word);
        width += word.len();
    }
    text
}
