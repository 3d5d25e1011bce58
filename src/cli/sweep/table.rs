//! The table of a sweep: the columns that fit the terminal, with headings of two lines.

use meliora::sweep::Columns;
use meliora_base::decimal::rounded;
use meliora_report::columns::{Heading, Place};

/// The width of the table if standard output is not a terminal.
const WIDTH: usize = 100;

/// Maximum number of characters of a title in the heading; longer ones are listed above the table.
const TITLE: usize = 24;

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
    place: Place,
    is_answer: bool,
    /// The two lines of the heading.
    heading: [String; 2],
    width: usize,
}

impl Column {
    fn new(position: usize, of: &Heading, heading: [&str; 2], is_answer: bool) -> Self {
        let words = heading.iter().map(|word| word.chars().count());
        let width = words.fold(of.width, usize::max);
        Column { position, place: of.place, is_answer, heading: heading.map(str::to_owned), width }
    }
}

impl Table {
    /// Selects columns of a row for a terminal of this width.
    pub(crate) fn new(job: &Columns, constants: usize, width: Option<u16>) -> Self {
        let constants = constants.max("constants".len());
        let room = width.map_or(WIDTH, usize::from);
        let (mut columns, mut titles) = (Vec::new(), Vec::new());
        for (position, heading) in job.headings.iter().enumerate() {
            let name = heading.name.as_str();
            if job.answers.contains(&position) {
                if name.chars().count() > TITLE {
                    let number = (position - job.answers.start + 1).to_string();
                    titles.push(format!("property {number}: {name}"));
                    columns.push(Column::new(position, heading, ["property", &number], true));
                } else {
                    columns.push(Column::new(position, heading, ["", name], true));
                }
            } else if heading.place != Place::File && !job.does_without(heading) {
                let (first, second) = name.split_once('_').unwrap_or(("", name));
                columns.push(Column::new(position, heading, [first, second], false));
            }
        }
        while constants + columns.iter().map(|column| column.width + 2).sum::<usize>() > room
            && let Some(least) = least(&columns)
        {
            columns.remove(least);
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
    pub(crate) fn line(&self, constants: &str, cells: &[String]) -> String {
        let show = |column: &Column| {
            let cell = &cells[column.position];
            if column.is_answer { answered(cell) } else { brief(cell) }
        };
        let cells: Vec<String> = self.columns.iter().map(show).collect();
        self.join(constants, cells.iter().map(String::as_str))
    }

    fn join<'c>(&self, first: &str, cells: impl Iterator<Item = &'c str>) -> String {
        let mut line = format!("{first:width$}", width = self.constants);
        for (cell, column) in cells.zip(&self.columns) {
            line += &format!("  {cell:>width$}", width = column.width);
        }
        line
    }
}

/// Returns the position of the column that is left out first; `None` if all are always shown.
fn least(columns: &[Column]) -> Option<usize> {
    let importance = |column: &Column| match column.place {
        Place::Room(importance) => Some(importance),
        _ => None,
    };
    let ranked = columns.iter().enumerate().filter_map(|(at, column)| Some((importance(column)?, at)));
    ranked.min().map(|(_, at)| at)
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
    use meliora::sweep::Ended;
    use meliora_question::answers::OneQuestion;
    use meliora_report::columns::Row;
    use meliora_report::{CheckReport, CompareReport, Header, ReachReport};

    use super::*;

    #[test]
    fn the_table_fits_a_terminal_of_80_columns_and_shows_more_in_a_wider_one() {
        let header = || Header::of_model("m");
        let mut reach = ReachReport::new(header());
        reach.one = Some(OneQuestion::default());
        for job in [
            Columns::new("check", &CheckReport::new(header()), &[]),
            Columns::new("reach", &reach, &[]),
            Columns::new("compare", &CompareReport::new(header()), &[]),
        ] {
            let line = |width| Table::new(&job, 5, Some(width)).heading()[1].clone();
            assert!(line(80).len() <= 80, "{}: {}", job.command, line(80));
            assert!(line(80).len() < line(200).len(), "{}: {}", job.command, line(200));
        }
    }

    #[test]
    fn long_properties_are_listed_above_and_answers_are_short() {
        let long = "Pmax=? [ F \"the end of all\" ]".to_owned();
        let reach = ReachReport::new(Header::of_model("m"));
        let job = Columns::new("reach", &reach, &["sure".to_owned(), long.clone()]);
        let answers = ["true", "0.333333331..0.333333332"].map(str::to_owned).to_vec();
        let cells = job.cells(&Row { answers, ..Row::default() }, Ended::Done);
        let table = Table::new(&job, 5, Some(100));
        let heading = table.heading();
        assert_eq!(heading[0], format!("property 2: {long}"));
        assert!(heading[1].contains("property") && heading[2].contains("sure"), "{heading:?}");
        let line = table.line("N=1", &cells);
        assert!(line.contains("true") && line.contains("  0.333333  "), "{line}");
    }

    #[test]
    fn bounds_that_differ_in_six_digits_are_both_shown() {
        assert_eq!(answered("0.25..0.5"), "0.25..0.5");
        assert_eq!(answered("1..inf"), "1..inf");
        assert_eq!(answered("not answered"), "not answered");
    }
}
