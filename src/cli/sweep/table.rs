//! The table of a sweep: the columns that fit the terminal, with headings of two lines.

use super::row::Row;

/// The width of the table if standard output is not a terminal.
const WIDTH: usize = 100;

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
}

struct Column {
    /// The position in the row.
    position: usize,
    /// The two lines of the heading.
    heading: [String; 2],
    width: usize,
}

impl Table {
    /// Selects columns of a row for a terminal of this width.
    pub(crate) fn new(row: &Row, constants: usize, width: Option<u16>) -> Self {
        let is_level = |name: &str| name.rsplit_once('_').is_some_and(|(_, k)| k.parse::<usize>().is_ok());
        // Levels above the second have too many columns for any terminal.
        let shown = |name: &str| !is_level(name) || OPTIONAL.contains(&name);
        let mut names: Vec<(usize, &str)> =
            row.columns().enumerate().filter(|(_, name)| shown(name)).collect();
        let constants = constants.max("constants".len());
        let room = width.map_or(WIDTH, usize::from);
        let always = &OPTIONAL[..2];
        for name in OPTIONAL {
            let used: usize = names.iter().map(|(_, name)| width_of(name) + 2).sum();
            if constants + used > room || always.contains(&name) {
                names.retain(|(_, other)| *other != name);
            }
        }
        let column = |(position, name): (usize, &str)| {
            let (first, second) = name.split_once('_').unwrap_or(("", name));
            Column { position, heading: [first, second].map(str::to_owned), width: width_of(name) }
        };
        Table { constants, columns: names.into_iter().map(column).collect() }
    }

    /// Returns the two lines of the heading.
    pub(crate) fn heading(&self) -> [String; 2] {
        let line = |number: usize, first: &str| {
            let cells = self.columns.iter().map(|column| column.heading[number].as_str());
            self.join(first, cells)
        };
        [line(0, ""), line(1, "constants")]
    }

    /// Returns the line of a row.
    pub(crate) fn line(&self, constants: &str, row: &Row) -> String {
        let cells: Vec<String> = row.cells().map(brief).collect();
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

/// Returns the width of a column: of its heading or of usual values.
fn width_of(name: &str) -> usize {
    let usual = match name {
        "sasi_rank" | "spi_rank" => "unbounded",
        "prefer" => "symbolic",
        _ => "1000000",
    };
    name.split('_').map(str::len).fold(usual.len(), usize::max)
}

/// Formats seconds with three decimals.
fn brief(cell: &str) -> String {
    match cell.parse::<f64>() {
        Ok(x) if cell.contains('.') => format!("{x:.3}"),
        _ => cell.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use serde_json::Value as Json;

    use super::super::row::{Ended, Job};
    use super::*;

    #[test]
    fn the_table_fits_a_terminal_of_80_columns_and_shows_more_in_a_wider_one() {
        for job in [Job::check(None), Job::Reach, Job::Compare] {
            let row = job.row(&Json::Null, Ended::Done);
            let line = |width| Table::new(&row, 5, Some(width)).heading()[1].clone();
            assert!(line(80).len() <= 80, "{job:?}: {}", line(80));
            assert!(line(80).len() < line(200).len(), "{job:?}: {}", line(200));
        }
    }
}
