//! Writing of files, which appear whole or not at all.
//!
//! Contents are written next to their destination and then moved there. Only a killed process leaves
//! a temporary file behind; its prefix names the program.

use std::fs::{self, File, Metadata};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use tempfile::{Builder, NamedTempFile, TempDir};

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
    new: NamedTempFile,
    backup: Option<NamedTempFile<()>>,
}

impl<'p> Replacement<'p> {
    /// Writes the content. The file keeps the mode of the old one. With `copied`, also copies the old
    /// file so that it can be restored.
    ///
    /// # Errors
    /// The folder cannot be written, or the disk is full.
    pub fn new(path: &'p Path, old: Option<&Metadata>, content: &[u8], copied: bool) -> io::Result<Self> {
        let mut new = builder(0o666).tempfile_in(folder(path))?;
        new.write_all(content)?;
        Self::of(path, new, old, copied)
    }

    /// Begins a content that is appended piece by piece ([`Write`]). The file keeps the mode of the old
    /// one.
    ///
    /// # Errors
    /// The folder cannot be written.
    pub fn begin(path: &'p Path, old: Option<&Metadata>) -> io::Result<Self> {
        Self::of(path, builder(0o666).tempfile_in(folder(path))?, old, false)
    }

    fn of(path: &'p Path, new: NamedTempFile, old: Option<&Metadata>, copied: bool) -> io::Result<Self> {
        let Some(old) = old else { return Ok(Replacement { path, new, backup: None }) };
        keep_mode(new.as_file(), old)?;
        let copy = || builder(0o666).make_in(folder(path), |copy| fs::copy(path, copy).map(drop));
        let backup = copied.then(copy).transpose()?;
        Ok(Replacement { path, new, backup })
    }

    /// Moves the content to its destination.
    ///
    /// # Errors
    /// The file cannot be replaced.
    pub fn install(self) -> io::Result<Installed<'p>> {
        self.new.persist(self.path)?;
        Ok(Installed { path: self.path, backup: self.backup })
    }
}

impl Write for Replacement<'_> {
    fn write(&mut self, content: &[u8]) -> io::Result<usize> {
        self.new.write(content)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.new.flush()
    }
}

/// A file that was replaced.
pub struct Installed<'p> {
    path: &'p Path,
    backup: Option<NamedTempFile<()>>,
}

impl Installed<'_> {
    /// Restores the old file.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn undo(self) -> io::Result<()> {
        match self.backup {
            Some(backup) => Ok(backup.persist(self.path)?),
            None => fs::remove_file(self.path),
        }
    }
}

/// A new directory, in a temporary one next to its destination.
pub struct NewDirectory(TempDir);

impl NewDirectory {
    /// Creates a directory next to `path`, with the default mode of new directories.
    ///
    /// # Errors
    /// The folder of `path` cannot be written.
    pub fn new(path: &Path) -> io::Result<Self> {
        Ok(NewDirectory(builder(0o777).tempdir_in(folder(path))?))
    }

    /// Returns the path of the temporary directory.
    pub fn path(&self) -> &Path {
        self.0.path()
    }

    /// Creates a file in it.
    ///
    /// # Errors
    /// The directory cannot be written.
    pub fn create(&self, name: &str) -> io::Result<File> {
        File::create(self.path().join(name))
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
        fs::rename(self.path(), path)?;
        let _ = self.0.keep();
        Ok(())
    }

    /// Exchanges the directory atomically for another one. Returns the new path of the other one.
    ///
    /// # Errors
    /// The folder cannot be written, or the system has no such operation.
    pub fn exchange(self, path: &Path) -> io::Result<PathBuf> {
        exchange(self.path(), path)?;
        Ok(self.0.keep())
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
