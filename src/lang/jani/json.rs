//! JSON values that know their place in the text.
//!
//! `serde_json` checks the syntax of the whole text. Its values have no places, so one more pass
//! records where each object and array ends. With that, objects and arrays are opened on demand,
//! one level at a time, and a document is read in linear time however deeply it is nested.

use std::ops::Range;

use serde::de::IgnoredAny;

use crate::ast::Span;

/// Maximum nesting of objects and arrays.
pub(super) const MOST_DEPTH: usize = 10_000;

/// Maximum number of objects and arrays.
const MOST_BRACKETS: usize = 1 << 24;

/// Maximum number of steps in the path to a value, for messages.
const MOST_STEPS: usize = 40;

/// A text whose syntax was checked.
pub(super) struct Document<'a> {
    text: &'a str,
    /// The first byte of the value; only a byte order mark and white space come before it.
    start: usize,
    /// The first byte of each object and array, ascending, and the byte after its last one.
    brackets: Vec<(u32, u32)>,
}

/// A value of a document.
#[derive(Clone, Copy)]
pub(super) struct Node<'a> {
    document: &'a Document<'a>,
    start: usize,
    end: usize,
}

/// The form of a value; objects and arrays are opened by one level.
pub(super) enum Shape<'a> {
    Null,
    Bool(bool),
    /// The number as written.
    Number(&'a str),
    Text(String),
    Array(Vec<Node<'a>>),
    Object(Object<'a>),
}

/// An object.
pub(super) struct Object<'a> {
    pub(super) span: Span,
    pub(super) members: Vec<Member<'a>>,
}

impl<'a> Object<'a> {
    /// Returns the value of a key.
    pub(super) fn get(&self, key: &str) -> Option<Node<'a>> {
        self.members.iter().find(|m| m.key == key).map(|m| m.value)
    }

    /// Returns the place of a key.
    pub(super) fn key_span(&self, key: &str) -> Span {
        self.members.iter().find(|m| m.key == key).map_or(self.span, |m| m.key_span)
    }

    /// Returns the place of the first character.
    pub(super) fn start(&self) -> Span {
        Span::new(self.span.start(), self.span.start() + 1)
    }
}

/// A member of an object.
pub(super) struct Member<'a> {
    pub(super) key: String,
    pub(super) key_span: Span,
    pub(super) value: Node<'a>,
}

/// The error of a text that is not a readable document, with its place.
pub(super) struct Malformed {
    pub(super) at: Span,
    pub(super) message: String,
}

impl<'a> Document<'a> {
    /// Checks the syntax of a text, and returns its document. A byte order mark is skipped.
    ///
    /// # Errors
    /// The text is not JSON, has more than [`MOST_BRACKETS`] objects and arrays, or they nest more
    /// than [`MOST_DEPTH`] levels deep.
    pub(super) fn parse(text: &'a str) -> Result<Self, Malformed> {
        let body = text.strip_prefix('\u{feff}').unwrap_or(text);
        let skipped = text.len() - body.len();
        if let Err(e) = serde_json::from_str::<IgnoredAny>(body) {
            let at = skipped + byte_of(body, e.line(), e.column());
            let message = format!("this is not JSON: {}", reason(&e));
            return Err(Malformed { at: Span::new(at, at + 1), message });
        }
        let start = skipped + (body.len() - body.trim_start_matches(is_space).len());
        Ok(Document { text, start, brackets: brackets(text)? })
    }

    /// Returns the value that the text contains.
    pub(super) fn root(&'a self) -> Node<'a> {
        self.value_at(self.start)
    }

    /// Returns the value that starts at a byte.
    fn value_at(&'a self, start: usize) -> Node<'a> {
        let end = match self.text.as_bytes()[start] {
            b'{' | b'[' => match self.brackets.binary_search_by_key(&start, |b| b.0 as usize) {
                Ok(index) => self.brackets[index].1 as usize,
                Err(_) => start + 1,
            },
            b'"' => end_of_string(self.text.as_bytes(), start),
            _ => self.text[start..]
                .find(|c| is_space(c) || ",:]}".contains(c))
                .map_or(self.text.len(), |n| start + n),
        };
        Node { document: self, start, end }
    }
}

/// Returns where the objects and arrays of a checked text start and end.
fn brackets(text: &str) -> Result<Vec<(u32, u32)>, Malformed> {
    let bytes = text.as_bytes();
    let too_many = |at: usize, most: usize, what: &str| {
        let message = format!("the document has more than {most} {what}");
        Malformed { at: Span::new(at, at + 1), message }
    };
    let (mut found, mut open, mut at) = (Vec::new(), Vec::new(), 0);
    while at < bytes.len() {
        match bytes[at] {
            b'{' | b'[' if open.len() == MOST_DEPTH => {
                return Err(too_many(at, MOST_DEPTH, "levels of objects and arrays"));
            }
            b'{' | b'[' if found.len() == MOST_BRACKETS => {
                return Err(too_many(at, MOST_BRACKETS, "objects and arrays"));
            }
            b'{' | b'[' => {
                open.push(found.len());
                found.push((at as u32, 0));
            }
            b'}' | b']' => {
                if let Some(index) = open.pop() {
                    found[index].1 = at as u32 + 1;
                }
            }
            b'"' => at = end_of_string(bytes, at) - 1,
            _ => {}
        }
        at += 1;
    }
    Ok(found)
}

/// Returns the byte after a string that starts at `start`.
fn end_of_string(bytes: &[u8], start: usize) -> usize {
    let mut at = start + 1;
    while at < bytes.len() && bytes[at] != b'"' {
        at += if bytes[at] == b'\\' { 2 } else { 1 };
    }
    at + 1
}

/// Returns true for the white space of JSON.
fn is_space(c: char) -> bool {
    matches!(c, ' ' | '\t' | '\n' | '\r')
}

impl<'a> Node<'a> {
    fn text(self) -> &'a str {
        &self.document.text[self.start..self.end]
    }

    /// Returns the place of the value.
    pub(super) fn span(self) -> Span {
        Span::new(self.start, self.end)
    }

    /// Returns the form of the value.
    ///
    /// # Errors
    /// The value cannot be opened, such as a string with a broken escape.
    pub(super) fn shape(self) -> Result<Shape<'a>, Malformed> {
        Ok(match self.text().as_bytes()[0] {
            b'{' => Shape::Object(self.object()?),
            b'[' => Shape::Array(self.inner()),
            b'"' => Shape::Text(self.string()?),
            b't' => Shape::Bool(true),
            b'f' => Shape::Bool(false),
            b'n' => Shape::Null,
            _ => Shape::Number(self.text()),
        })
    }

    fn object(self) -> Result<Object<'a>, Malformed> {
        let member = |pair: &[Node<'a>]| {
            Ok(Member { key: pair[0].string()?, key_span: pair[0].span(), value: pair[1] })
        };
        let members = self.inner().chunks_exact(2).map(member).collect::<Result<_, _>>()?;
        Ok(Object { span: self.span(), members })
    }

    fn string(self) -> Result<String, Malformed> {
        let malformed =
            |e| Malformed { at: self.span(), message: format!("this is not JSON: {}", reason(&e)) };
        serde_json::from_str(self.text()).map_err(malformed)
    }

    /// Returns the values inside an object or array; the keys of an object are values, too.
    fn inner(self) -> Vec<Node<'a>> {
        let (mut inner, mut at) = (Vec::new(), self.start + 1);
        loop {
            let rest = &self.document.text[at..self.end - 1];
            let Some(gap) = rest.find(|c| !is_space(c) && c != ',' && c != ':') else { return inner };
            let node = self.document.value_at(at + gap);
            at = node.end;
            inner.push(node);
        }
    }
}

/// Returns the byte offset of a place in a message of the parser; columns are bytes, counted from
/// 1.
fn byte_of(text: &str, line: usize, column: usize) -> usize {
    let before: usize = text.split_inclusive('\n').take(line.saturating_sub(1)).map(str::len).sum();
    (before + column.saturating_sub(1)).min(text.len())
}

/// Returns the message without the place at its end.
fn reason(error: &serde_json::Error) -> String {
    let text = error.to_string();
    text.rsplit_once(" at line ").map_or(text.as_str(), |(message, _)| message).to_owned()
}

/// Returns the place of the first string with this value, quotes included.
pub(super) fn string_at(text: &str, value: &str) -> Option<Range<usize>> {
    let mut at = 0;
    while let Some(start) = text[at..].find('"').map(|found| at + found) {
        let end = end_of_string(text.as_bytes(), start).min(text.len());
        let string = text.get(start..end)?;
        if serde_json::from_str::<String>(string).is_ok_and(|string| string == value) {
            return Some(start..end);
        }
        at = end;
    }
    None
}

/// Returns the path from the root to the value at a byte of the text: `automata[1].edges[3].guard`.
pub(super) fn path(text: &str, at: usize) -> Option<String> {
    let document = Document::parse(text).ok()?;
    let mut node = document.root();
    let mut path = String::new();
    let holds = |n: &Node<'_>| n.span().range().contains(&at);
    for _ in 0..MOST_STEPS {
        node = match node.shape().ok()? {
            Shape::Object(Object { members, .. }) => {
                let on = |m: &Member<'_>| holds(&m.value) || m.key_span.range().contains(&at);
                let Some(member) = members.into_iter().find(on) else { break };
                if !path.is_empty() {
                    path.push('.');
                }
                path.push_str(&member.key);
                member.value
            }
            Shape::Array(items) => {
                let Some((index, item)) = items.into_iter().enumerate().find(|(_, i)| holds(i)) else {
                    break;
                };
                path.push_str(&format!("[{index}]"));
                item
            }
            _ => break,
        };
    }
    (!path.is_empty()).then_some(path)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_know_their_places() {
        let text = "\u{feff} {\"a\": [1, {\"b\": \"x\\n\"}]}";
        let document = Document::parse(text).map_err(|e| e.message).unwrap();
        let Ok(Shape::Object(Object { members, .. })) = document.root().shape() else { panic!() };
        assert_eq!(&text[members[0].key_span.range()], "\"a\"");
        assert_eq!(&text[members[0].value.span().range()], "[1, {\"b\": \"x\\n\"}]");
        let at = text.find("\"x").unwrap();
        assert_eq!(path(text, at).as_deref(), Some("a[1].b"));
        assert_eq!(path(text, text.find('1').unwrap()).as_deref(), Some("a[0]"));
    }

    #[test]
    fn the_place_of_an_error_of_syntax_is_found() {
        let malformed = Document::parse("\u{feff}{\"a\": 1,\n \"b\" 2}").err().unwrap();
        assert_eq!(malformed.message, "this is not JSON: expected `:`");
        assert_eq!(malformed.at.start(), "\u{feff}{\"a\": 1,\n \"b\" ".len());
    }
}
