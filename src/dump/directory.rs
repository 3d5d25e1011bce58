//! The directory of a dump, which is written completely or not at all.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::{self, BufReader, BufWriter, Read, Write};
use std::path::Path;

use sha2::{Digest, Sha256};

use super::bounds::{self, Row};
use super::manifest::{self, Manifest};
use super::place::{Place, Sort};
use super::streams::{Hashing, Watched};
use super::{Diagram, dddmp, dot};
use meliora_base::error::{Error, Result, ensure};
use meliora_base::files::{NewDirectory, is_regular};
use meliora_base::progress::{NoProgress, ProgressSink};
pub use meliora_base::reading::sha256;
use meliora_base::reading::{hex, regular};

/// A dump in memory.
#[derive(Debug, Clone)]
pub struct Dump {
    /// The meaning of the diagrams.
    pub manifest: Manifest,
    /// The regions.
    pub regions: Diagram,
    /// The sets that a check without fixpoints needs.
    pub certificate: Option<Diagram>,
    /// The bounds of quantities that a check can confirm.
    pub values: Option<Vec<Row>>,
}

/// The directory of a dump. It contains no other files than these.
const DUMP: Sort = Sort { name: "dump", files: own_files };

/// Returns the files of a dump that are as this program wrote them: they have the hash of the
/// manifest, or are the picture of their root.
fn own_files(directory: &Path) -> Option<BTreeSet<String>> {
    let manifest = Manifest::read(directory).ok()?;
    let is_own = |name: &str, sha256: &str| {
        let path = directory.join(name);
        is_regular(&path) && read_hashed(&path, sha256, &NoProgress, |input| drained(input)).is_ok()
    };
    let (regions, certificate, values) = (&manifest.regions, &manifest.certificate, &manifest.values);
    let hashed = [
        Some((manifest::REGIONS, &regions.sha256)),
        certificate.as_ref().map(|file| (manifest::CERTIFICATE, &file.sha256)),
        values.as_ref().map(|file| (manifest::VALUES, &file.sha256)),
    ];
    let hashed = hashed.into_iter().flatten().filter(|(name, sha256)| is_own(name, sha256));
    let mut own: BTreeSet<String> = hashed.map(|(name, _)| name.to_owned()).collect();
    own.extend(is_regular(&directory.join(manifest::FILE)).then(|| manifest::FILE.to_owned()));
    if regions.roots.iter().any(|root| root.dot.is_some()) && own.contains(manifest::REGIONS) {
        let diagram = read_file(directory, &manifest, regions, &NoProgress).ok()?;
        own.extend(dot::pictures(regions, &diagram, directory, &NoProgress).ok()?);
    }
    Some(own)
}

/// Reads a file to its end.
fn drained(input: &mut impl Read) -> Result<()> {
    let failed = |e: io::Error| Error::Io { path: String::new(), message: e.to_string() };
    io::copy(input, &mut io::sink()).map(drop).map_err(failed)
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
    write_regions_first(&mut dump, directory, dot, sink)?;
    Ok(dump.manifest)
}

/// Writes a dump as [`write_directory`] does, and keeps it, so that [`complete_directory`] can add the
/// certificate and the values.
///
/// # Errors
/// The errors of [`write_directory`].
pub fn write_regions_first(
    dump: &mut Dump,
    directory: &Path,
    dot: bool,
    sink: &dyn ProgressSink,
) -> Result<()> {
    written(dump, directory, sink, |dump, new| {
        fill(&mut dump.manifest.regions, &dump.regions, new, sink)?;
        if dot { dot::write_all(&mut dump.manifest.regions, &dump.regions, new, sink) } else { Ok(()) }
    })
}

/// Adds the certificate and the values of a dump whose regions [`write_regions_first`] has written. Their
/// diagram is taken over, or written again if the file has changed meanwhile. The old dump is complete until
/// the new one is.
///
/// # Errors
/// The errors of [`write_directory`].
pub fn complete_directory(dump: &mut Dump, directory: &Path, sink: &dyn ProgressSink) -> Result<()> {
    written(dump, directory, sink, |dump, new| {
        let regions = &mut dump.manifest.regions;
        if !take_over(regions, directory, new, sink)? {
            fill(regions, &dump.regions, new, sink)?;
        }
        let has_pictures = regions.roots.iter().any(|root| root.dot.is_some());
        if has_pictures { dot::write_all(regions, &dump.regions, new, sink) } else { Ok(()) }
    })
}

/// Links a file of a dump into a new directory, or copies it if that is not possible. Returns whether it is
/// there as it was written.
fn take_over(
    file: &manifest::File,
    directory: &Path,
    new: &NewDirectory,
    sink: &dyn ProgressSink,
) -> io::Result<bool> {
    let (from, to) = (directory.join(&file.path), new.path().join(&file.path));
    if !is_regular(&from) || fs::hard_link(&from, &to).or_else(|_| fs::copy(&from, &to).map(drop)).is_err() {
        return Ok(false);
    }
    let is_same = read_hashed(&to, &file.sha256, sink, |input| drained(input)).is_ok();
    if !is_same {
        // To write to a link would change the other file.
        fs::remove_file(&to)?;
    }
    Ok(is_same)
}

/// Writes the directory of a dump; `regions` writes the files of the regions.
fn written(
    dump: &mut Dump,
    directory: &Path,
    sink: &dyn ProgressSink,
    regions: impl FnOnce(&mut Dump, &NewDirectory) -> io::Result<()>,
) -> Result<()> {
    let failed = |e: io::Error| match sink.stop() {
        Some(limit) => limit.into(),
        None => Error::writing(directory, &e),
    };
    let place = Place::find(directory, DUMP)?;
    let new = place.temporary().map_err(failed)?;
    regions(dump, &new).map_err(failed)?;
    let manifest = &mut dump.manifest;
    if let (Some(file), Some(diagram)) = (&mut manifest.certificate, &dump.certificate) {
        fill(file, diagram, &new, sink).map_err(failed)?;
    }
    if let (Some(layout), Some(rows)) = (manifest.values_layout(), &dump.values) {
        let write = |out: &mut dyn Write| bounds::write(&layout, rows, &mut &mut *out);
        let sha256 = hashed(&new, manifest::VALUES, sink, write).map_err(failed)?;
        if let Some(file) = &mut manifest.values {
            (file.sha256, file.rows) = (sha256, rows.len());
        }
    }
    let text = manifest.text().map_err(failed)?;
    new.write(manifest::FILE, text.as_bytes()).map_err(failed)?;
    place.install(new)
}

/// Checks that [`write_directory`] may write to this directory; meant to be called before long
/// work.
///
/// # Errors
/// The directory contains something else than a dump, or has no parent.
pub fn check_directory(directory: &Path) -> Result<()> {
    Place::find(directory, DUMP).map(drop)
}

/// Writes one diagram, and records its hash and size.
fn fill(
    file: &mut manifest::File,
    diagram: &Diagram,
    directory: &NewDirectory,
    sink: &dyn ProgressSink,
) -> io::Result<()> {
    file.sha256 = hashed(directory, &file.path, sink, |mut out| dddmp::write(diagram, &mut out))?;
    file.nodes = diagram.nodes.len() + 1;
    Ok(())
}

/// Writes a file, and returns the SHA-256 of its bytes.
fn hashed(
    directory: &NewDirectory,
    name: &str,
    sink: &dyn ProgressSink,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> io::Result<String> {
    let out = Watched { inner: directory.create(name)?, sink };
    let mut out = BufWriter::with_capacity(1 << 16, Hashing { inner: out, hash: Sha256::new() });
    write(&mut out)?;
    let hashing = out.into_inner().map_err(io::IntoInnerError::into_error)?;
    hashing.inner.inner.sync_all()?;
    Ok(hex(&hashing.hash.finalize()))
}

/// Reads a dump: the manifest, the regions, and, if `certificate` is true, the certificate and the
/// values. If the dump is replaced meanwhile, reads the new one.
///
/// # Errors
/// A file cannot be read, is malformed, does not have the hash of the manifest, or contradicts it;
/// the work is cancelled.
pub fn read_directory(directory: &Path, certificate: bool, sink: &dyn ProgressSink) -> Result<Dump> {
    let mut last = None;
    loop {
        let (error, seen) = match Manifest::read(directory) {
            Ok(manifest) => match read_files(directory, &manifest, certificate, sink) {
                Ok(files) => return Ok(files.with(manifest)),
                Err(error) => (error, Some(manifest)),
            },
            Err(error) => (error, None),
        };
        // The error of a dump that has not changed since is its own.
        if matches!(error, Error::Limit(_)) || last.is_some_and(|last| last == seen) {
            return Err(error);
        }
        last = Some(seen);
    }
}

/// The files of a dump without its manifest.
struct Files {
    regions: Diagram,
    certificate: Option<Diagram>,
    values: Option<Vec<Row>>,
}

impl Files {
    fn with(self, manifest: Manifest) -> Dump {
        let Files { regions, certificate, values } = self;
        Dump { manifest, regions, certificate, values }
    }
}

fn read_files(
    directory: &Path,
    manifest: &Manifest,
    certificate: bool,
    sink: &dyn ProgressSink,
) -> Result<Files> {
    let regions = read_file(directory, manifest, &manifest.regions, sink)?;
    let proof = manifest.certificate.as_ref().filter(|_| certificate);
    let values = manifest.values.as_ref().filter(|_| certificate);
    let certificate = proof.map(|file| read_file(directory, manifest, file, sink)).transpose()?;
    let values = values.map(|file| read_values(directory, manifest, file, sink)).transpose()?;
    Ok(Files { regions, certificate, values })
}

fn read_values(
    directory: &Path,
    manifest: &Manifest,
    file: &manifest::ValuesFile,
    sink: &dyn ProgressSink,
) -> Result<Vec<Row>> {
    let path = directory.join(manifest::VALUES);
    let name = path.display().to_string();
    let layout = manifest.values_layout().unwrap_or_default();
    let rows = read_hashed(&path, &file.sha256, sink, |input| bounds::read(&name, &layout, input))?;
    ensure(rows.len() == file.rows, || {
        let message = format!("the file has {} rows, the manifest says {}", rows.len(), file.rows);
        Error::Dump { file: name.clone(), line: 0, message }
    })?;
    Ok(rows)
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
    let diagram = read_hashed(&path, &file.sha256, sink, |input| dddmp::read(&name, input))?;
    manifest.check_file(&manifest_name, file, &diagram)?;
    Ok(diagram)
}

/// Reads a file, and checks the SHA-256 of its bytes.
fn read_hashed<T>(
    path: &Path,
    sha256: &str,
    sink: &dyn ProgressSink,
    read: impl FnOnce(&mut BufReader<Hashing<Watched<'_, File>>>) -> Result<T>,
) -> Result<T> {
    let name = path.display().to_string();
    let failed = |e: io::Error| Error::Io { path: name.clone(), message: e.to_string() };
    let inner = Watched { inner: regular(path).map_err(failed)?, sink };
    let mut input = BufReader::with_capacity(1 << 16, Hashing { inner, hash: Sha256::new() });
    let content = read(&mut input).map_err(|e| sink.stop().map_or(e, Error::from))?;
    let found = hex(&input.into_inner().hash.finalize());
    if found == sha256 {
        return Ok(content);
    }
    let message = format!("the file has changed: its SHA-256 is {found}, the manifest says {sha256}");
    Err(Error::Dump { file: name, line: 0, message })
}
