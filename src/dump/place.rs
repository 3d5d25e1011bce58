//! The replacement of a dump's directory. At every moment either the old or the new dump is
//! complete in its place, and files that are not part of a dump are never removed.

use std::collections::BTreeSet;
use std::fs::{self, Metadata};
use std::io;
use std::path::{Path, PathBuf};

use tempfile::TempDir;

use super::manifest::{CERTIFICATE, FILE, Manifest, REGIONS, VALUES};
use crate::error::{Error, Result};

/// A directory that may be written.
pub(super) struct Place {
    given: PathBuf,
    /// The path with all links resolved, absolute; it stays valid when directories move.
    path: PathBuf,
    /// The metadata of the existing directory, for its mode.
    old: Option<Metadata>,
    /// The files of the existing dump.
    files: BTreeSet<String>,
}

impl Place {
    /// Checks a directory that does not exist yet, is empty, or contains only a dump.
    ///
    /// # Errors
    /// The directory contains something else; its parent does not exist.
    pub(super) fn find(given: &Path) -> Result<Self> {
        let failed = |e: io::Error| Error::writing(given, &e);
        let (path, old) = match fs::metadata(given) {
            Ok(old) => (fs::canonicalize(given).map_err(failed)?, Some(old)),
            Err(e) if e.kind() == io::ErrorKind::NotFound => (new_path(given).map_err(failed)?, None),
            Err(e) => return Err(failed(e)),
        };
        let mut place = Place { given: given.to_owned(), path, old, files: BTreeSet::new() };
        if place.old.is_some() {
            place.look()?;
        }
        Ok(place)
    }

    /// Lists the files of the existing dump.
    fn look(&mut self) -> Result<()> {
        let mut there = BTreeSet::new();
        for entry in fs::read_dir(&self.path).map_err(|e| Error::writing(&self.given, &e))? {
            let entry = entry.map_err(|e| Error::writing(&self.given, &e))?;
            there.insert(entry.file_name().to_string_lossy().into_owned());
        }
        if there.is_empty() {
            return Ok(());
        }
        let Ok(manifest) = Manifest::read(&self.path) else {
            return Err(self.refused("the directory exists and is neither empty nor a dump of this program"));
        };
        let mut own: BTreeSet<String> = [FILE, REGIONS, CERTIFICATE, VALUES].map(str::to_owned).into();
        own.extend(manifest.regions.roots.into_iter().filter_map(|root| root.dot));
        if let Some(foreign) = there.iter().find(|name| !own.contains(*name)) {
            let message = format!("the directory contains `{foreign}`, which does not belong to the dump");
            return Err(self.refused(&(message + "; choose another directory")));
        }
        self.files = there;
        Ok(())
    }

    fn refused(&self, message: &str) -> Error {
        Error::Io { path: self.given.display().to_string(), message: message.to_owned() }
    }

    /// Creates a new directory next to the place.
    pub(super) fn temporary(&self) -> io::Result<TempDir> {
        temporary_directory(self.path.parent().unwrap_or(&self.path))
    }

    /// Moves the new directory into place. An old dump is exchanged for it, and then removed.
    pub(super) fn install(mut self, new: TempDir) -> Result<()> {
        let failed = |e: io::Error| Error::writing(&self.given, &e);
        if let Some(old) = &self.old {
            fs::set_permissions(new.path(), old.permissions()).map_err(failed)?;
            // Hours may have passed, so the directory is checked again.
            self.look()?;
        }
        if self.files.is_empty() {
            // Renaming replaces an empty directory.
            fs::rename(new.path(), &self.path).map_err(|e| Error::writing(&self.given, &e))?;
            let _ = new.keep();
            return Ok(());
        }
        exchange(new.path(), &self.path).map_err(|e| match e.kind() {
            io::ErrorKind::Unsupported | io::ErrorKind::InvalidInput => {
                self.refused("this file system cannot exchange two directories; remove the old dump or choose another directory")
            }
            _ => Error::writing(&self.given, &e),
        })?;
        let old = new.keep();
        self.remove(&old).map_err(|e| {
            let message = format!(
                "the new dump was written, but the old one could not be removed from {}: {e}",
                old.display()
            );
            self.refused(&message)
        })
    }

    /// Removes the files of the old dump, and no others.
    fn remove(&self, old: &Path) -> io::Result<()> {
        self.files.iter().try_for_each(|name| fs::remove_file(old.join(name)))?;
        fs::remove_dir(old)
    }
}

/// Creates a directory in another one, with the default mode of new directories. Only a killed
/// process leaves it behind; the prefix names the program.
///
/// # Errors
/// The directory cannot be written.
pub fn temporary_directory(parent: &Path) -> io::Result<TempDir> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".meliora-");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o777));
    }
    builder.tempdir_in(parent)
}

/// Returns the resolved path of a directory that does not exist yet.
fn new_path(given: &Path) -> io::Result<PathBuf> {
    let parent = given.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    match given.file_name() {
        Some(name) if fs::symlink_metadata(given).is_err() => Ok(fs::canonicalize(parent)?.join(name)),
        _ => Err(io::Error::other("this is a broken link")),
    }
}

/// Exchanges two directories atomically.
#[cfg(any(target_os = "linux", target_os = "android", target_vendor = "apple"))]
fn exchange(a: &Path, b: &Path) -> io::Result<()> {
    use rustix::fs::{CWD, RenameFlags, renameat_with};
    Ok(renameat_with(CWD, a, CWD, b, RenameFlags::EXCHANGE)?)
}

/// Fails: this system has no such operation.
#[cfg(not(any(target_os = "linux", target_os = "android", target_vendor = "apple")))]
fn exchange(_: &Path, _: &Path) -> io::Result<()> {
    Err(io::ErrorKind::Unsupported.into())
}
