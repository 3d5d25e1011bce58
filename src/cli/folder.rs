//! A folder that gets several files: all of them or none.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use meliora::dump::manifest;
use meliora::error::Error;
use tempfile::{Builder, TempDir};

use super::files::{self, Target};

/// A folder that may be written, looked at before the work begins.
pub(super) struct Folder {
    given: PathBuf,
    names: Vec<String>,
    /// The places of the files; none where the folder is not there yet.
    targets: Option<Vec<Target>>,
}

impl Folder {
    /// The folder that `--out` names, for files of these names. `inputs` are what the same run reads.
    ///
    /// # Errors
    /// It is no folder or holds a dump; the one that it is to lie in is not there; a file there cannot
    /// be replaced.
    pub(super) fn new(given: &Path, names: Vec<String>, inputs: &[&Path]) -> Result<Self, Error> {
        let failed = |message: String| Error::Io { path: given.display().to_string(), message };
        if given.as_os_str() == files::STDOUT {
            let message = "several files are written: they cannot go to standard output";
            return Err(Error::Usage(message.to_owned()));
        }
        let targets = match fs::metadata(given) {
            Ok(found) if !found.is_dir() => return Err(failed("this is no directory".to_owned())),
            Ok(_) if given.join(manifest::FILE).exists() => {
                return Err(failed("the directory holds a dump: give another directory".to_owned()));
            }
            Ok(_) => {
                let target = |name: &String| Target::new(&given.join(name), inputs);
                Some(names.iter().map(target).collect::<Result<_, _>>()?)
            }
            Err(e) if e.kind() == io::ErrorKind::NotFound => {
                let parent = files::folder(given);
                if !parent.is_dir() {
                    return Err(failed(format!("there is no folder `{}`", parent.display())));
                }
                None
            }
            Err(e) => return Err(Error::writing(given, &e)),
        };
        Ok(Folder { given: given.to_owned(), names, targets })
    }

    /// Writes the texts of the files. A new folder appears with all of them; in one that is there, each
    /// file is replaced whole, and all are put back where one fails.
    ///
    /// # Errors
    /// The disk is full; something else was written there meanwhile.
    pub(super) fn write(self, texts: &[String]) -> Result<Vec<String>, Error> {
        match &self.targets {
            Some(targets) => {
                let all: Vec<_> = targets.iter().zip(texts.iter().map(String::as_str)).collect();
                files::write_all(&all)?;
            }
            None => self.create(texts).map_err(|e| Error::writing(&self.given, &e))?,
        }
        Ok(self.names)
    }

    fn create(&self, texts: &[String]) -> io::Result<()> {
        let new = beside(&self.given)?;
        for (name, text) in self.names.iter().zip(texts) {
            fs::write(new.path().join(name), text)?;
        }
        fs::rename(new.path(), &self.given)?;
        let _ = new.keep();
        Ok(())
    }
}

/// A new folder beside the place, with the mode that new folders get.
fn beside(place: &Path) -> io::Result<TempDir> {
    let mut builder = Builder::new();
    builder.prefix(".meliora-export-");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o777));
    }
    builder.tempdir_in(files::folder(place))
}
