//! The table of a sweep: the columns that fit the terminal, with headings of two lines.

use meliora_base::decimal::rounded;

use super::row::{REGIONS, Row};

/// The width of the table if standard output is not a terminal.
const WIDTH: usize = 100;

/// Maximum number of characters of a title in the heading; longer ones are listed above the table.
const TITLE: usize = 24;

/// The columns that are left out until the others fit, the least important first.
const OPTIONAL: [&str; 12] = [
    "choices",
    "peak_rss_bytes",
    "peak_nodes",
    "transitions",
    "sasi_2",
    "spi_2",
    "sasi_unbounded",
    "spi_unbounded",
    "sasi_1",
    "spi_1",
    "target",
    "seconds_explicit",
];

/// The columns of a table.
pub(crate) struct Table {
    /// The width of the constants.
    constants: usize,
    columns: Vec<Column>,
    /// The properties whose columns have numbers instead of long titles.
    titles: Vec<String>,
}

struct Column {
    /// The position in the row.
    position: usize,
    /// The name; `None` for the answer to a property, which has no fixed one.
    name: Option<String>,
    /// The two lines of the heading.
    heading: [String; 2],
    width: usize,
}

impl Column {
    fn new(position: usize, name: Option<&str>, heading: [&str; 2]) -> Self {
        let words = heading.iter().map(|word| word.chars().count());
        let width = words.fold(name.map_or(USUAL, usual).len(), usize::max);
        Column { position, name: name.map(str::to_owned), heading: heading.map(str::to_owned), width }
    }
}

impl Table {
    /// Selects columns of a row for a terminal of this width.
    pub(crate) fn new(row: &Row, constants: usize, width: Option<u16>) -> Self {
        let constants = constants.max("constants".len());
        let room = width.map_or(WIDTH, usize::from);
        let (mut columns, mut titles) = (Vec::new(), Vec::new());
        let answers = row.answers();
        for (position, name) in row.columns().enumerate() {
            if !answers.contains(&position) {
                // Levels above the second have too many columns for any terminal.
                let is_shown = !is_level(name) || OPTIONAL.contains(&name);
                if is_shown && (answers.is_empty() || !REGIONS.contains(&name)) {
                    let (first, second) = name.split_once('_').unwrap_or(("", name));
                    columns.push(Column::new(position, Some(name), [first, second]));
                }
            } else if name.chars().count() > TITLE {
                let number = (position - answers.start + 1).to_string();
                titles.push(format!("property {number}: {name}"));
                columns.push(Column::new(position, None, ["property", &number]));
            } else {
                columns.push(Column::new(position, None, ["", name]));
            }
        }
        for name in OPTIONAL {
            let used: usize = columns.iter().map(|column| column.width + 2).sum();
            if constants + used > room || OPTIONAL[..2].contains(&name) {
                columns.retain(|column| column.name.as_deref() != Some(name));
            }
        }
        Table { constants, columns, titles }
    }

    /// Returns the lines of the heading: the long titles of properties, and two lines of words.
    pub(crate) fn heading(&self) -> Vec<String> {
        let line = |number: usize, first: &str| {
            let cells = self.columns.iter().map(|column| column.heading[number].as_str());
            self.join(first, cells)
        };
        self.titles.iter().cloned().chain([line(0, ""), line(1, "constants")]).collect()
    }

    /// Returns the line of a row.
    pub(crate) fn line(&self, constants: &str, row: &Row) -> String {
        let answers = row.answers();
        let show = |(position, cell)| if answers.contains(&position) { answered(cell) } else { brief(cell) };
        let cells: Vec<String> = row.cells().enumerate().map(show).collect();
        self.join(constants, self.columns.iter().map(|column| cells[column.position].as_str()))
    }

    fn join<'c>(&self, first: &str, cells: impl Iterator<Item = &'c str>) -> String {
        let mut line = format!("{first:width$}", width = self.constants);
        for (cell, column) in cells.zip(&self.columns) {
            line += &format!("  {cell:>width$}", width = column.width);
        }
        line
    }
}

/// A usual value; a column has at least its width.
const USUAL: &str = "1000000";

/// Returns a usual value of a column.
fn usual(name: &str) -> &'static str {
    match name {
        "sasi_rank" | "spi_rank" => "unbounded",
        "prefer" => "symbolic",
        _ => USUAL,
    }
}

/// Returns whether a column is a level, such as `sasi_1`.
fn is_level(name: &str) -> bool {
    name.rsplit_once('_').is_some_and(|(_, k)| k.parse::<usize>().is_ok())
}

/// Formats seconds with three decimals.
fn brief(cell: &str) -> String {
    match cell.parse::<f64>() {
        Ok(x) if cell.contains('.') => format!("{x:.3}"),
        _ => cell.to_owned(),
    }
}

/// Formats an answer with six significant digits; bounds that agree then are one number.
fn answered(cell: &str) -> String {
    let short = |text: &str| text.parse().map_or_else(|_| text.to_owned(), rounded);
    match cell.split_once("..") {
        None => short(cell),
        Some((lower, upper)) if short(lower) == short(upper) => short(lower),
        Some((lower, upper)) => format!("{}..{}", short(lower), short(upper)),
    }
}

#[cfg(test)]
mod tests {
    use serde_json::Value as Json;

    use super::super::row::{Ended, Job};
    use super::*;

    #[test]
    fn the_table_fits_a_terminal_of_80_columns_and_shows_more_in_a_wider_one() {
        let reach = Job::Reach { regions: true, properties: Vec::new() };
        for job in [Job::check(None), reach, Job::Compare] {
            let row = job.row(&Json::Null, Ended::Done);
            let line = |width| Table::new(&row, 5, Some(width)).heading()[1].clone();
            assert!(line(80).len() <= 80, "{job:?}: {}", line(80));
            assert!(line(80).len() < line(200).len(), "{job:?}: {}", line(200));
        }
    }
    #[test]
    fn long_properties_are_listed_above_and_answers_are_short() {
        let long = "Pmax=? [ F \"the end of all\" ]".to_owned();
        let job = Job::Reach { regions: false, properties: vec!["sure".to_owned(), long.clone()] };
        let report = serde_json::json!({"properties": [
            {"holds": true}, {"holds": null, "value": {"lower": 0.333_333_331, "upper": 0.333_333_332}}
        ]});
        let row = job.row(&report, Ended::Done);
        let table = Table::new(&row, 5, Some(100));
        let heading = table.heading();
        assert_eq!(heading[0], format!("property 2: {long}"));
        assert!(heading[1].contains("property") && heading[2].contains("sure"), "{heading:?}");
        let line = table.line("N=1", &row);
        assert!(line.contains("true") && line.contains("  0.333333  "), "{line}");
    }

    #[test]
    fn bounds_that_differ_in_six_digits_are_both_shown() {
        assert_eq!(answered("0.25..0.5"), "0.25..0.5");
        assert_eq!(answered("1..inf"), "1..inf");
        assert_eq!(answered("not answered"), "not answered");
    }
}
