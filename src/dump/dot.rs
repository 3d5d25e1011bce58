//! Pictures of regions: one DOT file each.

use std::collections::BTreeMap;
use std::io::{self, BufReader, BufWriter, Read, Write};
use std::path::Path;

use super::streams::Watched;
use super::{Diagram, Edge, manifest};
use meliora_base::escape;
use meliora_base::files::{NewDirectory, is_regular};
use meliora_base::progress::ProgressSink;
use meliora_base::reading::regular;

/// Writes one file per root into the directory, and records the names.
///
/// # Errors
/// The directory cannot be written; the work is cancelled.
pub(super) fn write_all(
    file: &mut manifest::File,
    diagram: &Diagram,
    directory: &NewDirectory,
    sink: &dyn ProgressSink,
) -> io::Result<()> {
    let mut taken = BTreeMap::new();
    for root in &mut file.roots {
        let name = file_name(&root.name, &mut taken);
        let inner = directory.create(&name)?;
        let mut out = BufWriter::new(Watched { inner, sink });
        write(diagram, root.node, &root.name, &mut out)?;
        out.flush()?;
        root.dot = Some(name);
    }
    Ok(())
}

/// Returns the first root whose DOT file is missing or differs from the output of `write_all`.
/// Only roots for which the manifest names a file are checked.
///
/// # Errors
/// The work is cancelled.
pub fn false_picture<'f>(
    file: &'f manifest::File,
    diagram: &Diagram,
    directory: &Path,
    sink: &dyn ProgressSink,
) -> io::Result<Option<&'f str>> {
    let mut taken = BTreeMap::new();
    for root in &file.roots {
        let name = file_name(&root.name, &mut taken);
        let Some(said) = &root.dot else { continue };
        if *said != name || !is_picture(root, diagram, &directory.join(name), sink)? {
            return Ok(Some(&root.name));
        }
    }
    Ok(None)
}

/// Returns the names of the files in a directory that `write_all` writes for roots of a manifest.
///
/// # Errors
/// The work is cancelled.
pub(super) fn pictures(
    file: &manifest::File,
    diagram: &Diagram,
    directory: &Path,
    sink: &dyn ProgressSink,
) -> io::Result<Vec<String>> {
    let (mut taken, mut found) = (BTreeMap::new(), Vec::new());
    for root in &file.roots {
        let name = file_name(&root.name, &mut taken);
        let is_named = root.dot.as_ref() == Some(&name) && is_regular(&directory.join(&name));
        if is_named && is_picture(root, diagram, &directory.join(&name), sink)? {
            found.push(name);
        }
    }
    Ok(found)
}

/// Returns whether a file contains the picture of a root.
fn is_picture(
    root: &manifest::Root,
    diagram: &Diagram,
    path: &Path,
    sink: &dyn ProgressSink,
) -> io::Result<bool> {
    let input = regular(path).ok();
    let mut same = Comparing { input: input.map(BufReader::new), differs: false };
    let mut out = BufWriter::new(Watched { inner: &mut same, sink });
    write(diagram, root.node, &root.name, &mut out)?;
    out.flush()?;
    drop(out);
    Ok(same.is_equal())
}

/// A writer that compares its input with a file.
struct Comparing<R> {
    input: Option<R>,
    differs: bool,
}

impl<R: Read> Comparing<R> {
    /// Returns true if the input and the file are equal, including their lengths.
    fn is_equal(&mut self) -> bool {
        let ended = self.input.as_mut().is_some_and(|input| matches!(input.read(&mut [0]), Ok(0)));
        ended && !self.differs
    }
}

impl<R: Read> Write for Comparing<R> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let mut there = vec![0; bytes.len()];
        let read = self.input.as_mut().map(|input| input.read_exact(&mut there));
        self.differs |= !matches!(read, Some(Ok(()))) || there != bytes;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Returns a distinct name that is valid on every file system: `almost-sure_A.dot`.
///
/// `taken` has the names so far, in lower case and without the ending, each with a number such that
/// all smaller copies of the name are taken.
fn file_name(region: &str, taken: &mut BTreeMap<String, usize>) -> String {
    let safe = |c: char| if c.is_ascii_alphanumeric() || c == '-' || c == '+' { c } else { '_' };
    let stem: String = region.chars().map(safe).take(100).collect();
    // Case is ignored, as some file systems do.
    let key = stem.to_lowercase();
    let Some(mut copy) = taken.get(&key).copied() else {
        taken.insert(key, 2);
        return format!("{stem}.dot");
    };
    while taken.contains_key(&format!("{key}-{copy}")) {
        copy += 1;
    }
    taken.insert(format!("{key}-{copy}"), 2);
    taken.insert(key, copy + 1);
    format!("{stem}-{copy}.dot")
}

/// Writes one function: solid then arcs, dashed else arcs, a dot at the end of complemented arcs.
///
/// # Errors
/// Writing to `out` fails.
pub fn write(diagram: &Diagram, root: Edge, title: &str, out: &mut impl Write) -> io::Result<()> {
    writeln!(out, "digraph {} {{", escape::dot(title))?;
    writeln!(out, "  node [shape=circle];")?;
    writeln!(out, "  root [label={}, shape=plaintext];", escape::dot(title))?;
    writeln!(out, "  n1 [label=\"1\", shape=box];")?;
    arc(out, "root", root, "solid")?;
    let seen = diagram.below(&[root]);
    for (index, node) in diagram.nodes.iter().enumerate().filter(|(index, _)| seen[*index]) {
        let name = format!("n{}", index + 2);
        let label = diagram.variables.get(node.level as usize).map_or("?", String::as_str);
        writeln!(out, "  {name} [label={}];", escape::dot(label))?;
        arc(out, &name, node.then, "solid")?;
        arc(out, &name, node.otherwise, "dashed")?;
    }
    writeln!(out, "}}")
}

fn arc(out: &mut impl Write, from: &str, to: Edge, style: &str) -> io::Result<()> {
    let end = if to.is_complemented() { ", arrowhead=dot" } else { "" };
    writeln!(out, "  {from} -> n{} [style={style}{end}];", to.id())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_a_file_system_cannot_tell_apart_are_numbered() {
        let mut taken = BTreeMap::new();
        let mut name = |region: &str| file_name(region, &mut taken);
        assert_eq!(name("almost-sure:A"), "almost-sure_A.dot");
        assert_eq!(name("almost-sure:a"), "almost-sure_a-2.dot");
        assert_eq!(name("almost-sure@A-2"), "almost-sure_A-2-2.dot");
        assert_eq!(name("almost-sure|A"), "almost-sure_A-3.dot");
        // Looking for a free number from 2 on would take a minute here.
        let long = "x".repeat(120);
        let names = (0..100_000).map(|number| name(&format!("{long}{number}")));
        assert_eq!(names.last(), Some(format!("{}-100000.dot", &long[..100])));
    }
}
