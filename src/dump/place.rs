//! The replacement of a directory of this program, such as a dump. At every moment either the old or the
//! new one is complete in its place, and files that are not part of it are never removed.

use std::collections::BTreeSet;
use std::fs::{self, Metadata};
use std::io;
use std::path::{Path, PathBuf};

use meliora_base::error::{Error, Result};
use meliora_base::files::{NewDirectory, folder};

/// A kind of directory that this program writes.
#[derive(Clone, Copy)]
pub struct Sort {
    /// Its name in messages.
    pub name: &'static str,
    /// Returns the files of the directory at a path that are as they were written, which may be
    /// removed; `None` if it is of another kind.
    pub files: fn(&Path) -> Option<BTreeSet<String>>,
}

/// A directory that may be written.
pub struct Place {
    sort: Sort,
    given: PathBuf,
    /// The path with all links resolved, absolute; it stays valid when directories move.
    path: PathBuf,
    /// The metadata of the existing directory, for its mode.
    old: Option<Metadata>,
    /// The files that are replaced.
    files: BTreeSet<String>,
}

impl Place {
    /// Checks a directory that does not exist yet, is empty, or is of this kind.
    ///
    /// # Errors
    /// The directory contains something else; its parent does not exist.
    pub fn find(given: &Path, sort: Sort) -> Result<Self> {
        let failed = |e: io::Error| Error::writing(given, &e);
        let (path, old) = match fs::metadata(given) {
            Ok(old) if !old.is_dir() => {
                let (path, name) = (given.display().to_string(), sort.name);
                let message =
                    format!("this is a file; a {name} is a directory: name a new one or an empty one");
                return Err(Error::Io { path, message });
            }
            Ok(old) => (fs::canonicalize(given).map_err(failed)?, Some(old)),
            Err(e) if e.kind() == io::ErrorKind::NotFound => (new_path(given).map_err(failed)?, None),
            Err(e) => return Err(failed(e)),
        };
        let mut place = Place { sort, given: given.to_owned(), path, old, files: BTreeSet::new() };
        if place.old.is_some() {
            place.look()?;
        }
        Ok(place)
    }

    /// Lists the files of the existing directory.
    fn look(&mut self) -> Result<()> {
        let mut there = BTreeSet::new();
        for entry in fs::read_dir(&self.path).map_err(|e| Error::writing(&self.given, &e))? {
            let entry = entry.map_err(|e| Error::writing(&self.given, &e))?;
            there.insert(entry.file_name().to_string_lossy().into_owned());
        }
        if there.is_empty() {
            return Ok(());
        }
        let name = self.sort.name;
        let Some(own) = (self.sort.files)(&self.path) else {
            let message = format!("the directory exists and is neither empty nor a {name} of this program");
            return Err(self.refused(&message));
        };
        if let Some(foreign) = there.iter().find(|file| !own.contains(*file)) {
            let message = format!(
                "the directory contains `{foreign}`, which does not belong to the {name} as it was written"
            );
            return Err(self.refused(&(message + "; move it away, or choose another directory")));
        }
        self.files = there;
        Ok(())
    }

    fn refused(&self, message: &str) -> Error {
        Error::Io { path: self.given.display().to_string(), message: message.to_owned() }
    }

    /// Creates a new directory next to the place.
    pub fn temporary(&self) -> io::Result<NewDirectory> {
        NewDirectory::new(&self.path)
    }

    /// Moves the new directory into place. An old one is exchanged for it, and then removed.
    pub fn install(mut self, new: NewDirectory) -> Result<()> {
        let given = self.given.clone();
        let failed = |e: io::Error| Error::writing(&given, &e);
        if let Some(old) = &self.old {
            fs::set_permissions(new.path(), old.permissions()).map_err(failed)?;
            // Hours may have passed, so the directory is checked again.
            self.look()?;
        }
        if self.files.is_empty() {
            // Renaming replaces an empty directory.
            return new.install(&self.path).map_err(failed);
        }
        let name = self.sort.name;
        let old = new.exchange(&self.path).map_err(|e| match e.kind() {
            io::ErrorKind::Unsupported | io::ErrorKind::InvalidInput => {
                let message = "this file system cannot exchange two directories; remove the old";
                self.refused(&format!("{message} {name} or choose another directory"))
            }
            _ => failed(e),
        })?;
        self.remove(&old).map_err(|e| {
            let message = format!(
                "the new {name} was written, but the old one could not be removed from {}: {e}",
                old.display()
            );
            self.refused(&message)
        })
    }

    /// Removes the files that were replaced, and no others.
    fn remove(&self, old: &Path) -> io::Result<()> {
        self.files.iter().try_for_each(|name| fs::remove_file(old.join(name)))?;
        fs::remove_dir(old)
    }
}

/// Returns the resolved path of a directory that does not exist yet.
fn new_path(given: &Path) -> io::Result<PathBuf> {
    match given.file_name() {
        Some(name) if fs::symlink_metadata(given).is_err() => Ok(fs::canonicalize(folder(given))?.join(name)),
        _ => Err(io::Error::other("this is a broken link")),
    }
}
