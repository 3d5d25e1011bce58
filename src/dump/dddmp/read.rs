//! The reader of DDDMP files, which checks every line.

use std::io::BufRead;

use super::lines::{Lines, number, shown};
use crate::{Diagram, Edge, Node};
use meliora_base::error::Result;
use meliora_base::escape::unword;

/// The maximum number of variables; models of this program have fewer.
const MOST_VARIABLES: usize = 1 << 24;

/// Reads a diagram, as written by [`super::write`]; messages call the file `file`.
///
/// Arcs point only to earlier lines and deeper variables, so there are no cycles. Nodes are
/// reduced. Memory is allocated as lines are read, not by the numbers in the header.
///
/// # Errors
/// [`meliora_base::error::Error::Dump`] with the line, if the file is malformed or truncated.
/// [`meliora_base::error::Error::Io`] if reading fails.
pub fn read<R: BufRead>(file: &str, input: R) -> Result<Diagram> {
    let mut lines = Lines::new(file, input);
    let header = Header::read(&mut lines)?;
    let mut diagram = Diagram { variables: header.variables, nodes: Vec::new(), roots: Vec::new() };
    lines.expect("the terminal `1 T 1 0 0`")?;
    lines.ensure(lines.words().eq(super::TERMINAL.split(|&b| b == b' ')), || {
        format!("expected the terminal `1 T 1 0 0`, found `{}`", shown(lines.line()))
    })?;
    for id in 2..=header.nodes {
        lines.expect(&format!("node {id} of {}", header.nodes))?;
        let node = node(&lines, &diagram, id)?;
        diagram.nodes.push(node);
    }
    lines.expect("`.end`")?;
    lines.ensure(lines.words().eq([super::END]), || {
        format!("found `{}` instead of `.end` after {} nodes", shown(lines.line()), header.nodes)
    })?;
    while lines.advance()? {
        lines.ensure(lines.words().next().is_none(), || "text after `.end`".to_owned())?;
    }
    diagram.roots = header.roots;
    Ok(diagram)
}

/// Reads and checks one line with a node.
fn node<R: BufRead>(lines: &Lines<'_, R>, diagram: &Diagram, id: i64) -> Result<Node> {
    lines.ensure(lines.words().ne([super::END]), || {
        format!("the nodes end before node {id}, but `.nnodes` says more")
    })?;
    let mut words = lines.words();
    let mut column = || {
        let line =
            || lines.wrong(format!("node {id}: expected five numbers, found `{}`", shown(lines.line())));
        let word = words.next().ok_or_else(line)?;
        number(word).ok_or_else(|| {
            lines.wrong(format!("node {id}: `{}` is not the number of a node or variable", shown(word)))
        })
    };
    let [own, variable, index, then, otherwise] = [column()?, column()?, column()?, column()?, column()?];
    lines.ensure(words.next().is_none(), || format!("node {id}: more than five columns"))?;
    lines.ensure(own == id, || format!("expected node {id}, found node {own}"))?;
    let level = level(lines, diagram, variable, index)?;
    let node = Node { level, then: arc(lines, id, then)?, otherwise: arc(lines, id, otherwise)? };
    lines.ensure(!node.then.is_complemented(), || format!("node {id}: a complemented then arc ({then})"))?;
    lines.ensure(node.then != node.otherwise, || {
        format!("node {id}: both arcs are {then}; a reduced diagram has no such node")
    })?;
    for child in [node.then, node.otherwise] {
        lines.ensure(diagram.level(child) > level, || {
            format!("node {id}: the arc {} leads to a variable that is not deeper", child.number())
        })?;
    }
    Ok(node)
}

fn level<R: BufRead>(lines: &Lines<'_, R>, diagram: &Diagram, variable: i64, index: i64) -> Result<u32> {
    let width = diagram.variables.len();
    let unknown = || lines.wrong(format!("unknown variable {variable}: the file has {width} variables"));
    let level = u32::try_from(variable).ok().filter(|&level| (level as usize) < width).ok_or_else(unknown)?;
    lines.ensure(variable == index, || {
        format!("variable {variable} has the index {index}; both are the same in this format")
    })?;
    Ok(level)
}

/// Checks an arc of node `id`, which must point to a node of an earlier line.
fn arc<R: BufRead>(lines: &Lines<'_, R>, id: i64, to: i64) -> Result<Edge> {
    match Edge::new(to) {
        Some(edge) if (edge.id() as i64) < id => Ok(edge),
        _ => Err(lines.wrong(format!("node {id}: the arc {to} does not lead to a node of an earlier line"))),
    }
}

/// The lines before the nodes.
#[derive(Default)]
struct Header {
    nodes: i64,
    variables: Vec<String>,
    /// The names in `.suppvarnames`, if present.
    support: Option<Vec<String>>,
    roots: Vec<Edge>,
    seen: Vec<String>,
    width: Option<usize>,
    root_count: Option<usize>,
    /// The lengths of `.ids` and `.permids`.
    listed: Vec<usize>,
}

/// The required keys.
const REQUIRED: [&str; 9] =
    [".ver", ".mode", ".varinfo", ".nnodes", ".nvars", ".orderedvarnames", ".ids", ".permids", ".rootids"];

impl Header {
    fn read<R: BufRead>(lines: &mut Lines<'_, R>) -> Result<Self> {
        let mut header = Header::default();
        loop {
            lines.expect("a header line or `.nodes`")?;
            if lines.words().eq([super::NODES]) {
                break;
            }
            header.line(lines)?;
        }
        if let Some(missing) = REQUIRED.iter().find(|k| !header.seen.iter().any(|s| s == *k)) {
            return Err(lines.wrong(format!("`{missing}` is missing before `.nodes`")));
        }
        header.consistent(lines)?;
        Ok(header)
    }

    fn line<R: BufRead>(&mut self, lines: &Lines<'_, R>) -> Result<()> {
        let mut words = lines.words();
        let Some(key) = words.next() else { return Ok(()) };
        let key = String::from_utf8_lossy(key).into_owned();
        lines.ensure(!self.seen.contains(&key), || format!("`{}` occurs twice", shown(key.as_bytes())))?;
        match key.as_str() {
            ".ver" => fixed(lines, &mut words, "DDDMP-2.0")?,
            ".mode" => fixed(lines, &mut words, "A")?,
            ".varinfo" => fixed(lines, &mut words, "0")?,
            ".nnodes" => self.nodes = count(lines, &mut words, i32::MAX as usize - 1)?.max(1) as i64,
            ".nvars" | ".nsuppvars" => self.variables_counted(lines, &mut words)?,
            ".orderedvarnames" => self.variables = names(lines, &mut words)?,
            ".suppvarnames" => self.support = Some(names(lines, &mut words)?),
            ".dd" => {}
            ".ids" | ".permids" => self.listed.push(identity(lines, &mut words)?),
            ".nroots" => self.root_count = Some(count(lines, &mut words, MOST_VARIABLES)?),
            ".rootids" => self.roots = roots(lines, &mut words)?,
            _ => lines.ensure(false, || {
                format!("`{}` is not a header line of this format", shown(key.as_bytes()))
            })?,
        }
        self.seen.push(key);
        Ok(())
    }

    fn variables_counted<'w, R: BufRead>(
        &mut self,
        lines: &Lines<'_, R>,
        words: &mut impl Iterator<Item = &'w [u8]>,
    ) -> Result<()> {
        let width = count(lines, words, MOST_VARIABLES)?;
        let is_same = self.width.replace(width).is_none_or(|w| w == width);
        lines.ensure(is_same, || "`.nvars` and `.nsuppvars` differ".to_owned())
    }

    fn consistent<R: BufRead>(&self, lines: &Lines<'_, R>) -> Result<()> {
        let (named, counted) = (self.variables.len(), self.width.unwrap_or_default());
        lines.ensure(named == counted, || {
            format!("`.nvars` is {counted}, but `.orderedvarnames` has {named} names")
        })?;
        lines.ensure(self.support.as_ref().is_none_or(|names| *names == self.variables), || {
            "`.suppvarnames` and `.orderedvarnames` differ".to_owned()
        })?;
        lines.ensure(self.listed.iter().all(|&n| n == counted), || {
            format!("`.ids` and `.permids` do not list the {counted} variables")
        })?;
        let roots = self.roots.len();
        lines.ensure(self.root_count.is_none_or(|n| n == roots), || {
            format!("`.rootids` has {roots} numbers, but `.nroots` says otherwise")
        })?;
        self.roots.iter().try_for_each(|root| {
            let is_node = root.id() as i64 <= self.nodes;
            lines.ensure(is_node, || format!("the root {} is not a node of the file", root.number()))
        })
    }
}

type Words<'a, 'w> = &'a mut dyn Iterator<Item = &'w [u8]>;

fn fixed<R: BufRead>(lines: &Lines<'_, R>, words: Words<'_, '_>, value: &str) -> Result<()> {
    lines.ensure(words.eq([value.as_bytes()]), || {
        format!("`{}`: only `{value}` is supported here", shown(lines.line()))
    })
}

fn count<R: BufRead>(lines: &Lines<'_, R>, words: Words<'_, '_>, most: usize) -> Result<usize> {
    let value = words.next().and_then(number).and_then(|n| usize::try_from(n).ok());
    match value {
        Some(n) if n <= most && words.next().is_none() => Ok(n),
        _ => Err(lines.wrong(format!("expected a number up to {most}, found `{}`", shown(lines.line())))),
    }
}

fn names<R: BufRead>(lines: &Lines<'_, R>, words: Words<'_, '_>) -> Result<Vec<String>> {
    let mut names = Vec::new();
    for word in words {
        let Ok(name) = std::str::from_utf8(word) else {
            return Err(lines.wrong(format!("`{}` is not the name of a variable", shown(word))));
        };
        names.push(unword(name).into_owned());
    }
    let mut sorted: Vec<&String> = names.iter().collect();
    sorted.sort_unstable();
    match sorted.windows(2).find(|pair| pair[0] == pair[1]) {
        Some(pair) => Err(lines.wrong(format!("the variable `{}` occurs twice", shown(pair[0].as_bytes())))),
        None => Ok(names),
    }
}

/// Reads `.ids` or `.permids`, which must be 0, 1, 2, …: variables are numbered in their order.
/// Returns their number.
fn identity<R: BufRead>(lines: &Lines<'_, R>, words: Words<'_, '_>) -> Result<usize> {
    let mut listed = 0;
    for (expected, word) in words.enumerate() {
        lines.ensure(number(word) == Some(expected as i64), || {
            format!("found `{}` instead of {expected}: variables are numbered in order", shown(word))
        })?;
        listed += 1;
    }
    Ok(listed)
}

fn roots<R: BufRead>(lines: &Lines<'_, R>, words: Words<'_, '_>) -> Result<Vec<Edge>> {
    let root = |word: &[u8]| {
        let edge = number(word).and_then(Edge::new);
        edge.ok_or_else(|| lines.wrong(format!("`{}` is not the number of a node", shown(word))))
    };
    words.map(root).collect()
}
