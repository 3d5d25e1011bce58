//! Region expressions such as `sasi:1 & !(sasi:2 | class:nothing)`.

use std::ops::Range;
use std::sync::Arc;

use meliora_base::error::{Diagnostic, Result, SourceFile};
use meliora_base::slip;
use meliora_model::region::RegionName;

/// The maximum nesting depth; the recursive parser uses stack for each level.
const DEEPEST: usize = 500;

/// A region expression, with names by index. Chains of one operator are flat, so the height of an
/// expression is bounded by the depth of its brackets.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Region {
    Name(usize),
    Not(Box<Region>),
    And(Vec<Region>),
    Or(Vec<Region>),
}

/// Parses an expression over the given names. `!` binds tightest, then `&`, then `|`. `levels_end`
/// is true if the dump has all levels; then a name past the last level stands for the fixpoint.
pub(super) fn parse(source: &Arc<SourceFile>, names: &[&str], levels_end: bool) -> Result<Region> {
    let mut parser = Parser { source, names, levels_end, at: 0, depth: 0 };
    let region = parser.or()?;
    parser.space();
    match parser.peek() {
        None => Ok(region),
        Some(_) => Err(parser.no_operator().into()),
    }
}

/// A summary of the syntax for messages.
const JOINED: &str = "regions are joined by `&` (both), `|` (either) and `!` (not)";

struct Parser<'a> {
    source: &'a Arc<SourceFile>,
    names: &'a [&'a str],
    levels_end: bool,
    at: usize,
    depth: usize,
}

impl Parser<'_> {
    fn or(&mut self) -> Result<Region> {
        let mut row = vec![self.and()?];
        while self.eat('|') {
            row.push(self.and()?);
        }
        Ok(if row.len() == 1 { row.swap_remove(0) } else { Region::Or(row) })
    }

    fn and(&mut self) -> Result<Region> {
        let mut row = vec![self.not()?];
        while self.eat('&') {
            row.push(self.not()?);
        }
        Ok(if row.len() == 1 { row.swap_remove(0) } else { Region::And(row) })
    }

    fn not(&mut self) -> Result<Region> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(self.wrong(self.rest(), format!("more than {DEEPEST} levels of brackets")).into());
        }
        let region = if self.eat('!') {
            Region::Not(Box::new(self.not()?))
        } else if self.eat('(') {
            let inner = self.or()?;
            if !self.eat(')') {
                return Err(self.wrong(self.rest(), "a bracket is not closed").label("expected `)`").into());
            }
            inner
        } else {
            self.name()?
        };
        self.depth -= 1;
        Ok(region)
    }

    fn name(&mut self) -> Result<Region> {
        self.space();
        let text = &self.source.text[self.at..];
        let end = text.find(|c: char| c.is_whitespace() || "&|!()".contains(c)).unwrap_or(text.len());
        let (name, span) = (&text[..end], self.at..self.at + end);
        if name.is_empty() {
            let diagnostic = self.wrong(self.rest(), "expected the name of a region");
            return Err(diagnostic.label("such as `sasi:1`").help(JOINED).into());
        }
        self.at += end;
        let position = |wanted: &str| self.names.iter().position(|n| *n == wanted);
        match position(name).or_else(|| position(&self.beyond(name)?)) {
            Some(position) => Ok(Region::Name(position)),
            None => Err(self.unknown(name, span).into()),
        }
    }

    /// Reports an unexpected token where `&`, `|` or the end was expected.
    fn no_operator(&self) -> Diagnostic {
        let help = match self.peek() {
            Some('-' | '\\') => "`a & !b` contains the members of `a` that are not in `b`",
            Some(')') => "this bracket was not opened",
            _ => JOINED,
        };
        self.wrong(self.rest(), "the expression ends before this").label("expected `&` or `|`").help(help)
    }

    /// Returns the name that stands for a level past the last one: the fixpoint, which is often
    /// empty. Only if the dump has all levels.
    fn beyond(&self, name: &str) -> Option<String> {
        RegionName::from(name).unbounded().map(|name| name.to_string()).filter(|_| self.levels_end)
    }

    fn unknown(&self, name: &str, span: Range<usize>) -> Diagnostic {
        let help = match slip::meant(self.names.iter().map(AsRef::as_ref), name) {
            Some(meant) => format!("did you mean `{meant}`?"),
            None => format!("the dump has {}", self.names.join(", ")),
        };
        self.wrong(span, format!("unknown region `{name}`")).help(help)
    }

    fn eat(&mut self, token: char) -> bool {
        self.space();
        let found = self.peek() == Some(token);
        if found {
            self.at += token.len_utf8();
        }
        found
    }

    fn space(&mut self) {
        let rest = &self.source.text[self.at..];
        self.at += rest.len() - rest.trim_start().len();
    }

    fn peek(&self) -> Option<char> {
        self.source.text[self.at..].chars().next()
    }

    /// Returns the range from here to the end.
    fn rest(&self) -> Range<usize> {
        self.at..self.source.text.len()
    }

    fn wrong(&self, span: Range<usize>, message: impl Into<String>) -> Diagnostic {
        Diagnostic::new(self.source, span, message)
    }
}
