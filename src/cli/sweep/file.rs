//! The file of a sweep: a header and one row per instance.
//!
//! Each row is appended as soon as its instance has ended. At the end, the file is replaced by one
//! with the rows in the order of the instances, if they ended in another order.

use std::collections::{BTreeMap, HashMap};
use std::fs::File;
use std::path::Path;

use csv::{ReaderBuilder, StringRecord, Writer};
use meliora_model::error::{Diagnostic, Error};

use super::super::files::Target;
use super::super::load;

pub(crate) struct CsvFile {
    target: Target,
    header: StringRecord,
    /// The rows by the position of their instance.
    rows: BTreeMap<usize, StringRecord>,
    /// The open file, to which rows are appended.
    out: Option<Writer<File>>,
    /// True if the rows of the file are in the order of the instances.
    is_sorted: bool,
}

impl CsvFile {
    /// Creates a file that will be written anew.
    ///
    /// # Errors
    /// The file cannot be written, or is an input of the sweep.
    pub(crate) fn new(path: &Path, inputs: &[&Path], header: StringRecord) -> Result<Self, Error> {
        let target = Target::new(path, inputs)?;
        Ok(CsvFile { target, header, rows: BTreeMap::new(), out: None, is_sorted: true })
    }

    /// Keeps the rows of the existing file, except for an incomplete last line. `instances` are the
    /// positions of the instances by the values of their constants.
    ///
    /// # Errors
    /// The file belongs to another sweep, or has two rows for one instance.
    pub(crate) fn resume(&mut self, instances: &HashMap<&[String], usize>) -> Result<(), Error> {
        if !self.target.is_taken() {
            return Ok(());
        }
        let source = load::read(self.target.path())?;
        let complete = &source.text[..source.text.rfind('\n').map_or(0, |end| end + 1)];
        let constants = instances.keys().next().map_or(0, |values| values.len());
        let mut reader =
            ReaderBuilder::new().has_headers(false).flexible(true).from_reader(complete.as_bytes());
        let mut row = StringRecord::new();
        let (mut start, mut places) = (0, HashMap::new());
        let failed = |e: csv::Error| Error::reading(self.target.path(), &e.into());
        while reader.read_record(&mut row).map_err(failed)? {
            let span = start..start + complete[start..].lines().next().map_or(0, str::len);
            let is_header = start == 0;
            start = usize::try_from(reader.position().byte()).unwrap_or(complete.len());
            if is_header && row != self.header {
                let diagnostic = Diagnostic::new(&source, span, "this is not the header of this sweep");
                let help = "leave out `--resume` to start again and overwrite the file";
                return Err(diagnostic.help(help).into());
            }
            let values: Vec<String> = row.iter().take(constants).map(str::to_owned).collect();
            match instances.get(values.as_slice()).filter(|_| row.len() == self.header.len()) {
                _ if is_header => {}
                Some(&position) => {
                    if let Some(first) = places.insert(position, span.clone()) {
                        let message = "this row has the constants of an earlier row";
                        let diagnostic = Diagnostic::new(&source, span, message).label("the same again");
                        let help = "remove one of the two, or both to compute the instance again";
                        return Err(diagnostic.related(first, "the earlier row").help(help).into());
                    }
                    self.rows.insert(position, row.clone());
                }
                None => {
                    let message = "this row does not belong to this sweep";
                    return Err(Diagnostic::new(&source, span, message).into());
                }
            }
        }
        Ok(())
    }

    /// Returns the rows that are known, without the constants, by the position of their instance.
    pub(crate) fn known(&self, constants: usize) -> BTreeMap<usize, Vec<String>> {
        let cells = |row: &StringRecord| row.iter().skip(constants).map(str::to_owned).collect();
        self.rows.iter().map(|(&position, row)| (position, cells(row))).collect()
    }

    /// Returns whether the rows are printed in place of the table.
    pub(crate) fn is_stdout(&self) -> bool {
        self.target.is_stdout()
    }

    /// Returns whether an instance has its row.
    pub(crate) fn has(&self, position: usize) -> bool {
        self.rows.contains_key(&position)
    }

    /// Replaces the file by the header and the known rows, and opens it for more.
    ///
    /// # Errors
    /// The file cannot be written.
    pub(crate) fn open(&mut self) -> Result<(), Error> {
        if self.is_stdout() {
            return self.target.write(&self.text());
        }
        let out = self.target.begin(&self.text())?;
        self.out = Some(Writer::from_writer(out));
        Ok(())
    }

    /// Appends a row.
    ///
    /// # Errors
    /// The file cannot be written.
    pub(crate) fn add(&mut self, position: usize, row: StringRecord) -> Result<(), Error> {
        self.is_sorted &= self.rows.last_key_value().is_none_or(|(&last, _)| last < position);
        if self.is_stdout() {
            self.target.write(&meliora_model::csv::lines([&row]))?;
        }
        if let Some(out) = &mut self.out {
            let written = out.write_record(&row).map_err(Into::into).and_then(|()| out.flush());
            written.map_err(|e| Error::writing(self.target.path(), &e))?;
        }
        self.rows.insert(position, row);
        Ok(())
    }

    /// Sorts the rows of the file.
    ///
    /// # Errors
    /// The file cannot be written.
    pub(crate) fn finish(&self) -> Result<(), Error> {
        match self.is_sorted || !self.target.is_regular() {
            true => Ok(()),
            false => self.target.write(&self.text()),
        }
    }

    fn text(&self) -> String {
        meliora_model::csv::lines([&self.header].into_iter().chain(self.rows.values()))
    }
}
