//! The table of a sweep, with a row for each instance.
//!
//! The findings of a command declare the columns of their own
//! ([`Findings::columns`](super::envelope::Findings::columns)), each with its cell, its place on a terminal and
//! its use in a plot.

use serde::{Deserialize, Serialize};

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
    /// True if a cell `false` means that the instance does not have the property.
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
pub struct Column<R> {
    pub(super) heading: Heading,
    /// Returns the cell of a report; `None` if unknown.
    pub(super) cell: Box<Cell<R>>,
}

/// The cell of a report; `None` if unknown.
type Cell<R> = dyn Fn(&R) -> Option<String>;

impl<R> Column<R> {
    /// Creates a column of numbers that is always shown.
    pub fn new(name: impl Into<String>, cell: impl Fn(&R) -> Option<String> + 'static) -> Self {
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
