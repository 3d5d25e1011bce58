//! Sets of cells as conditions on row and column that are short to read and small as diagrams.

use std::collections::BTreeMap;

use super::world::CellSet;

/// The longest line of a condition.
const WIDTH: usize = 100;

/// A maximal range of numbers, both ends in it.
type Run = (usize, usize);

/// The set as a disjunction over bands of equal rows (or columns, where that is shorter), such as
/// `r=4`, `(r=1 | r=3) & (c<=2 | c=5)`. The text is empty for the empty set; the parts are one a line.
pub(super) fn condition(set: &CellSet, row: &str, col: &str) -> Vec<String> {
    let mut rest = Rest::new(set);
    let (full_rows, full_cols) = rest.take_full();
    let mut whole: Vec<String> = full_rows.iter().map(|&run| range(row, run, rest.rows)).collect();
    whole.extend(full_cols.iter().map(|&run| range(col, run, rest.cols)));
    let by_row = bands(&rest.lines(false), [(row, rest.rows), (col, rest.cols)]);
    let by_col = bands(&rest.lines(true), [(col, rest.cols), (row, rest.rows)]);
    let length = |lines: &[String]| lines.iter().map(|line| line.len() + 5).sum::<usize>();
    let parts = if length(&by_col) < length(&by_row) { by_col } else { by_row };
    let whole = (!whole.is_empty()).then(|| whole.join(" | "));
    whole.into_iter().chain(parts).collect()
}

/// A set while parts of it are taken out.
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

    /// Takes out the rows that are wholly in the set, then the columns that are so but for those rows:
    /// `r=4 | c=0` says them all.
    fn take_full(&mut self) -> (Vec<Run>, Vec<Run>) {
        let full_rows: Vec<bool> = self.lines(false).iter().map(|line| !line.contains(&false)).collect();
        let some_left = full_rows.contains(&false);
        let is_full =
            |line: &Vec<bool>| some_left && line.iter().zip(&full_rows).all(|(&m, &full)| m || full);
        let full_cols: Vec<bool> = self.lines(true).iter().map(is_full).collect();
        for (at, member) in self.members.iter_mut().enumerate() {
            *member &= !full_rows[at / self.cols] && !full_cols[at % self.cols];
        }
        (runs(&full_rows), runs(&full_cols))
    }
}

/// The maximal ranges of members.
fn runs(line: &[bool]) -> Vec<Run> {
    let mut runs: Vec<Run> = Vec::new();
    for (at, _) in line.iter().enumerate().filter(|(_, member)| **member) {
        match runs.last_mut() {
            Some((_, end)) if *end + 1 == at => *end = at,
            _ => runs.push((at, at)),
        }
    }
    runs
}

/// One condition for each kind of line that occurs, in the order of first occurrence.
fn bands(lines: &[Vec<bool>], names: [(&str, usize); 2]) -> Vec<String> {
    let mut kinds: BTreeMap<Vec<Run>, Vec<bool>> = BTreeMap::new();
    for (number, line) in lines.iter().enumerate() {
        let across = runs(line);
        if !across.is_empty() {
            kinds.entry(across).or_insert_with(|| vec![false; lines.len()])[number] = true;
        }
    }
    let mut bands: Vec<(Vec<Run>, Vec<Run>)> =
        kinds.into_iter().map(|(a, along)| (runs(&along), a)).collect();
    bands.sort();
    let [(along, end), (across, across_end)] = names;
    let text = |(a, b): &(Vec<Run>, Vec<Run>)| {
        format!("{} & {}", ranges(along, a, end), ranges(across, b, across_end))
    };
    bands.iter().map(text).collect()
}

/// `c<=2`, or `(c<=2 | c=5)`: in brackets where an `&` beside it would bind tighter.
fn ranges(name: &str, runs: &[Run], count: usize) -> String {
    let parts: Vec<String> = runs.iter().map(|&run| range(name, run, count)).collect();
    match &parts[..] {
        [one] => one.clone(),
        _ => format!("({})", parts.join(" | ")),
    }
}

fn range(name: &str, (first, last): Run, count: usize) -> String {
    match (first, last) {
        _ if first == last => format!("{name}={first}"),
        _ if last + 1 == count && first == 0 => "true".to_owned(),
        (0, _) => format!("{name}<={last}"),
        _ if last + 1 == count => format!("{name}>={first}"),
        _ => format!("{name}>={first} & {name}<={last}"),
    }
}

/// Breaks a long line after ` | ` and ` & `, each further piece behind `indent`.
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
