//! A folder that receives several files: all of them or none.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use meliora_base::error::Error;
use meliora_base::files::{NewDirectory, folder};
use meliora_dump::manifest;

use super::files::{self, Target};

/// An output folder, checked before the work begins.
pub(super) struct Folder {
    given: PathBuf,
    names: Vec<String>,
    /// The destinations of the files; `None` if the folder does not exist yet.
    targets: Option<Vec<Target>>,
}

impl Folder {
    /// Checks the folder that `--out` names, for files with these names. `inputs` are the files
    /// that the same run reads.
    ///
    /// # Errors
    /// The path is not a folder, or contains a dump; its parent does not exist; or a file in it
    /// cannot be replaced.
    pub(super) fn new(given: &Path, names: Vec<String>, inputs: &[&Path]) -> Result<Self, Error> {
        let failed = |message: String| Error::Io { path: given.display().to_string(), message };
        if given.as_os_str() == files::STDOUT {
            let message = "this format has several files; they cannot be written to standard output";
            return Err(Error::Usage(message.to_owned()));
        }
        let targets = match fs::metadata(given) {
            Ok(found) if !found.is_dir() => return Err(failed("this is not a directory".to_owned())),
            Ok(_) if given.join(manifest::FILE).exists() => {
                return Err(failed("the directory contains a dump; choose another directory".to_owned()));
            }
            Ok(_) => {
                let target = |name: &String| Target::new(&given.join(name), inputs);
                Some(names.iter().map(target).collect::<Result<_, _>>()?)
            }
            Err(e) if e.kind() == io::ErrorKind::NotFound => {
                let parent = folder(given);
                if !parent.is_dir() {
                    return Err(failed(format!("the folder `{}` does not exist", parent.display())));
                }
                None
            }
            Err(e) => return Err(Error::writing(given, &e)),
        };
        Ok(Folder { given: given.to_owned(), names, targets })
    }

    /// Writes the files. A new folder appears together with all of them. In an existing folder each
    /// file is replaced whole, and all are restored if one fails.
    ///
    /// # Errors
    /// The disk is full, or another process has written there.
    pub(super) fn write(self, contents: &[Vec<u8>]) -> Result<Vec<String>, Error> {
        match &self.targets {
            Some(targets) => {
                let all: Vec<_> = targets.iter().zip(contents.iter().map(Vec::as_slice)).collect();
                files::write_all(&all)?;
            }
            None => self.create(contents).map_err(|e| Error::writing(&self.given, &e))?,
        }
        Ok(self.names)
    }

    fn create(&self, contents: &[Vec<u8>]) -> io::Result<()> {
        let new = NewDirectory::new(&self.given)?;
        for (name, content) in self.names.iter().zip(contents) {
            new.write(name, content)?;
        }
        new.install(&self.given)
    }
}
