//! S-expressions with places: the outer form of PDDL.

use std::ops::Range;
use std::sync::Arc;

use super::Parts;
use meliora_base::error::{Diagnostic, Error, Result, SourceFile};
use meliora_base::escape;
use meliora_base::progress::{Poll, ProgressSink};
use meliora_base::stack;

/// A part of a text: a word, or a list in brackets.
#[derive(Debug, Clone)]
pub(crate) struct Node {
    /// The text that it stands in.
    pub(crate) source: Arc<SourceFile>,
    /// Its place.
    pub(crate) span: Range<usize>,
    pub(crate) kind: Kind,
}

/// The kinds of parts.
#[derive(Debug, Clone)]
pub(crate) enum Kind {
    /// A word, in small letters: PDDL does not distinguish them from capitals.
    Word(String),
    /// `( … )`
    List(Vec<Node>),
}

impl Node {
    /// Returns the word, in small letters; `None` for a list.
    pub(crate) fn word(&self) -> Option<&str> {
        match &self.kind {
            Kind::Word(word) => Some(word),
            Kind::List(_) => None,
        }
    }

    /// Returns the parts of a list; `None` for a word.
    pub(crate) fn list(&self) -> Option<&[Node]> {
        match &self.kind {
            Kind::Word(_) => None,
            Kind::List(parts) => Some(parts),
        }
    }

    /// Returns the first word of a list and the parts after it.
    pub(crate) fn form(&self) -> Option<(&str, &[Node])> {
        let (first, rest) = self.list()?.split_first()?;
        Some((first.word()?, rest))
    }

    /// Returns the text as it is written.
    pub(crate) fn text(&self) -> &str {
        self.source.text.get(self.span.clone()).unwrap_or_default()
    }

    /// Returns an error that points here.
    pub(crate) fn wrong(&self, message: impl Into<String>) -> Diagnostic {
        Diagnostic::new(&self.source, self.span.clone(), message)
    }

    /// Returns an error for another form than the expected one.
    pub(crate) fn expected(&self, what: &str) -> Diagnostic {
        let found = match &self.kind {
            Kind::Word(_) => format!("`{}`", escape::shortened(self.text())),
            Kind::List(parts) => match parts.first().and_then(Node::word) {
                Some(first) => format!("`({} …)`", escape::shortened(first)),
                None => "a list".to_owned(),
            },
        };
        self.wrong(format!("expected {what}, found {found}")).label(format!("expected {what}"))
    }
}

/// Returns whether a text is a planning problem: its first word is `(define`.
pub(crate) fn is_pddl(text: &str) -> bool {
    let mut rest = text.trim_start();
    while let Some(comment) = rest.strip_prefix(';') {
        rest = comment.split_once('\n').map_or("", |(_, rest)| rest).trim_start();
    }
    let word = rest.strip_prefix('(').map(str::trim_start).and_then(|rest| rest.get(..6));
    word.is_some_and(|word| word.eq_ignore_ascii_case("define"))
}

/// Returns the parts that begin in a text: `(define (domain` and `(define (problem`.
pub(crate) fn parts(text: &str) -> Parts {
    let mut parts = Parts::default();
    let code = text.lines().map(|line| line.split(';').next().unwrap_or_default().to_lowercase());
    let spaced = code.map(|line| line.replace('(', " ( ").replace(')', " ) ")).collect::<Vec<_>>();
    let words: Vec<&str> = spaced.iter().flat_map(|line| line.split_whitespace()).collect();
    for window in words.windows(4) {
        parts.domain |= window == ["(", "define", "(", "domain"];
        parts.problem |= window == ["(", "define", "(", "problem"];
    }
    parts
}

/// Parses the lists of a text.
///
/// # Errors
/// A bracket without its partner, or a word outside of brackets.
pub(crate) fn parse(source: &Arc<SourceFile>, sink: &dyn ProgressSink) -> Result<Vec<Node>> {
    let mut reader = BracketReader { source, at: 0, poll: Poll::new(sink) };
    let mut all = Vec::new();
    while let Some(start) = reader.next() {
        if !source.text[start..].starts_with(['(', ')']) {
            let span = reader.word_end(start);
            let wrong = Diagnostic::new(source, span, "expected `(define …)`");
            return Err(wrong.label("this stands outside of brackets").into());
        }
        all.push(reader.node(start)?);
    }
    Ok(all)
}

struct BracketReader<'s> {
    source: &'s Arc<SourceFile>,
    at: usize,
    poll: Poll<'s>,
}

impl BracketReader<'_> {
    /// Skips spaces and comments. Returns the place of what follows; `None` at the end.
    fn next(&mut self) -> Option<usize> {
        loop {
            let rest = &self.source.text[self.at..];
            let space = rest.len() - rest.trim_start().len();
            self.at += space;
            let rest = &rest[space..];
            if !rest.starts_with(';') {
                return (!rest.is_empty()).then_some(self.at);
            }
            self.at += rest.find('\n').unwrap_or(rest.len());
        }
    }

    fn word_end(&self, start: usize) -> Range<usize> {
        let rest = &self.source.text[start..];
        // `?x -place` is read as `?x - place`: no name begins with `-`.
        if rest.strip_prefix('-').is_some_and(|rest| rest.starts_with(|c: char| c.is_alphabetic())) {
            return start..start + 1;
        }
        let ends = |c: char| c.is_whitespace() || matches!(c, '(' | ')' | ';');
        start..start + rest.find(ends).unwrap_or(rest.len()).max(1)
    }

    fn node(&mut self, start: usize) -> Result<Node> {
        self.poll.step()?;
        let source = Arc::clone(self.source);
        let rest = &source.text[start..];
        if rest.starts_with(')') {
            let wrong = Diagnostic::new(&source, start..start + 1, "this bracket closes nothing");
            return Err(wrong.help("remove it, or open a bracket before it").into());
        }
        if rest.starts_with('(') {
            self.at = start + 1;
            return stack::level(|| self.list(start));
        }
        let span = self.word_end(start);
        self.at = span.end;
        let kind = Kind::Word(source.text[span.clone()].to_lowercase());
        Ok(Node { source, span, kind })
    }

    fn list(&mut self, start: usize) -> Result<Node> {
        let mut parts = Vec::new();
        while let Some(next) = self.next() {
            if self.source.text[next..].starts_with(')') {
                self.at = next + 1;
                let source = Arc::clone(self.source);
                return Ok(Node { source, span: start..self.at, kind: Kind::List(parts) });
            }
            parts.push(self.node(next)?);
        }
        let wrong = Diagnostic::new(self.source, start..start + 1, "this bracket is not closed");
        Err(Error::from(wrong.label("opened here").help("add `)` where the list ends")))
    }
}

/// The errors and notes of a text that is being checked.
#[derive(Default)]
pub(crate) struct Faults {
    pub(crate) errors: Vec<Diagnostic>,
    pub(crate) notes: Vec<Diagnostic>,
}

/// Maximum number of errors that are reported.
const MAX_ERRORS: usize = 20;

impl Faults {
    /// Records an error; the caller continues without the wrong part. A type may be wrong for several names: each error
    /// of a place is recorded once.
    pub(crate) fn report<T>(&mut self, wrong: Diagnostic) -> Option<T> {
        let is_same = |known: &Diagnostic| {
            known.span == wrong.span
                && known.message == wrong.message
                && Arc::ptr_eq(&known.source, &wrong.source)
        };
        if self.errors.len() < MAX_ERRORS && !self.errors.iter().any(is_same) {
            self.errors.push(wrong);
        }
        None
    }
}
