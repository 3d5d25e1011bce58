//! The file of a sweep: a header and one row per instance.
//!
//! Each row is appended as soon as its instance has ended, and is not kept. At the end, the file is
//! replaced by one with the rows in the order of the instances, if they ended in another order.

use std::collections::BTreeMap;
use std::fs::{self, File, OpenOptions};
use std::io::Write;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use meliora_base::csv as cells;
use meliora_base::error::{Diagnostic, Error, SourceFile};
use meliora_base::files::Replacement;

/// Receives the rows of a sweep.
pub trait Destination {
    /// Returns the path as the user gave it.
    fn path(&self) -> &Path;

    /// Returns whether this is a regular file, which may not exist yet.
    fn is_regular(&self) -> bool;

    /// Returns whether a regular file exists there.
    fn is_taken(&self) -> bool;

    /// Replaces the text.
    ///
    /// # Errors
    /// The text cannot be written.
    fn write(&self, text: &str) -> Result<(), Error>;

    /// Replaces the text, and returns the open file, to which more can be appended; `None` if more is written by
    /// [`Destination::write`], as to standard output.
    ///
    /// # Errors
    /// The text cannot be written.
    fn begin(&self, text: &str) -> Result<Option<File>, Error>;
}

/// A regular file, which may not exist yet.
pub struct RegularFile {
    /// The path as the user gave it.
    path: PathBuf,
    /// The path behind all links.
    real: PathBuf,
    is_taken: bool,
}

impl RegularFile {
    /// Checks a path. `inputs` are the files that the sweep reads.
    ///
    /// # Errors
    /// [`Error::Usage`] if the path is an input, or is not a regular file.
    pub fn new(given: &Path, inputs: &[&Path]) -> Result<Self, Error> {
        let wrong = |what: &str| Error::Usage(format!("{} {what}", given.display()));
        let Ok(real) = fs::canonicalize(given) else {
            return Ok(RegularFile { path: given.to_owned(), real: given.to_owned(), is_taken: false });
        };
        if !real.is_file() {
            return Err(wrong("is not a regular file; rows are written to regular files"));
        }
        if inputs.iter().any(|input| fs::canonicalize(input).is_ok_and(|input| input == real)) {
            return Err(wrong("is an input of this sweep; write the rows to another file"));
        }
        Ok(RegularFile { path: given.to_owned(), real, is_taken: true })
    }
}

impl Destination for RegularFile {
    fn path(&self) -> &Path {
        &self.path
    }

    fn is_regular(&self) -> bool {
        true
    }

    fn is_taken(&self) -> bool {
        self.is_taken
    }

    fn write(&self, text: &str) -> Result<(), Error> {
        let old = fs::metadata(&self.real).ok();
        let new = Replacement::new(&self.real, old.as_ref(), text.as_bytes(), false);
        new.and_then(Replacement::install).map(drop).map_err(|e| Error::writing(&self.path, &e))
    }

    fn begin(&self, text: &str) -> Result<Option<File>, Error> {
        self.write(text)?;
        let out = OpenOptions::new().append(true).open(&self.real);
        out.map(Some).map_err(|e| Error::writing(&self.path, &e))
    }
}

/// The rows of a sweep at their destination.
pub struct RowFile<D> {
    to: D,
    header: Vec<String>,
    /// The open file, to which rows are appended.
    out: Option<File>,
    /// The position of the instance of the last row.
    last: Option<usize>,
    /// True if the rows of the file are in the order of the instances.
    is_sorted: bool,
}

/// Returns the position of the instance with these values of the constants; `None` for values of
/// another sweep.
pub(super) type Find<'f> = &'f dyn Fn(&[&str]) -> Option<usize>;

/// A row of an existing file: the position of its instance, its cells, and its bytes in the text.
type Known = (usize, Vec<String>, Range<usize>);

impl<D: Destination> RowFile<D> {
    /// Creates a file that will be written anew.
    pub fn new(to: D, header: Vec<String>) -> Self {
        RowFile { to, header, out: None, last: None, is_sorted: true }
    }

    /// Returns the destination.
    pub fn to(&self) -> &D {
        &self.to
    }

    /// Opens the file with the header.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn open(&mut self) -> Result<(), Error> {
        self.begin(&cells::lines([&self.header]))
    }

    /// Opens the file with the rows that it has, except for an incomplete last line. Calls `known`
    /// with the position of the instance of each row, and the cells.
    ///
    /// # Errors
    /// The file belongs to another sweep, or has two rows for one instance; it cannot be written.
    pub fn resume(
        &mut self,
        constants: usize,
        find: Find<'_>,
        mut known: impl FnMut(usize, Vec<String>),
    ) -> Result<(), Error> {
        if !self.to.is_taken() {
            return self.open();
        }
        let source = SourceFile::open(self.to.path())?;
        let complete = &source.text[..source.text.rfind('\n').map_or(0, |end| end + 1)];
        if complete.is_empty() {
            return self.open();
        }
        self.each_row(&source, complete, constants, find, |own, (position, row, _)| {
            own.follow(position);
            known(position, row.iter().map(|cell| cells::text(cell).to_owned()).collect());
        })?;
        self.begin(complete)
    }

    /// Reads the rows of a text.
    fn each_row(
        &mut self,
        source: &Arc<SourceFile>,
        complete: &str,
        constants: usize,
        find: Find<'_>,
        mut take: impl FnMut(&mut Self, Known),
    ) -> Result<(), Error> {
        let (mut start, mut places) = (0, BTreeMap::new());
        for line in complete.split_inclusive('\n') {
            let begin = start;
            start += line.len();
            let line = line.trim_end_matches(['\r', '\n']);
            let (span, row) = (begin..begin + line.len(), cells::cells(line));
            if line.is_empty() {
                continue;
            }
            if begin == 0 {
                if !row.iter().map(String::as_str).eq(self.header.iter().map(|text| cells::cell(text))) {
                    let diagnostic = Diagnostic::new(source, span, "this is not the header of this sweep");
                    let help = "leave out `--resume` to start again and overwrite the file";
                    return Err(diagnostic.help(help).into());
                }
                continue;
            }
            let values: Vec<&str> = row.iter().take(constants).map(|cell| cells::text(cell)).collect();
            let Some(position) = find(&values).filter(|_| row.len() == self.header.len()) else {
                return Err(Diagnostic::new(source, span, "this row does not belong to this sweep").into());
            };
            if let Some(first) = places.insert(position, span.clone()) {
                return Err(twice(source, first, span).into());
            }
            take(self, (position, row, begin..start));
        }
        Ok(())
    }

    /// Replaces the file by a text, and opens it for more.
    fn begin(&mut self, text: &str) -> Result<(), Error> {
        self.out = self.to.begin(text)?;
        Ok(())
    }

    /// Notes that the row of this instance comes next.
    fn follow(&mut self, position: usize) {
        self.is_sorted &= self.last.is_none_or(|last| last < position);
        self.last = Some(position);
    }

    /// Appends a row.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn add<'c>(&mut self, position: usize, row: impl Iterator<Item = &'c str>) -> Result<(), Error> {
        self.follow(position);
        let line = cells::lines([row]);
        match &mut self.out {
            Some(out) => out.write_all(line.as_bytes()).map_err(|e| Error::writing(self.to.path(), &e)),
            None => self.to.write(&line),
        }
    }

    /// Sorts the rows of the file.
    ///
    /// # Errors
    /// The file cannot be read or written, or was changed meanwhile.
    pub fn finish(mut self, constants: usize, find: Find<'_>) -> Result<(), Error> {
        if self.is_sorted || !self.to.is_regular() {
            return Ok(());
        }
        let path = self.to.path();
        let text = fs::read_to_string(path).map_err(|e| Error::reading(path, &e))?;
        let source = SourceFile::new(path.display().to_string(), text);
        let mut lines: BTreeMap<usize, Range<usize>> = BTreeMap::new();
        self.each_row(&source, &source.text, constants, find, |_, (position, _, bytes)| {
            lines.insert(position, bytes);
        })?;
        let header = cells::lines([&self.header]);
        let sorted = lines.into_values().map(|bytes| &source.text[bytes]);
        self.to.write(&std::iter::once(header.as_str()).chain(sorted).collect::<String>())
    }
}

/// Returns the error for a second row of an instance.
fn twice(source: &Arc<SourceFile>, first: Range<usize>, second: Range<usize>) -> Diagnostic {
    let message = "this row has the constants of an earlier row";
    let help = "remove one of the two, or both to compute the instance again";
    let diagnostic = Diagnostic::new(source, second, message).label("the same again");
    diagnostic.related(first, "the earlier row").help(help)
}
