//! The directory of a dump, which is written completely or not at all.

use std::fs;
use std::io::{self, BufReader, BufWriter, Write};
use std::path::Path;

use sha2::{Digest, Sha256};

use super::manifest::{self, Manifest};
use super::place::Place;
pub use super::place::temporary_directory;
use super::streams::{Hashing, Watched};
use super::{Diagram, dddmp, dot};
use crate::error::{Error, Result};
use crate::progress::ProgressSink;

/// A dump in memory.
#[derive(Debug, Clone)]
pub struct Dump {
    /// The meaning of the diagrams.
    pub manifest: Manifest,
    /// The regions.
    pub regions: Diagram,
    /// The sets that a check without fixpoints needs.
    pub certificate: Option<Diagram>,
}

/// Returns the SHA-256 of some bytes in hexadecimal.
pub fn sha256(bytes: &[u8]) -> String {
    hex(Sha256::digest(bytes).as_slice())
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|b| format!("{b:02x}")).collect()
}

/// Writes a dump into a directory that does not exist yet, is empty, or contains only a dump, which
/// is replaced. All files appear together, after the last is written; an old dump remains until
/// then. Fills in the hashes and sizes of the manifest, which it returns. With `dot`, each region
/// also gets a DOT file.
///
/// # Errors
/// The directory contains something else, or cannot be written; the work is cancelled.
pub fn write_directory(
    mut dump: Dump,
    directory: &Path,
    dot: bool,
    sink: &dyn ProgressSink,
) -> Result<Manifest> {
    let failed = |e: io::Error| match sink.stop() {
        Some(limit) => limit.into(),
        None => Error::writing(directory, &e),
    };
    let place = Place::find(directory)?;
    let new = place.temporary().map_err(failed)?;
    let manifest = &mut dump.manifest;
    fill(&mut manifest.regions, &dump.regions, new.path(), sink).map_err(failed)?;
    if let (Some(file), Some(diagram)) = (&mut manifest.certificate, &dump.certificate) {
        fill(file, diagram, new.path(), sink).map_err(failed)?;
    }
    if dot {
        dot::write_all(&mut manifest.regions, &dump.regions, new.path(), sink).map_err(failed)?;
    }
    write_manifest(manifest, new.path()).map_err(failed)?;
    place.install(new)?;
    Ok(dump.manifest)
}

/// Checks that [`write_directory`] may write to this directory; meant to be called before long
/// work.
///
/// # Errors
/// The directory contains something else than a dump, or has no parent.
pub fn check_directory(directory: &Path) -> Result<()> {
    Place::find(directory).map(drop)
}

fn write_manifest(manifest: &Manifest, directory: &Path) -> io::Result<()> {
    let mut out = fs::File::create(directory.join(manifest::FILE))?;
    out.write_all(manifest.text()?.as_bytes())?;
    out.sync_all()
}

/// Writes one diagram, and records its hash and size.
fn fill(
    file: &mut manifest::File,
    diagram: &Diagram,
    directory: &Path,
    sink: &dyn ProgressSink,
) -> io::Result<()> {
    let out = fs::File::create(directory.join(&file.path))?;
    let out = Watched { inner: out, sink };
    let mut out = BufWriter::with_capacity(1 << 16, Hashing { inner: out, hash: Sha256::new() });
    dddmp::write(diagram, &mut out)?;
    let hashing = out.into_inner().map_err(io::IntoInnerError::into_error)?;
    hashing.inner.inner.sync_all()?;
    file.sha256 = hex(hashing.hash.finalize().as_slice());
    file.nodes = diagram.nodes.len() + 1;
    Ok(())
}

/// Reads a dump: the manifest, the regions, and the certificate if `certificate` is true.
///
/// # Errors
/// A file cannot be read, is malformed, does not have the hash of the manifest, or contradicts it;
/// the work is cancelled.
pub fn read_directory(directory: &Path, certificate: bool, sink: &dyn ProgressSink) -> Result<Dump> {
    let manifest = Manifest::read(directory)?;
    let regions = read_file(directory, &manifest, &manifest.regions, sink)?;
    let certificate = match &manifest.certificate {
        Some(file) if certificate => Some(read_file(directory, &manifest, file, sink)?),
        _ => None,
    };
    Ok(Dump { manifest, regions, certificate })
}

fn read_file(
    directory: &Path,
    manifest: &Manifest,
    file: &manifest::File,
    sink: &dyn ProgressSink,
) -> Result<Diagram> {
    let manifest_name = directory.join(manifest::FILE).display().to_string();
    let plain = Path::new(&file.path).file_name().is_some_and(|n| n == file.path.as_str());
    if !plain {
        let message = format!("`{}` is not the name of a file in this directory", file.path.escape_debug());
        return Err(Error::Dump { file: manifest_name, line: 0, message });
    }
    let path = directory.join(&file.path);
    let name = path.display().to_string();
    let failed = |e: io::Error| Error::Io { path: name.clone(), message: e.to_string() };
    let inner = Watched { inner: fs::File::open(&path).map_err(failed)?, sink };
    let input = Hashing { inner, hash: Sha256::new() };
    let mut input = BufReader::with_capacity(1 << 16, input);
    let diagram = dddmp::read(&name, &mut input).map_err(|e| sink.stop().map_or(e, Error::from))?;
    let found = hex(input.into_inner().hash.finalize().as_slice());
    if found != file.sha256 {
        let message =
            format!("the file has changed: its SHA-256 is {found}, the manifest says {}", file.sha256);
        return Err(Error::Dump { file: name, line: 0, message });
    }
    manifest.check_file(&manifest_name, file, &diagram)?;
    Ok(diagram)
}
