//! Writing of files, which appear whole or not at all.
//!
//! Contents are written next to their destination and then moved there. Only a killed process leaves
//! a temporary file behind; its prefix names the program.

use std::collections::BTreeSet;
use std::fs::{self, File, Metadata};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use tempfile::{Builder, NamedTempFile, TempDir};

use crate::sync::lock;

/// The temporary files and directories of this process; `None` once [`remove_unfinished`] was called.
static UNFINISHED: Mutex<Option<BTreeSet<PathBuf>>> = Mutex::new(Some(BTreeSet::new()));

/// Changes the list of temporary files, together with the files.
///
/// # Errors
/// The process ends; or the change fails.
fn change<T>(change: impl FnOnce(&mut BTreeSet<PathBuf>) -> io::Result<T>) -> io::Result<T> {
    match lock(&UNFINISHED).as_mut() {
        Some(unfinished) => change(unfinished),
        None => Err(io::Error::new(io::ErrorKind::Interrupted, "the process ends")),
    }
}

/// Removes what threads that were left behind are still writing. After that, no file can be written here:
/// this is for the end of a process.
pub fn remove_unfinished() {
    let mut unfinished = lock(&UNFINISHED);
    for path in unfinished.take().into_iter().flatten() {
        // A file that cannot be removed stays: there is nobody to tell.
        let _ = if path.is_dir() { fs::remove_dir_all(path) } else { fs::remove_file(path) };
    }
}

/// An entry of the list of temporary files.
struct Listed(PathBuf);

impl Drop for Listed {
    fn drop(&mut self) {
        let _ = change(|unfinished| Ok(unfinished.remove(&self.0)));
    }
}

/// A temporary file or directory, which is removed when it is dropped and by [`remove_unfinished`].
struct Temporary<T> {
    content: T,
    listed: Listed,
}

impl<T> Temporary<T> {
    fn create(make: impl FnOnce() -> io::Result<T>, path: impl Fn(&T) -> &Path) -> io::Result<Self> {
        change(|unfinished| {
            let content = make()?;
            let listed = Listed(path(&content).to_owned());
            unfinished.insert(listed.0.clone());
            Ok(Temporary { content, listed })
        })
    }

    /// Moves the content elsewhere. The path is not removed any more.
    fn finish<R>(self, moving: impl FnOnce(T) -> io::Result<R>) -> io::Result<R> {
        let Temporary { content, listed } = self;
        change(|unfinished| {
            let moved = moving(content)?;
            unfinished.remove(&listed.0);
            Ok(moved)
        })
    }
}

fn file_next_to(path: &Path) -> io::Result<Temporary<NamedTempFile>> {
    Temporary::create(|| builder(0o666).tempfile_in(folder(path)), NamedTempFile::path)
}

/// Returns the folder of a path.
pub fn folder(path: &Path) -> &Path {
    path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Returns true for a regular file, false for a link, a pipe, or nothing.
pub fn is_regular(path: &Path) -> bool {
    fs::symlink_metadata(path).is_ok_and(|found| found.is_file())
}

/// The content of a regular file in a temporary file next to it, with a copy of the old file.
pub struct Replacement<'p> {
    path: &'p Path,
    new: Temporary<NamedTempFile>,
    backup: Option<Temporary<NamedTempFile>>,
}

impl<'p> Replacement<'p> {
    /// Writes the content. The file keeps the mode of the old one. With `copied`, also copies the old
    /// file so that it can be restored.
    ///
    /// # Errors
    /// The folder cannot be written, or the disk is full.
    pub fn new(path: &'p Path, old: Option<&Metadata>, content: &[u8], copied: bool) -> io::Result<Self> {
        let mut new = file_next_to(path)?;
        new.content.write_all(content)?;
        Self::of(path, new, old, copied)
    }

    /// Begins a content that is appended piece by piece ([`Write`]). The file keeps the mode of the old
    /// one.
    ///
    /// # Errors
    /// The folder cannot be written.
    pub fn begin(path: &'p Path, old: Option<&Metadata>) -> io::Result<Self> {
        Self::of(path, file_next_to(path)?, old, false)
    }

    fn of(
        path: &'p Path,
        new: Temporary<NamedTempFile>,
        old: Option<&Metadata>,
        copied: bool,
    ) -> io::Result<Self> {
        let Some(old) = old else { return Ok(Replacement { path, new, backup: None }) };
        keep_mode(new.content.as_file(), old)?;
        let backup = copied.then(|| file_next_to(path)).transpose()?;
        if let Some(backup) = &backup {
            fs::copy(path, backup.content.path())?;
        }
        Ok(Replacement { path, new, backup })
    }

    /// Moves the content to its destination.
    ///
    /// # Errors
    /// The file cannot be replaced.
    pub fn install(self) -> io::Result<Installed<'p>> {
        self.new.finish(|new| Ok(new.persist(self.path)?))?;
        Ok(Installed { path: self.path, backup: self.backup })
    }
}

impl Write for Replacement<'_> {
    fn write(&mut self, content: &[u8]) -> io::Result<usize> {
        self.new.content.write(content)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.new.content.flush()
    }
}

/// A file that was replaced.
pub struct Installed<'p> {
    path: &'p Path,
    backup: Option<Temporary<NamedTempFile>>,
}

impl Installed<'_> {
    /// Restores the old file.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn undo(self) -> io::Result<()> {
        match self.backup {
            Some(backup) => backup.finish(|backup| Ok(backup.persist(self.path).map(drop)?)),
            None => fs::remove_file(self.path),
        }
    }
}

/// A new directory, in a temporary one next to its destination.
pub struct NewDirectory(Temporary<TempDir>);

impl NewDirectory {
    /// Creates a directory next to `path`, with the default mode of new directories.
    ///
    /// # Errors
    /// The folder of `path` cannot be written.
    pub fn new(path: &Path) -> io::Result<Self> {
        let make = || builder(0o777).tempdir_in(folder(path));
        Temporary::create(make, TempDir::path).map(NewDirectory)
    }

    /// Returns the path of the temporary directory.
    pub fn path(&self) -> &Path {
        self.0.content.path()
    }

    /// Creates a file in it.
    ///
    /// # Errors
    /// The directory cannot be written.
    pub fn create(&self, name: &str) -> io::Result<File> {
        change(|_| File::create(self.path().join(name)))
    }

    /// Writes a file into it.
    ///
    /// # Errors
    /// The directory cannot be written, or the disk is full.
    pub fn write(&self, name: &str, content: &[u8]) -> io::Result<()> {
        let mut out = self.create(name)?;
        out.write_all(content)?;
        out.sync_all()
    }

    /// Moves the directory to a path where nothing is, or an empty directory.
    ///
    /// # Errors
    /// Something else is there, or the folder cannot be written.
    pub fn install(self, path: &Path) -> io::Result<()> {
        self.0.finish(|new| {
            fs::rename(new.path(), path)?;
            let _ = new.keep();
            Ok(())
        })
    }

    /// Exchanges the directory atomically for another one. Returns the new path of the other one.
    ///
    /// # Errors
    /// The folder cannot be written, or the system has no such operation.
    pub fn exchange(self, path: &Path) -> io::Result<PathBuf> {
        self.0.finish(|new| {
            exchange(new.path(), path)?;
            Ok(new.keep())
        })
    }
}

/// Builds temporary files and directories with this mode, from which the system takes what the user's
/// mask forbids.
fn builder(mode: u32) -> Builder<'static, 'static> {
    let mut builder = Builder::new();
    builder.prefix(".meliora-");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(mode));
    }
    #[cfg(not(unix))]
    let _ = mode;
    builder
}

/// Gives a file the mode of the file that it replaces, and its owner if that is allowed.
fn keep_mode(file: &File, old: &Metadata) -> io::Result<()> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::{MetadataExt, fchown};
        let _ = fchown(file, Some(old.uid()), Some(old.gid()));
    }
    file.set_permissions(old.permissions())
}

#[cfg(any(target_os = "linux", target_os = "android", target_vendor = "apple"))]
fn exchange(a: &Path, b: &Path) -> io::Result<()> {
    use rustix::fs::{CWD, RenameFlags, renameat_with};
    Ok(renameat_with(CWD, a, CWD, b, RenameFlags::EXCHANGE)?)
}

#[cfg(not(any(target_os = "linux", target_os = "android", target_vendor = "apple")))]
fn exchange(_: &Path, _: &Path) -> io::Result<()> {
    Err(io::ErrorKind::Unsupported.into())
}
