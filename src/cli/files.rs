//! Destinations of results: regular files, which appear whole or not at all, and devices, pipes and
//! standard output.

use std::fs::{self, File, Metadata, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use meliora::sweep::Destination as RowDestination;
use meliora_base::error::Error;
use meliora_base::files::{Installed, Replacement, folder};

use super::terminal;

/// The path that stands for standard output.
pub(super) const STDOUT: &str = "-";
/// Maximum number of symbolic links that are followed, as in usual systems.
const MOST_LINKS: usize = 40;

/// A destination of a result, checked before the work begins.
pub(super) struct Target {
    given: PathBuf,
    place: Place,
}

enum Place {
    /// Standard output.
    Stdout,
    /// A device or a pipe, which accepts bytes as they come.
    Stream,
    /// A regular file that exists or can be created: its path behind all links, and the metadata of
    /// the old file.
    File { path: PathBuf, old: Option<Metadata> },
}

impl Target {
    /// Checks the destination that `--out` names. `inputs` are the files that the same run reads.
    ///
    /// # Errors
    /// The path is an input, a directory or read-only, or its folder does not exist.
    pub(super) fn new(given: &Path, inputs: &[&Path]) -> Result<Self, Error> {
        let failed = |message: &str| Error::Io { path: shown(given), message: message.to_owned() };
        let place = match fs::metadata(given) {
            _ if given.as_os_str() == STDOUT => Place::Stdout,
            Ok(old) if old.is_dir() => return Err(failed("this is a directory")),
            Ok(old) if fs::metadata("/dev/stdout").is_ok_and(|out| is_same(&old, &out)) => Place::Stdout,
            Ok(old) if !old.is_file() => Place::Stream,
            Ok(old) => {
                let is_same = |path: &Path| fs::metadata(path).is_ok_and(|input| is_same(&old, &input));
                if let Some(input) = inputs.iter().find(|input| is_same(input)) {
                    let message = format!("`{}` is an input of this run, `{}`", shown(given), shown(input));
                    return Err(Error::Usage(message + "; write the results to another file"));
                }
                if old.permissions().readonly() {
                    return Err(failed("the file is read-only"));
                }
                OpenOptions::new().write(true).open(given).map_err(|e| Error::writing(given, &e))?;
                let path = fs::canonicalize(given).map_err(|e| Error::writing(given, &e))?;
                Place::File { path, old: Some(old) }
            }
            Err(e) if e.kind() == io::ErrorKind::NotFound => {
                let path = end_of_links(given).map_err(|e| Error::writing(given, &e))?;
                if !folder(&path).is_dir() {
                    return Err(failed(&format!("the folder `{}` does not exist", shown(folder(&path)))));
                }
                Place::File { path, old: None }
            }
            Err(e) => return Err(Error::writing(given, &e)),
        };
        Ok(Target { given: given.to_owned(), place })
    }

    /// Checks a destination if it is given.
    ///
    /// # Errors
    /// The errors of [`Target::new`].
    pub(super) fn maybe(given: Option<&Path>, inputs: &[&Path]) -> Result<Option<Self>, Error> {
        given.map(|given| Target::new(given, inputs)).transpose()
    }

    /// Returns whether a regular file exists there.
    pub(super) fn is_taken(&self) -> bool {
        matches!(&self.place, Place::File { old: Some(_), .. })
    }

    /// Returns whether the destination is a regular file, which may not exist yet.
    pub(super) fn is_regular(&self) -> bool {
        matches!(self.place, Place::File { .. })
    }

    /// Returns whether the destination is standard output.
    pub(super) fn is_stdout(&self) -> bool {
        matches!(self.place, Place::Stdout)
    }

    /// Returns the path as the user gave it.
    pub(super) fn path(&self) -> &Path {
        &self.given
    }

    /// Writes a text. A regular file is replaced whole and keeps its mode; other destinations are
    /// written through.
    ///
    /// # Errors
    /// The destination cannot be written, or the disk is full.
    pub(super) fn write(&self, text: &str) -> Result<(), Error> {
        write_all(&[(self, text.as_bytes())])
    }

    /// Writes a text piece by piece; returns false, and writes nothing, if it has no piece.
    ///
    /// # Errors
    /// The errors of [`Target::write`], and those of `writing`.
    pub(super) fn write_pieces(
        &self,
        writing: impl FnOnce(&mut dyn FnMut(&str) -> Result<(), Error>) -> Result<(), Error>,
    ) -> Result<bool, Error> {
        let mut pieces = None;
        writing(&mut |text| match &mut pieces {
            None => pieces.insert(self.pieces()?).push(text),
            Some(pieces) => pieces.push(text),
        })?;
        pieces.map_or(Ok(false), |pieces| pieces.finish().map(|()| true))
    }

    /// Begins to write piece by piece. A regular file is replaced once [`Pieces::finish`] is called.
    ///
    /// # Errors
    /// The errors of [`Target::write`].
    pub(super) fn pieces(&self) -> Result<Pieces<'_>, Error> {
        let begin = || -> io::Result<Destination<'_>> {
            Ok(match &self.place {
                Place::Stdout => Destination::Stdout,
                Place::Stream => Destination::Stream(Some(OpenOptions::new().write(true).open(&self.given)?)),
                Place::File { path, old } => {
                    Destination::File(BufWriter::new(Replacement::begin(path, old.as_ref())?))
                }
            })
        };
        let to = begin().map_err(|e| Error::writing(&self.given, &e))?;
        Ok(Pieces { given: &self.given, to })
    }

    /// Prepares a regular file to be replaced; returns `None` for other destinations.
    fn prepare(&self, content: &[u8], copied: bool) -> Result<Option<Replacement<'_>>, Error> {
        let Place::File { path, old } = &self.place else { return Ok(None) };
        let ready = Replacement::new(path, old.as_ref(), content, copied);
        ready.map(Some).map_err(|e| Error::writing(&self.given, &e))
    }

    /// Writes to a destination that is not a regular file.
    fn write_through(&self, content: &[u8]) -> Result<(), Error> {
        if self.is_stdout() {
            return terminal::print_bytes(content);
        }
        let out = OpenOptions::new().write(true).open(&self.given);
        match out.and_then(|mut out| out.write_all(content)) {
            // A reader that has closed the pipe is not an error, as for standard output.
            Err(e) if e.kind() != io::ErrorKind::BrokenPipe => Err(Error::writing(&self.given, &e)),
            _ => Ok(()),
        }
    }
}

impl RowDestination for Target {
    fn path(&self) -> &Path {
        &self.given
    }

    fn is_regular(&self) -> bool {
        self.is_regular()
    }

    fn is_taken(&self) -> bool {
        self.is_taken()
    }

    fn write(&self, text: &str) -> Result<(), Error> {
        self.write(text)
    }

    fn begin(&self, text: &str) -> Result<Option<File>, Error> {
        if self.is_stdout() {
            return self.write(text).map(|()| None);
        }
        if self.is_regular() {
            self.write(text)?;
        }
        let begin = || {
            let mut out = OpenOptions::new().append(true).open(&self.given)?;
            if !self.is_regular() {
                out.write_all(text.as_bytes())?;
            }
            Ok(out)
        };
        begin().map(Some).map_err(|e| Error::writing(&self.given, &e))
    }
}

/// A text that is written piece by piece, so that it need not be in memory as a whole.
pub(super) struct Pieces<'t> {
    given: &'t Path,
    to: Destination<'t>,
}

enum Destination<'t> {
    Stdout,
    /// `None` once the reader has closed the pipe, which is not an error.
    Stream(Option<File>),
    File(BufWriter<Replacement<'t>>),
}

impl Pieces<'_> {
    /// Writes a piece.
    ///
    /// # Errors
    /// The destination cannot be written, or the disk is full.
    pub(super) fn push(&mut self, text: &str) -> Result<(), Error> {
        let written = match &mut self.to {
            Destination::Stdout => return terminal::print_bytes(text.as_bytes()),
            Destination::Stream(None) => return Ok(()),
            Destination::Stream(Some(out)) => out.write_all(text.as_bytes()),
            Destination::File(out) => out.write_all(text.as_bytes()),
        };
        match (written, &mut self.to) {
            (Err(e), Destination::Stream(out)) if e.kind() == io::ErrorKind::BrokenPipe => *out = None,
            (written, _) => written.map_err(|e| Error::writing(self.given, &e))?,
        }
        Ok(())
    }

    /// Returns whether the reader has closed the pipe: further pieces are discarded.
    pub(super) fn is_closed(&self) -> bool {
        match &self.to {
            Destination::Stdout => terminal::is_closed(),
            Destination::Stream(out) => out.is_none(),
            Destination::File(_) => false,
        }
    }

    /// Ends the text. A regular file appears now; without this call, it does not.
    ///
    /// # Errors
    /// The errors of [`Pieces::push`].
    pub(super) fn finish(self) -> Result<(), Error> {
        let Destination::File(out) = self.to else { return Ok(()) };
        let whole = out.into_inner().map_err(io::IntoInnerError::into_error);
        whole.and_then(Replacement::install).map(drop).map_err(|e| Error::writing(self.given, &e))
    }
}

/// Writes several contents: all regular files or none.
///
/// # Errors
/// The errors of [`Target::write`].
pub(super) fn write_all(contents: &[(&Target, &[u8])]) -> Result<(), Error> {
    let several = contents.len() > 1;
    let ready = contents.iter().map(|(target, content)| target.prepare(content, several));
    let ready = ready.collect::<Result<Vec<_>, _>>()?;
    let mut done = Vec::new();
    for ((target, content), ready) in contents.iter().zip(ready) {
        let result = match ready {
            Some(ready) => {
                let result = ready.install().map_err(|e| Error::writing(&target.given, &e));
                result.map(|installed| done.push(installed))
            }
            None => target.write_through(content),
        };
        if result.is_err() {
            // If this fails too, the first error is still the one that is shown.
            done.into_iter().map(Installed::undo).for_each(drop);
            return result;
        }
    }
    Ok(())
}

/// Formats a path for a message.
fn shown(path: &Path) -> String {
    path.display().to_string()
}

/// Follows a chain of symbolic links whose end does not exist.
fn end_of_links(given: &Path) -> io::Result<PathBuf> {
    let mut path = given.to_owned();
    for _ in 0..MOST_LINKS {
        match fs::read_link(&path) {
            Ok(next) => path = folder(&path).join(next),
            Err(_) => return Ok(path),
        }
    }
    Err(io::Error::other("too many symbolic links"))
}

/// Returns whether both are the same file.
#[cfg(unix)]
fn is_same(a: &Metadata, b: &Metadata) -> bool {
    use std::os::unix::fs::MetadataExt;
    (a.dev(), a.ino()) == (b.dev(), b.ino())
}

/// On other systems the metadata do not tell.
#[cfg(not(unix))]
fn is_same(_: &Metadata, _: &Metadata) -> bool {
    false
}
