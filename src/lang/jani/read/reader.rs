//! Tools of the reader: objects with checked keys, and a list of errors.

use super::property::Reward;
use std::sync::Arc;

use ahash::AHashSet;

use super::super::json::{Document, Malformed, Node, Object, Shape};
use crate::ast::{Ident, Span};
use meliora_base::error::{Diagnostic, Error, Result, Severity, SourceFile};
use meliora_base::progress::{Poll, ProgressSink};

/// Maximum number of errors reported.
const MAX_ERRORS: usize = 20;
/// Maximum size of a document in bytes.
const MOST_BYTES: usize = 64 << 20;
/// Maximum number of values of a document.
const MOST_VALUES: usize = 1 << 24;

/// Returns the document of a text.
///
/// # Errors
/// The text is too large, or is not JSON.
pub(crate) fn document(source: &Arc<SourceFile>) -> Result<Document<'_>> {
    let wrong = |Malformed { at, message }| {
        let diagnostic = Diagnostic::new(source, at.range(), message);
        let rest = source.text.get(at.start()..).unwrap_or_default();
        let is_comment = ["//", "/*", "#"].iter().any(|begin| rest.starts_with(begin));
        let help = "JSON has no comments: remove this one, or make it the value of a key `\"comment\"`";
        if is_comment { diagnostic.help(help).into() } else { diagnostic.into() }
    };
    if source.text.len() > MOST_BYTES {
        let message = format!("the document is larger than {} MiB", MOST_BYTES >> 20);
        return Err(wrong(Malformed { at: Span::new(0, 1), message }));
    }
    Document::parse(&source.text).map_err(wrong)
}

pub(crate) struct Reader<'a> {
    source: &'a Arc<SourceFile>,
    diagnostics: Vec<Diagnostic>,
    poll: Poll<'a>,
    values: usize,
    /// True if the document was found to be too large, which has been reported.
    is_full: bool,
    /// The rewards of the property that is read, if operators of properties may stand in expressions.
    pub(super) rewards: Option<Vec<Reward>>,
}

impl<'a> Reader<'a> {
    pub(crate) fn new(source: &'a Arc<SourceFile>, sink: &'a dyn ProgressSink) -> Self {
        Reader {
            source,
            diagnostics: Vec::new(),
            poll: Poll::new(sink),
            values: 0,
            is_full: false,
            rewards: None,
        }
    }

    /// Returns the result, unless there were errors.
    ///
    /// # Errors
    /// The recorded errors; a limit.
    pub(crate) fn finish<T>(self, read: Option<T>) -> Result<T> {
        self.poll.check()?;
        match read {
            Some(read) if self.diagnostics.is_empty() => Ok(read),
            _ => Err(Error::Input(self.diagnostics)),
        }
    }

    /// Returns the number of errors so far.
    pub(crate) fn told(&self) -> usize {
        self.diagnostics.len()
    }

    /// Takes back the errors after the first `told`, and returns the first of them; `None` if there is
    /// none, or if reading had to stop.
    pub(crate) fn take_back(&mut self, told: usize) -> Option<Diagnostic> {
        if self.is_full || self.poll.should_stop() {
            return None;
        }
        self.diagnostics.split_off(told).into_iter().next()
    }

    pub(crate) fn wrong(&self, span: Span, message: impl Into<String>) -> Diagnostic {
        Diagnostic::new(self.source, span.range(), message)
    }

    pub(crate) fn report(&mut self, diagnostic: Diagnostic) {
        if self.diagnostics.len() < MAX_ERRORS {
            self.diagnostics.push(diagnostic);
        }
    }

    /// Reports an error and gives up the current value.
    pub(crate) fn fail<T>(&mut self, span: Span, message: impl Into<String>) -> Option<T> {
        let diagnostic = self.wrong(span, message);
        self.report(diagnostic);
        None
    }

    /// Returns the error for an unsupported construct.
    pub(crate) fn not_supported(&self, span: Span, message: impl Into<String>) -> Diagnostic {
        self.wrong(span, message).severity(Severity::Unsupported).label("not supported")
    }

    /// Refuses an unsupported construct by its name.
    pub(crate) fn unsupported<T>(&mut self, span: Span, message: impl Into<String>) -> Option<T> {
        let diagnostic = self.not_supported(span, message);
        self.report(diagnostic);
        None
    }

    fn malformed<T>(&mut self, Malformed { at, message }: Malformed) -> Option<T> {
        self.fail(at, message)
    }

    fn shape(&mut self, node: Node<'a>) -> Option<Shape<'a>> {
        self.values += 1;
        if self.poll.should_stop() || self.is_full {
            return None;
        }
        if self.values > MOST_VALUES {
            self.is_full = true;
            let here = Span::new(node.span().start(), node.span().start() + 1);
            return self.fail(here, format!("the document has more than {MOST_VALUES} values"));
        }
        match node.shape() {
            Ok(shape) => {
                if let Shape::Object(object) = &shape {
                    self.distinct(object)?;
                }
                Some(shape)
            }
            Err(malformed) => self.malformed(malformed),
        }
    }

    fn expected<T>(&mut self, node: Node<'a>, wanted: &str, found: &Shape<'_>) -> Option<T> {
        let label = match found {
            Shape::Null => "this is `null`",
            Shape::Bool(_) => "this is a truth value",
            Shape::Number(_) => "this is a number",
            Shape::Text(_) => "this is a string",
            Shape::Array(_) => "this is an array",
            Shape::Object(_) => "this is an object",
        };
        let diagnostic = self.wrong(brief(node.span()), format!("expected {wanted}")).label(label);
        self.report(diagnostic);
        None
    }

    /// Returns the form of a value other than an array or `null`.
    pub(crate) fn any(&mut self, node: Node<'a>) -> Option<Shape<'a>> {
        match self.shape(node)? {
            found @ (Shape::Null | Shape::Array(_)) => {
                self.expected(node, "a literal, a name or an object", &found)
            }
            found => Some(found),
        }
    }

    /// Reads an object that may have the given keys, `comment`, and keys that start with `x-`. The
    /// keys in `refused` have their own messages.
    pub(crate) fn object(
        &mut self,
        node: Node<'a>,
        what: &str,
        keys: &[&str],
        refused: &[&str],
    ) -> Option<Object<'a>> {
        match self.shape(node)? {
            Shape::Object(object) => {
                self.unknown(&object, what, keys, refused)?;
                Some(object)
            }
            found => self.expected(node, &format!("{what}, an object"), &found),
        }
    }

    /// Refuses keys that occur twice.
    fn distinct(&mut self, object: &Object<'a>) -> Option<()> {
        let mut known: AHashSet<&str> = AHashSet::new();
        let mut keys = object.members.iter();
        let Some(member) = keys.find(|m| !known.insert(m.key.as_str())) else { return Some(()) };
        let message = format!("the key \"{}\" occurs twice in one object", member.key);
        let diagnostic = self.wrong(member.key_span, message).label("again");
        self.report(diagnostic.related(object.key_span(&member.key).range(), "the first one"));
        None
    }

    /// Refuses unknown keys, since a misspelt one would silently have no effect.
    pub(crate) fn known(&mut self, object: &Object<'a>, what: &str, keys: &[&str]) -> Option<()> {
        self.unknown(object, what, keys, &[])
    }

    fn unknown(&mut self, object: &Object<'a>, what: &str, keys: &[&str], refused: &[&str]) -> Option<()> {
        let mut good = Some(());
        for member in &object.members {
            let key = member.key.as_str();
            if key == "comment" || key.starts_with("x-") || keys.contains(&key) || refused.contains(&key) {
                continue;
            }
            let diagnostic = self.wrong(member.key_span, format!("unknown key \"{key}\" in {what}"));
            let known: Vec<_> = keys.iter().map(|k| format!("\"{k}\"")).collect();
            self.report(diagnostic.label("unknown").help(format!("its keys are {}", known.join(", "))));
            good = None;
        }
        good
    }

    /// Returns the value of a required key.
    pub(crate) fn required(&mut self, object: &Object<'a>, what: &str, key: &str) -> Option<Node<'a>> {
        match object.get(key) {
            Some(node) => Some(node),
            None => self.fail(object.start(), format!("{what} has no \"{key}\"")),
        }
    }

    pub(crate) fn array(&mut self, node: Node<'a>, what: &str) -> Option<Vec<Node<'a>>> {
        match self.shape(node)? {
            Shape::Array(items) => Some(items),
            found => self.expected(node, &format!("{what}, an array"), &found),
        }
    }

    /// Reads a string as a name with its place.
    pub(crate) fn name(&mut self, node: Node<'a>, what: &str) -> Option<Ident> {
        match self.shape(node)? {
            Shape::Text(name) => Some(Ident { name, span: node.span() }),
            found => self.expected(node, &format!("{what}, a string"), &found),
        }
    }

    pub(crate) fn truth(&mut self, node: Node<'a>, what: &str) -> Option<bool> {
        match self.shape(node)? {
            Shape::Bool(b) => Some(b),
            found => self.expected(node, &format!("{what}, `true` or `false`"), &found),
        }
    }

    pub(crate) fn whole(&mut self, node: Node<'a>, what: &str) -> Option<i64> {
        match self.shape(node)? {
            Shape::Number(text) if text.parse::<i64>().is_ok() => text.parse().ok(),
            found => self.expected(node, &format!("{what}, a whole number"), &found),
        }
    }

    /// Returns true if a value is `null`.
    pub(crate) fn is_null(&mut self, node: Node<'a>) -> bool {
        matches!(self.shape(node), Some(Shape::Null))
    }
}

/// Returns at most the first 40 bytes of a place: a whole automaton would not help.
fn brief(span: Span) -> Span {
    Span::new(span.start(), span.end().min(span.start() + 40))
}
