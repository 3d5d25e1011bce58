//! The writer of DDDMP files.

use std::io::{self, Write};

use crate::Diagram;
use meliora_base::escape;

/// Writes a diagram node by node, without a buffer of its own.
///
/// # Errors
/// Writing to `out` fails.
pub fn write(diagram: &Diagram, out: &mut impl Write) -> io::Result<()> {
    header(diagram, out)?;
    out.write_all(super::NODES)?;
    out.write_all(b"\n")?;
    out.write_all(super::TERMINAL)?;
    out.write_all(b"\n")?;
    for (index, node) in diagram.nodes.iter().enumerate() {
        let (level, then, otherwise) = (node.level, node.then.number(), node.otherwise.number());
        writeln!(out, "{} {level} {level} {then} {otherwise}", index + 2)?;
    }
    out.write_all(super::END)?;
    out.write_all(b"\n")
}

fn header(diagram: &Diagram, out: &mut impl Write) -> io::Result<()> {
    let width = diagram.variables.len();
    writeln!(out, ".ver DDDMP-2.0")?;
    writeln!(out, ".mode A")?;
    writeln!(out, ".varinfo 0")?;
    writeln!(out, ".dd meliora")?;
    writeln!(out, ".nnodes {}", diagram.nodes.len() + 1)?;
    writeln!(out, ".nvars {width}")?;
    writeln!(out, ".nsuppvars {width}")?;
    let names = || diagram.variables.iter().map(|name| escape::word(name));
    list(out, ".suppvarnames", names())?;
    list(out, ".orderedvarnames", names())?;
    list(out, ".ids", 0..width)?;
    list(out, ".permids", 0..width)?;
    writeln!(out, ".nroots {}", diagram.roots.len())?;
    list(out, ".rootids", diagram.roots.iter().map(|r| r.number()))
}

fn list(
    out: &mut impl Write,
    key: &str,
    items: impl Iterator<Item = impl std::fmt::Display>,
) -> io::Result<()> {
    write!(out, "{key}")?;
    for item in items {
        write!(out, " {item}")?;
    }
    writeln!(out)
}
