//! The archive: a tar file, plain or compressed by gzip or xz.
//!
//! Reading holds the files in memory and writes nothing. The sum of their sizes is bounded, however
//! well they are compressed; see [`MOST_BYTES`].

use std::collections::BTreeMap;
use std::io::{self, Read, Write};

use flate2::read::MultiGzDecoder;
use flate2::{Compression, GzBuilder};
use lzma_rust2::XzReader;
use tar::{Archive, Builder, Header};

use crate::error::{Error, Limit, Result};
use crate::progress::ProgressSink;

/// Maximum size of the files together, in bytes, tar headers included.
const MOST_BYTES: u64 = 1 << 30;
/// Maximum size of the dictionary of xz, in KiB; the strongest usual setting takes 64 MiB.
const MOST_DICTIONARY: u32 = (80 << 20) >> 10;
/// Maximum number of files.
const MOST_FILES: usize = 1 << 16;
/// Number of bytes read between two queries whether to stop.
const CHUNK: u64 = 1 << 20;

const GZIP: &[u8] = &[0x1f, 0x8b, 0x08];
const XZ: &[u8] = &[0xfd, b'7', b'z', b'X', b'Z', 0];
const TAR: &[u8] = b"ustar";
const TAR_AT: usize = 257;

/// The files of an archive by path.
#[derive(Debug, Default)]
pub(crate) struct Files {
    name: String,
    files: BTreeMap<String, Vec<u8>>,
}

/// Returns whether some bytes are an archive, by their first bytes.
pub(crate) fn is_archive(bytes: &[u8]) -> bool {
    bytes.starts_with(GZIP)
        || bytes.starts_with(XZ)
        || bytes.get(TAR_AT..).is_some_and(|b| b.starts_with(TAR))
}

impl Files {
    /// Unpacks an archive; `name` is its path in messages.
    ///
    /// # Errors
    /// The bytes are not an archive, or are damaged; a limit.
    pub(crate) fn unpack(name: &str, bytes: &[u8], sink: &dyn ProgressSink) -> Result<Self> {
        let mut files = Files { name: name.to_owned(), files: BTreeMap::new() };
        let plain: Box<dyn Read + '_> = match bytes {
            _ if bytes.starts_with(GZIP) => Box::new(MultiGzDecoder::new(bytes)),
            _ if bytes.starts_with(XZ) => Box::new(XzReader::new_mem_limit(bytes, true, MOST_DICTIONARY)),
            _ => Box::new(bytes),
        };
        let mut archive = Archive::new(plain.take(MOST_BYTES));
        let mut total = 0;
        let damaged = |e: &io::Error| files_error(name, &format!("this is not a valid archive: {e}"));
        for entry in archive.entries().map_err(|e| damaged(&e))? {
            let mut entry = entry.map_err(|e| damaged(&e))?;
            if !entry.header().entry_type().is_file() {
                continue;
            }
            let path = String::from_utf8_lossy(&entry.path_bytes()).into_owned();
            let path = path.trim_start_matches("./").trim_start_matches('/').to_owned();
            let mut content = Vec::new();
            loop {
                if let Some(limit) = sink.stop() {
                    return Err(limit.into());
                }
                let read = (&mut entry).take(CHUNK).read_to_end(&mut content).map_err(|e| damaged(&e))?;
                if content.len() as u64 > MOST_BYTES {
                    return Err(too_large(name));
                }
                if read == 0 {
                    break;
                }
            }
            if (content.len() as u64) < entry.size() {
                return Err(too_large(name));
            }
            total += content.len() as u64;
            if files.files.insert(path.clone(), content).is_some() {
                return Err(files.wrong(&path, "the archive has two files with this name"));
            }
            if files.files.len() > MOST_FILES || total > MOST_BYTES {
                return Err(too_large(name));
            }
        }
        Ok(files)
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

fn too_large(name: &str) -> Error {
    let what = format!("{name} is damaged, or unpacks to more than {} MiB", MOST_BYTES >> 20);
    Limit::Size { what }.into()
}

/// Packs files into an archive compressed by gzip, in the given order. Equal files give equal bytes:
/// no clock is read.
///
/// # Errors
/// Compression fails, which it does not in memory.
pub(crate) fn pack(files: &[(String, Vec<u8>)]) -> io::Result<Vec<u8>> {
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
