//! Sweeps: one instance per combination of values of constants, one row per instance.
//!
//! A [`Sweep`] knows which instances are left to run, and writes their rows as they end. The caller runs them: the
//! command as processes, the Python package as calls or as tasks of a cluster. [`Columns`] makes the cells of a row
//! from the report of the command.
//!
//! ```
//! use meliora::output::Report;
//! use meliora::sweep::{Columns, Ended, RegularFile, Sweep, ranges};
//! use meliora::{Model, Options, Settings, SourceFile};
//!
//! let text = "mdp const int N; module m x : [0..N]; [] x<N -> (x'=x+1); [] x=N -> true; endmodule";
//! let wishes = SourceFile::new("wishes", "objective Begin = F x=0; objective End = F x=N; prefer End > Begin;");
//! let mut sweep = Sweep::<RegularFile>::new(ranges::parse("N=2:4")?, Columns::of_check(None))?;
//! let mut states = Vec::new();
//! for position in sweep.left() {
//!     let model = Model::parse(text, &ranges::constants(&sweep.ranges, position))?;
//!     let mut analysis = model.explore(Settings::default())?.prefer(&wishes, Options::default())?;
//!     analysis.run(&mut |_| ())?;
//!     let cells = sweep.columns.cells(&analysis.report("wishes")?.row(), Ended::Done);
//!     sweep.add(position, &cells)?; // nothing, unless a file is open
//!     states.push(cells[0].clone());
//! }
//! assert_eq!(states, ["3", "4", "5"]);
//! # Ok::<(), meliora::Error>(())
//! ```

mod columns;
mod file;
mod plot;
pub mod ranges;

use std::collections::HashSet;
use std::sync::Arc;

use meliora_base::error::Error;

pub use columns::{Columns, Ended};
pub use file::{Destination, RegularFile, RowFile};
pub use plot::{Rows, plot};
use ranges::Positions;
pub use ranges::Range;

/// The instances of a sweep, and the file of their rows.
pub struct Sweep<D> {
    /// The constants with their values.
    pub ranges: Arc<[Range]>,
    /// The columns after the constants.
    pub columns: Columns,
    /// The number of all instances.
    count: usize,
    /// The positions of the instances that have a row in the file already.
    skipped: HashSet<usize>,
    file: Option<RowFile<D>>,
}

impl<D: Destination> Sweep<D> {
    /// Creates a sweep without a file.
    ///
    /// # Errors
    /// There are too many instances.
    pub fn new(ranges: Vec<Range>, columns: Columns) -> Result<Self, Error> {
        let count = ranges::count(&ranges)?;
        Ok(Sweep { ranges: ranges.into(), columns, count, skipped: HashSet::new(), file: None })
    }

    /// Returns the names of the columns, those of the constants first.
    pub fn header(&self) -> Vec<String> {
        let constants = self.ranges.iter().map(|range| range.name.as_str());
        constants.chain(self.columns.names()).map(str::to_owned).collect()
    }

    /// Opens the file of the rows, which is written anew.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn open(&mut self, to: D) -> Result<(), Error> {
        self.file.insert(RowFile::new(to, self.header())).open()
    }

    /// Opens the file of the rows, and skips the instances that have a row in it. Calls `known` with the position of
    /// each of these, and the cells after the constants.
    ///
    /// # Errors
    /// The file belongs to another sweep, or has two rows for one instance; it cannot be written.
    pub fn resume(&mut self, to: D, mut known: impl FnMut(usize, Vec<String>)) -> Result<(), Error> {
        let mut file = RowFile::new(to, self.header());
        let (positions, constants) = (Positions::new(&self.ranges), self.ranges.len());
        file.resume(constants, &|values: &[&str]| positions.get(values), |position, mut cells| {
            self.skipped.insert(position);
            known(position, cells.split_off(constants));
        })?;
        self.file = Some(file);
        Ok(())
    }

    /// Returns the destination of the rows.
    pub fn to(&self) -> Option<&D> {
        self.file.as_ref().map(RowFile::to)
    }

    /// Returns the number of instances whose rows the file had.
    pub fn skipped(&self) -> usize {
        self.skipped.len()
    }

    /// Returns the positions of the instances that are left to run.
    pub fn left(&self) -> impl Iterator<Item = usize> + Send + use<D> {
        let skipped = self.skipped.clone();
        (0..self.count).filter(move |position| !skipped.contains(position))
    }

    /// Writes the row of an instance; `cells` are those after the constants.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn add(&mut self, position: usize, cells: &[String]) -> Result<(), Error> {
        let Some(file) = &mut self.file else { return Ok(()) };
        let values = ranges::instance(&self.ranges, position).into_iter();
        file.add(position, values.chain(cells.iter().map(String::as_str)))
    }

    /// Sorts the rows of the file by their instances.
    ///
    /// # Errors
    /// The file cannot be read or written, or was changed meanwhile.
    pub fn finish(&mut self) -> Result<(), Error> {
        let Some(file) = self.file.take() else { return Ok(()) };
        let positions = Positions::new(&self.ranges);
        file.finish(self.ranges.len(), &|values: &[&str]| positions.get(values))
    }
}
