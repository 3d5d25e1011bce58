//! The archive: a tar file, plain or compressed by gzip or xz.
//!
//! Reading holds the files in memory and writes nothing. The sum of their sizes is bounded, however
//! well they are compressed; see `MOST_BYTES`. An archive is read to its last byte: the checksums
//! of gzip and xz, the end mark of tar, and zeros after it.

use std::collections::BTreeMap;
use std::io::{self, Read, Write};

use flate2::{Compression, GzBuilder};
use tar::{Archive, Builder, Entry, EntryType, Header};

use super::unpacked::Unpacked;
use meliora_base::error::{Error, Limit, Result};
use meliora_base::progress::ProgressSink;

/// Maximum size of the unpacked archive, in bytes.
const MOST_BYTES: u64 = 1 << 30;
/// Maximum number of files.
const MOST_FILES: usize = 1 << 16;
/// Maximum size of a path, in bytes.
const LONGEST_PATH: usize = 1 << 12;

const TAR: &[u8] = b"ustar";
const TAR_AT: usize = 257;
/// The size of what the reader of tar leaves of its end mark: the second of two empty blocks.
const END: u64 = 512;
/// The first characters of the keys of sparse files.
const SPARSE: &str = "GNU.sparse.";

/// The files of an archive by path.
#[derive(Debug, Default)]
pub(crate) struct Files {
    name: String,
    files: BTreeMap<String, Vec<u8>>,
}

/// Returns whether some bytes are an archive, by their first bytes.
pub(crate) fn is_archive(bytes: &[u8]) -> bool {
    Unpacked::is_compressed(bytes) || bytes.get(TAR_AT..).is_some_and(|b| b.starts_with(TAR))
}

impl Files {
    /// Unpacks an archive; `name` is its path in messages.
    ///
    /// # Errors
    /// The bytes are not an archive, or are damaged; a limit.
    pub(crate) fn unpack(name: &str, bytes: &[u8], sink: &dyn ProgressSink) -> Result<Self> {
        let mut files = Files { name: name.to_owned(), files: BTreeMap::new() };
        let mut archive = Archive::new(Unpacked::new(name, bytes, MOST_BYTES, sink));
        for entry in archive.entries().map_err(|e| files.damaged(e))? {
            let entry = entry.map_err(|e| files.damaged(e))?;
            files.add(entry)?;
        }
        match archive.into_inner().zeros().map_err(|e| files.damaged(e))? {
            Some(zeros) if zeros >= END => Ok(files),
            Some(_) => Err(files.damaged(io::Error::other("its end is missing"))),
            None => Err(files.damaged(io::Error::other("there is data after its end"))),
        }
    }

    /// Adds a file of the archive; folders need not be added.
    fn add(&mut self, mut entry: Entry<'_, impl Read>) -> Result<()> {
        let path = entry.path_bytes();
        if path.len() > LONGEST_PATH {
            return Err(self.damaged(io::Error::other(format!("a path has {} bytes", path.len()))));
        }
        let path = String::from_utf8_lossy(&path).into_owned();
        let path = path.trim_start_matches("./").trim_start_matches('/').to_owned();
        if !self.has_content(&mut entry, &path)? {
            return Ok(());
        }
        let mut content = Vec::new();
        entry.read_to_end(&mut content).map_err(|e| self.damaged(e))?;
        if (content.len() as u64) < entry.size() {
            return Err(self.damaged(io::Error::other(format!("it ends within {path}"))));
        }
        if self.files.insert(path.clone(), content).is_some() {
            return Err(self.wrong(&path, "the archive has two files with this name"));
        }
        if self.files.len() > MOST_FILES {
            let what = format!("{} has more than {MOST_FILES} files", self.name);
            return Err(Limit::Size { what }.into());
        }
        Ok(())
    }

    /// Returns whether an entry is a file, and not a folder. Other entries, such as links, are
    /// refused: without them, the model would be another one.
    fn has_content(&self, entry: &mut Entry<'_, impl Read>, path: &str) -> Result<bool> {
        let mut is_sparse = false;
        for extension in entry.pax_extensions().map_err(|e| self.damaged(e))?.into_iter().flatten() {
            let extension = extension.map_err(|e| self.damaged(e))?;
            is_sparse |= extension.key_bytes().starts_with(SPARSE.as_bytes());
        }
        match entry.header().entry_type() {
            EntryType::Regular | EntryType::Continuous if !is_sparse => Ok(true),
            EntryType::Directory => Ok(false),
            _ => Err(self.wrong(path, "only plain files and folders are supported in an archive")),
        }
    }

    /// Returns the error of an archive that cannot be read; a limit of [`Unpacked`] as it is.
    fn damaged(&self, error: io::Error) -> Error {
        error.downcast::<Error>().unwrap_or_else(|error| {
            files_error(&self.name, &format!("this is not a valid archive, or is damaged: {error}"))
        })
    }

    /// Returns the content of a file, if it exists.
    pub(crate) fn get(&self, path: &str) -> Option<&[u8]> {
        self.files.get(path).map(Vec::as_slice)
    }

    /// Returns the size of all files together.
    pub(crate) fn bytes(&self) -> u64 {
        self.files.values().map(|f| f.len() as u64).sum()
    }

    /// Returns the path of the archive.
    pub(crate) fn name(&self) -> &str {
        &self.name
    }

    /// Returns the error of a file of the archive.
    pub(crate) fn wrong(&self, path: &str, message: &str) -> Error {
        files_error(&self.name, &format!("{path}: {message}"))
    }
}

fn files_error(name: &str, message: &str) -> Error {
    Error::Io { path: name.to_owned(), message: message.to_owned() }
}

/// Packs files into an archive compressed by gzip, in the given order. Equal files give equal bytes:
/// no clock is read.
///
/// # Errors
/// Compression fails, which it does not in memory.
pub fn pack(files: &[(String, Vec<u8>)]) -> io::Result<Vec<u8>> {
    let packed = GzBuilder::new().mtime(0).write(Vec::new(), Compression::default());
    let mut builder = Builder::new(packed);
    for (path, content) in files {
        let mut header = Header::new_ustar();
        header.set_size(content.len() as u64);
        header.set_mode(0o644);
        header.set_mtime(0);
        builder.append_data(&mut header, path, content.as_slice())?;
    }
    let mut packed = builder.into_inner()?;
    packed.flush()?;
    packed.finish()
}
