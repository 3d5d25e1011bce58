//! Where results go: regular files, which appear whole or not at all, and what is no regular file.

use std::fs::{self, File, Metadata, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use meliora::error::Error;
use tempfile::{Builder, NamedTempFile};

use super::terminal;

/// The path that stands for standard output.
pub(super) const STDOUT: &str = "-";
/// As many symbolic links as systems follow.
const MOST_LINKS: usize = 40;

/// A place for a result, looked at before the work for it begins.
pub(super) struct Target {
    given: PathBuf,
    place: Place,
}

enum Place {
    /// Standard output.
    Stdout,
    /// What takes bytes as they come: a device, a pipe.
    Stream,
    /// A regular file, or none yet: where all links lead, and what stands there.
    File { path: PathBuf, old: Option<Metadata> },
}

impl Target {
    /// The place that `--out` names. `inputs` are what the same run reads.
    ///
    /// # Errors
    /// It is an input, a directory, or read-only; its folder is not there.
    pub(super) fn new(given: &Path, inputs: &[&Path]) -> Result<Self, Error> {
        let failed = |message: &str| Error::Io { path: shown(given), message: message.to_owned() };
        let place = match fs::metadata(given) {
            _ if given.as_os_str() == STDOUT => Place::Stdout,
            Ok(old) if old.is_dir() => return Err(failed("this is a directory")),
            Ok(old) if fs::metadata("/dev/stdout").is_ok_and(|out| is_same(&old, &out)) => Place::Stdout,
            Ok(old) if !old.is_file() => Place::Stream,
            Ok(old) => {
                let is_input = |input: &&&Path| fs::metadata(input).is_ok_and(|input| is_same(&old, &input));
                if let Some(input) = inputs.iter().find(is_input) {
                    let message =
                        format!("`{}` is an input of the same run, `{}`", shown(given), shown(input));
                    return Err(Error::Usage(message + ": the results need another file"));
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
                    return Err(failed(&format!("there is no folder `{}`", shown(folder(&path)))));
                }
                Place::File { path, old: None }
            }
            Err(e) => return Err(Error::writing(given, &e)),
        };
        Ok(Target { given: given.to_owned(), place })
    }

    /// Whether a regular file stands there already.
    pub(super) fn is_taken(&self) -> bool {
        matches!(&self.place, Place::File { old: Some(_), .. })
    }

    /// Whether the place is standard output.
    pub(super) fn is_stdout(&self) -> bool {
        matches!(self.place, Place::Stdout)
    }

    /// The path as the user gave it.
    pub(super) fn path(&self) -> &Path {
        &self.given
    }

    /// Writes a text: a regular file is replaced whole and keeps its mode, all else is written through.
    ///
    /// # Errors
    /// The place takes nothing; the disk is full.
    pub(super) fn write(&self, text: &str) -> Result<(), Error> {
        write_all(&[(self, text)])
    }

    /// Writes a text beside its place, with a copy of what stands there where that may be put back.
    fn prepare(&self, text: &str, copied: bool) -> Result<Ready, Error> {
        let Place::File { path, old } = &self.place else { return Ok(Ready::Through) };
        let written = || {
            let mut file = usual().tempfile_in(folder(path))?;
            file.as_file_mut().write_all(text.as_bytes())?;
            let Some(old) = old else { return Ok(Ready::File { file, backup: None }) };
            keep_mode(file.as_file(), old)?;
            if !copied {
                return Ok(Ready::File { file, backup: None });
            }
            let backup = hidden().make_in(folder(path), |copy| fs::copy(path, copy).map(drop))?;
            Ok(Ready::File { file, backup: Some(backup) })
        };
        written().map_err(|e| Error::writing(&self.given, &e))
    }

    /// Writes to what is no regular file.
    fn write_through(&self, text: &str) -> Result<(), Error> {
        if self.is_stdout() {
            return terminal::print(text);
        }
        let out = OpenOptions::new().write(true).open(&self.given);
        match out.and_then(|mut out| out.write_all(text.as_bytes())) {
            // As for standard output: a reader that has gone away is no failure.
            Err(e) if e.kind() != io::ErrorKind::BrokenPipe => Err(Error::writing(&self.given, &e)),
            _ => Ok(()),
        }
    }
}

/// A text on its way to its place.
enum Ready {
    /// It is written when all others are ready.
    Through,
    /// It lies beside its place, with a copy of what stands there.
    File { file: NamedTempFile, backup: Option<NamedTempFile<()>> },
}

/// Writes several texts: all regular files or none.
///
/// # Errors
/// Those of [`Target::write`].
pub(super) fn write_all(texts: &[(&Target, &str)]) -> Result<(), Error> {
    let prepare = |(target, text): &(&Target, &str)| target.prepare(text, texts.len() > 1);
    let ready = texts.iter().map(prepare).collect::<Result<Vec<_>, _>>()?;
    let mut done = Vec::new();
    for ((target, text), ready) in texts.iter().zip(ready) {
        let result = match (ready, &target.place) {
            (Ready::File { file, backup }, Place::File { path, .. }) => {
                let result = file.persist(path).map_err(|e| Error::writing(&target.given, &e.error));
                result.map(|_| done.push((path, backup)))
            }
            _ => target.write_through(text),
        };
        if result.is_err() {
            undo(done);
            return result;
        }
    }
    Ok(())
}

/// Puts back what stood there before.
fn undo(done: Vec<(&PathBuf, Option<NamedTempFile<()>>)>) {
    for (path, backup) in done {
        // Nothing more can be done where this fails too; the first error is shown.
        let _ = match backup {
            Some(backup) => backup.persist(path).map_err(|e| e.error),
            None => fs::remove_file(path),
        };
    }
}

/// A path for a message.
fn shown(path: &Path) -> String {
    path.display().to_string()
}

/// The folder that something lies in.
pub(super) fn folder(path: &Path) -> &Path {
    path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Where a link that leads to nothing leads.
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

/// What lies beside a place for a moment. Only a process that is killed leaves it behind: its name says whose.
fn hidden() -> Builder<'static, 'static> {
    let mut builder = Builder::new();
    builder.prefix(".meliora-");
    builder
}

/// New files have the mode of any other new file; a temporary one would be its owner's alone.
fn usual() -> Builder<'static, 'static> {
    let mut builder = hidden();
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    builder
}

/// Gives a file the owner, where that is allowed, and the mode of the one that it replaces.
fn keep_mode(file: &File, old: &Metadata) -> io::Result<()> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::{MetadataExt, fchown};
        let _ = fchown(file, Some(old.uid()), Some(old.gid()));
    }
    file.set_permissions(old.permissions())
}

/// Whether both are the same file.
#[cfg(unix)]
fn is_same(a: &Metadata, b: &Metadata) -> bool {
    use std::os::unix::fs::MetadataExt;
    (a.dev(), a.ino()) == (b.dev(), b.ino())
}

/// Elsewhere nothing in the metadata tells.
#[cfg(not(unix))]
fn is_same(_: &Metadata, _: &Metadata) -> bool {
    false
}
