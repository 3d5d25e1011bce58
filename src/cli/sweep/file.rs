//! The file of a sweep: a header and one row per instance, in the order of the instances. The file
//! is complete after each row.

use std::collections::BTreeMap;
use std::path::Path;

use meliora::error::{Diagnostic, Error};

use super::super::files::Target;
use super::super::load;

pub(crate) struct CsvFile {
    target: Target,
    header: String,
    /// The rows by the position of their instance.
    rows: BTreeMap<usize, String>,
}

impl CsvFile {
    /// Creates a file that will be written anew.
    ///
    /// # Errors
    /// The file cannot be written, or is an input of the sweep.
    pub(crate) fn new(path: &Path, inputs: &[&Path], header: &[String]) -> Result<Self, Error> {
        let target = Target::new(path, inputs)?;
        if target.is_stdout() {
            let message = "`--csv` needs a file: standard output is used for the table or the JSON object";
            return Err(Error::Usage(message.to_owned()));
        }
        Ok(CsvFile { target, header: header.join(","), rows: BTreeMap::new() })
    }

    /// Keeps the rows of the existing file. `instances` are the positions of the instances with the
    /// beginnings of their rows.
    ///
    /// # Errors
    /// The file belongs to another sweep.
    pub(crate) fn resume(&mut self, instances: &[(usize, String)]) -> Result<(), Error> {
        if !self.target.is_taken() {
            return Ok(());
        }
        let source = load::read(self.target.path())?;
        let mut at = 0;
        for (number, line) in source.text.split_inclusive('\n').enumerate() {
            let (row, span) = (line.trim_end(), at..at + line.trim_end().len());
            at += line.len();
            let known = instances.iter().find(|(_, start)| begins(row, start));
            match (number, known) {
                (0, _) if row == self.header => {}
                (0, _) => {
                    let message = "this is not the header of this sweep";
                    let diagnostic = Diagnostic::new(&source, span, message);
                    return Err(diagnostic
                        .help("leave out `--resume` to start again and overwrite the file")
                        .into());
                }
                (_, Some((position, _))) => drop(self.rows.insert(*position, row.to_owned())),
                (_, None) => {
                    let message = "this row does not belong to this sweep";
                    return Err(Diagnostic::new(&source, span, message).into());
                }
            }
        }
        Ok(())
    }

    /// Returns whether an instance has its row.
    pub(crate) fn has(&self, position: usize) -> bool {
        self.rows.contains_key(&position)
    }

    /// Adds a row and writes the file.
    ///
    /// # Errors
    /// The file cannot be written.
    pub(crate) fn add(&mut self, position: usize, cells: &[String]) -> Result<(), Error> {
        self.rows.insert(position, cells.join(","));
        self.write()
    }

    /// Writes the whole file.
    ///
    /// # Errors
    /// The file cannot be written.
    pub(crate) fn write(&self) -> Result<(), Error> {
        let mut text = self.header.clone() + "\n";
        for row in self.rows.values() {
            text.push_str(row);
            text.push('\n');
        }
        self.target.write(&text)
    }
}

/// Returns whether a row belongs to an instance: its first cells are the values of the constants.
fn begins(row: &str, start: &str) -> bool {
    row.strip_prefix(start).is_some_and(|rest| rest.starts_with(',') || start.is_empty())
}
