//! The report of a sweep: the reports of its instances, and the table with a row for each of them.
//!
//! A type of reports declares the columns of its own by [`Findings::columns`], each with its cell, its
//! place on a terminal and its use in a plot.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value as Json};

use super::envelope::{Envelope, Findings};
use super::report::Failure;
use super::{CheckReport, CompareReport, ReachReport};
use meliora_engine::Count;
use meliora_planning::result::ModelCounts;

/// The results of a sweep.
#[derive(Debug, Clone, Serialize, JsonSchema)]
#[schemars(rename = "sweep")]
pub struct SweepReport {
    /// The kind and version of the object.
    #[schemars(extend("const" = Self::SCHEMA))]
    pub schema: &'static str,
    /// The command that writes the report of an instance.
    #[schemars(extend("enum" = ["check", "reach", "compare"]))]
    pub command: &'static str,
    /// The values of each constant that varies, as a list.
    pub ranges: Map<String, Json>,
    /// The instances in their order.
    pub runs: Vec<Instance>,
}

/// An instance of a sweep.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Instance {
    /// The constants of the instance.
    pub constants: Map<String, Json>,
    /// The end of the run.
    #[schemars(extend("enum" = ["done", "limit", "error"]))]
    pub status: &'static str,
    /// The object that the command writes for the instance, an error among them.
    #[schemars(with = "Any")]
    pub result: Json,
}

/// The objects of instances.
#[derive(JsonSchema)]
#[serde(untagged)]
#[expect(dead_code, reason = "only its schema is used")]
enum Any {
    Check(Box<CheckReport>),
    Reach(Box<ReachReport>),
    Compare(Box<CompareReport>),
    Error(Box<Failure>),
}

impl SweepReport {
    const SCHEMA: &str = "meliora.sweep/1";

    /// Creates the report of a command with its instances.
    pub fn new(command: &'static str, ranges: Map<String, Json>, runs: Vec<Instance>) -> Self {
        SweepReport { schema: Self::SCHEMA, command, ranges, runs }
    }
}

/// The heading of a column of the table of a sweep.
#[derive(Debug, Clone)]
pub struct Heading {
    /// Its name.
    pub name: String,
    /// Its place on a terminal.
    pub place: Place,
    /// The width of a usual value, in characters.
    pub width: usize,
    /// True if a plot shows it.
    pub is_plotted: bool,
    /// True if the answer of the instance is no where the cell is `false`.
    pub is_verdict: bool,
    /// True if a table or plot with answers to properties does without it.
    pub yields: bool,
}

/// The place of a column on a terminal; files have all columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// Always shown.
    Always,
    /// Shown if there is room; smaller numbers are left out first.
    Room(u8),
    /// Never shown.
    File,
}

/// The width of a usual number in the table, in characters.
const NUMBER: usize = "1000000".len();

impl Heading {
    /// Creates the heading of numbers that are always shown.
    pub fn new(name: impl Into<String>) -> Self {
        let (place, name) = (Place::Always, name.into());
        Heading { name, place, width: NUMBER, is_plotted: false, is_verdict: false, yields: false }
    }

    /// Creates the heading of the answers to a property.
    pub fn answer(title: &str) -> Self {
        Heading { is_plotted: true, is_verdict: true, ..Heading::new(title) }
    }
}

/// A column of the table of a sweep.
pub struct Column<F: Findings> {
    heading: Heading,
    /// Returns the cell of a report; `None` if unknown.
    cell: Box<Cell<F>>,
}

type Cell<F> = dyn Fn(&Envelope<F>) -> Option<String>;

impl<F: Findings> Column<F> {
    /// Creates a column of numbers that is always shown.
    pub fn new(name: impl Into<String>, cell: impl Fn(&Envelope<F>) -> Option<String> + 'static) -> Self {
        Column { heading: Heading::new(name), cell: Box::new(cell) }
    }

    /// Changes the place on a terminal.
    #[must_use]
    pub fn at(self, place: Place) -> Self {
        Column { heading: Heading { place, ..self.heading }, ..self }
    }

    /// Shows the column in plots.
    #[must_use]
    pub fn plotted(self) -> Self {
        Column { heading: Heading { is_plotted: true, ..self.heading }, ..self }
    }

    /// Says that `false` in a cell means that the answer of the instance is no.
    #[must_use]
    pub fn verdict(self) -> Self {
        Column { heading: Heading { is_verdict: true, ..self.heading }, ..self }
    }

    /// Leaves the column out of a table or plot with answers to properties.
    #[must_use]
    pub fn yielding(self) -> Self {
        Column { heading: Heading { yields: true, ..self.heading }, ..self }
    }

    /// Makes room for a usual value that is longer than a number.
    #[must_use]
    pub fn wide(self, usual: &str) -> Self {
        Column { heading: Heading { width: usual.len().max(NUMBER), ..self.heading }, ..self }
    }
}

/// The row of an instance, which its process hands over together with the report.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Row {
    /// The cells with the names of their columns, without the answers; unknown values are absent.
    pub cells: Vec<(String, String)>,
    /// The answers to properties in their order.
    pub answers: Vec<String>,
    /// The reasons why properties have no answer.
    pub notes: Vec<String>,
    /// The reason why the instance ended early.
    pub problem: Option<String>,
}

/// The result of the process of an instance: its report, or the error that it ended with, and its row.
#[derive(Debug, Serialize, Deserialize)]
pub struct Outcome<R> {
    /// The report or the error.
    pub report: R,
    /// Its row.
    pub row: Row,
}

impl<'f> Outcome<&'f Failure> {
    /// Returns the result of an instance without a report.
    pub fn failed(report: &'f Failure) -> Self {
        Outcome { report, row: Row { problem: Some(report.message.clone()), ..Row::default() } }
    }
}

impl<F: Findings> Envelope<F> {
    /// Returns the columns of the table, which depend on the settings and not on the results. The answers to
    /// properties stand before the columns of the second list.
    fn columns(&self) -> [Vec<Column<F>>; 2] {
        let counts = |name, place, of: fn(&ModelCounts) -> &Count| {
            Column::new(name, move |r: &Envelope<F>| r.findings.counts().map(|counts| of(counts).to_string()))
                .at(place)
        };
        let mut first = vec![
            counts("states", Place::Always, |counts| &counts.states),
            counts("choices", Place::File, |counts| &counts.choices),
            counts("transitions", Place::Room(2), |counts| &counts.transitions),
        ];
        first.extend(self.findings.columns());
        let used = vec![
            Column::new("seconds", |r: &Envelope<F>| Some(r.time.total.to_string())),
            Column::new("peak_nodes", |r: &Envelope<F>| Some(r.memory.peak_nodes.to_string()))
                .at(Place::Room(1)),
            Column::new("peak_rss_bytes", |r: &Envelope<F>| Some(r.memory.peak_rss_bytes.to_string()))
                .at(Place::File),
        ];
        [first, used]
    }

    /// Returns the headings of the table: those before and after the answers to properties.
    pub fn headings(&self) -> [Vec<Heading>; 2] {
        self.columns().map(|columns| columns.into_iter().map(|column| column.heading).collect())
    }

    /// Returns the row of the table.
    pub(super) fn row_of_sweep(&self) -> Row {
        let known = |column: Column<F>| Some((column.heading.name, (column.cell)(self)?));
        let cells = self.columns().into_iter().flatten().filter_map(known).collect();
        let problem = self.error.as_ref().map(|failure| failure.message.clone());
        let (answers, notes) = self.findings.answers().into_iter().unzip();
        let notes: Vec<Option<String>> = notes;
        Row { cells, answers, notes: notes.into_iter().flatten().collect(), problem }
    }
}

#[cfg(test)]
mod tests {
    use meliora_model::valuation::Valuation;
    use meliora_planning::Rank;
    use meliora_planning::result::{LevelCounts, LevelsEnd, Plan, Prospects};
    use meliora_quantities::state_values::Bound;

    use crate::properties::PropertyAnswer;
    use crate::{CheckReport, Header};

    #[test]
    fn levels_stand_in_their_columns() {
        let mut report = CheckReport::new(Header::of_model("m"));
        let sizes = |levels: &[u32]| levels.iter().map(|&n| n.into()).collect();
        report.result.sasi = LevelCounts { levels: sizes(&[5, 3]), end: LevelsEnd::Empty };
        report.result.spi = LevelCounts { levels: sizes(&[6]), end: LevelsEnd::Unbounded(6u32.into()) };
        let plan = |rank| Some(Plan { rank, actions: Vec::new() });
        let (sasi, spi) = (plan(Rank::Finite(2)), plan(Rank::Unbounded));
        report.initial = vec![Prospects {
            state: Vec::new().into(),
            owner: None,
            values: Valuation::default(),
            escape: None,
            sure: None,
            possible: None,
            most_preferred: Vec::new(),
            jointly: None,
            sasi,
            spi,
        }];
        report.time.total = 0.5;
        let row = report.row_of_sweep();
        let cell = |name: &str| row.cells.iter().find(|(own, _)| own == name).map(|(_, cell)| cell.as_str());
        for (name, expected) in [
            ("states", None),
            ("sasi_1", Some("5")),
            ("sasi_2", Some("3")),
            ("sasi_3", None),
            ("sasi_unbounded", Some("0")),
            ("sasi_levels", Some("2")),
            ("spi_unbounded", Some("6")),
            ("sasi_rank", Some("2")),
            ("spi_rank", Some("unbounded")),
            ("seconds", Some("0.5")),
        ] {
            assert_eq!(cell(name), expected, "{name}");
        }
        report.levels = 2;
        let names: Vec<String> = report.headings()[0].iter().skip(3).map(|h| h.name.clone()).collect();
        assert_eq!(names[..4], ["sasi_1", "sasi_2", "sasi_unbounded", "sasi_levels"]);
        assert_eq!(names[8..], ["sasi_rank", "spi_rank"]);
    }

    /// The cell of a Pareto front was empty, although the property was answered.
    #[test]
    fn answers_are_verdicts_or_bounds_and_never_empty_without_a_limit() {
        let open =
            |reason: Option<&str>| PropertyAnswer::open(None, "p".to_owned(), reason.map(str::to_owned));
        let answer = |holds, bounds: Option<(f64, f64)>| {
            let value = bounds.map(|(lower, upper)| Some(Bound { lower, upper, exact: None }));
            PropertyAnswer { holds, value, ..open(None) }
        };
        for (property, expected) in [
            (answer(Some(true), None), "true"),
            (answer(Some(false), Some((0.5, 0.5))), "false"),
            (answer(None, Some((0.5, 0.5))), "0.5"),
            (answer(None, Some((0.25, f64::INFINITY))), "0.25..inf"),
            (answer(None, Some((f64::INFINITY, f64::INFINITY))), "inf"),
            (
                PropertyAnswer { front: Some(vec![[0.0, 1.0], [0.5, 0.25]]), ..open(None) },
                "(0, 1) (0.5, 0.25)",
            ),
            (PropertyAnswer { value: Some(None), ..open(Some("unsafe")) }, "no value"),
            (open(Some("unknown name")), "not answered"),
            (open(None), ""),
        ] {
            assert_eq!(property.cell(), expected, "{property:?}");
        }
    }
}
