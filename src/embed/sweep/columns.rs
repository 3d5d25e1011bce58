//! The columns of a sweep: those of the command's reports, and the answers to properties.

use std::ops::Range;

use meliora_question::answers::OneQuestion;
use meliora_report::columns::{Heading, Row};
use meliora_report::envelope::{Envelope, Findings};
use meliora_report::{CheckReport, Header, ReachReport};
use strum::IntoStaticStr;

/// The end of an instance, by its name in the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, IntoStaticStr)]
#[strum(serialize_all = "lowercase")]
pub enum Ended {
    /// Done; the answer, if there is one, is yes.
    Done,
    /// Done, and the answer is no.
    #[strum(serialize = "done")]
    No,
    /// A limit was hit; the row has the partial results.
    Limit,
    /// An error ended it.
    Error,
}

/// The columns of a sweep after the constants, and the command whose reports become rows.
pub struct Columns {
    /// The name of the command in JSON.
    pub command: &'static str,
    /// The headings of the columns.
    pub headings: Vec<Heading>,
    /// The positions of the answers to properties.
    pub answers: Range<usize>,
}

impl Columns {
    /// Returns the columns of a command: those of its report before there are results;
    /// `properties` are the titles of the properties.
    pub fn new<F: Findings>(command: &'static str, report: &Envelope<F>, properties: &[String]) -> Self {
        let [mut headings, after] = report.headings();
        let answers = headings.len()..headings.len() + properties.len();
        headings.extend(properties.iter().map(|title| Heading::answer(title)));
        headings.extend(after);
        headings.push(Heading::new("status"));
        Columns { command, headings, answers }
    }

    /// Returns the columns of `check` with levels up to `max_level`.
    pub fn of_check(max_level: Option<usize>) -> Self {
        let mut report = CheckReport::new(Header::of_model(""));
        report.levels = max_level.unwrap_or_default();
        Columns::new("check", &report, &[])
    }

    /// Returns the columns of `reach` with answers to properties. With `has_regions`, also the sizes of the regions of
    /// the only one.
    pub fn of_reach(titles: &[String], has_regions: bool) -> Self {
        let mut report = ReachReport::new(Header::of_model(""));
        report.one = has_regions.then(OneQuestion::default);
        Columns::new("reach", &report, titles)
    }

    /// Returns the names of the columns.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.headings.iter().map(|heading| heading.name.as_str())
    }

    /// Returns whether a table and a plot do without a column.
    pub fn does_without(&self, heading: &Heading) -> bool {
        heading.yields && !self.answers.is_empty()
    }

    /// Returns the cells of a row; unknown values are empty.
    pub fn cells(&self, row: &Row, ended: Ended) -> Vec<String> {
        let known = |heading: &Heading| row.cells.iter().find(|(name, _)| *name == heading.name);
        let cell = |(position, heading): (usize, &Heading)| {
            let found = match self.answers.contains(&position) {
                true => row.answers.get(position - self.answers.start),
                false => known(heading).map(|(_, cell)| cell),
            };
            found.cloned().unwrap_or_default()
        };
        let mut cells: Vec<String> = self.headings.iter().enumerate().map(cell).collect();
        if let Some(status) = cells.last_mut() {
            *status = <&str>::from(ended).to_owned();
        }
        cells
    }

    /// Returns how the instance of a row in a file ended, by the cells after the constants.
    pub fn ended(&self, cells: &[String]) -> Ended {
        let mut named = self.headings.iter().zip(cells);
        let is_no = named.any(|(heading, cell)| heading.is_verdict && cell == "false");
        let wrote = |ended: Ended| cells.last().is_some_and(|status| status == <&str>::from(ended));
        match is_no {
            _ if wrote(Ended::Limit) => Ended::Limit,
            _ if !wrote(Ended::Done) => Ended::Error,
            true => Ended::No,
            false => Ended::Done,
        }
    }

    /// Returns the positions of the columns that a plot shows.
    pub fn plotted(&self) -> Vec<usize> {
        let headings = self.headings.iter().enumerate();
        let shown = headings.filter(|(_, heading)| heading.is_plotted && !self.does_without(heading));
        shown.map(|(position, _)| position).collect()
    }
}

#[cfg(test)]
mod tests {
    use meliora_report::{CompareReport, Header, ReachReport};

    use super::*;

    /// A resumed sweep of which nothing was left ended with 0 although the answers in the file were no.
    #[test]
    fn a_row_of_a_file_says_how_its_instance_ended() {
        let reach = ReachReport::new(Header::of_model("m"));
        let columns = Columns::new("reach", &reach, &["p".to_owned(), "false".to_owned()]);
        let ended = |answer: &str, ended| {
            let answers = [answer, "true"].map(str::to_owned).to_vec();
            columns.ended(&columns.cells(&Row { answers, ..Row::default() }, ended))
        };
        for (answer, wrote, expected) in [
            ("true", Ended::Done, Ended::Done),
            ("false", Ended::No, Ended::No),
            ("false", Ended::Limit, Ended::Limit),
            ("true", Ended::Error, Ended::Error),
        ] {
            assert_eq!(ended(answer, wrote), expected, "{answer}");
        }
        let compare = Columns::new("compare", &CompareReport::new(Header::of_model("m")), &[]);
        let equal = |equal: &str| {
            let cells = vec![("equal".to_owned(), equal.to_owned())];
            compare.ended(&compare.cells(&Row { cells, ..Row::default() }, Ended::No))
        };
        assert_eq!((equal("false"), equal("true")), (Ended::No, Ended::Done));
    }
}
