//! JSON values that know their place in the text.
//!
//! `serde_json` does all the parsing. Its values have no places, but a [`RawValue`] that borrows
//! from the text is a piece of it, so its address gives the place. Objects and arrays are opened on
//! demand, one level at a time; nothing is stored in addition to the text.

use std::borrow::Cow;
use std::fmt;

use serde::de::{Deserialize, Deserializer, MapAccess, Visitor};
use serde_json::value::RawValue;

use crate::lang::ast::Span;

/// Maximum nesting of objects and arrays; expressions of real models stay below 60.
pub(super) const MOST_DEPTH: u32 = 500;

/// Maximum number of steps in the path to a value, for messages.
const MOST_STEPS: usize = 40;

/// A value of a document.
#[derive(Debug, Clone, Copy)]
pub(super) struct Node<'a> {
    text: &'a str,
    start: usize,
    depth: u32,
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

/// Returns the document of a text, after a check of its whole syntax. A byte order mark is skipped.
///
/// # Errors
/// The text is not JSON.
pub(super) fn document(text: &str) -> Result<Node<'_>, Malformed> {
    let body = text.strip_prefix('\u{feff}').unwrap_or(text);
    let start = text.len() - body.len();
    match serde_json::from_str::<&RawValue>(body) {
        Ok(raw) => Ok(Node { text: raw.get(), start: start + offset(body, raw.get()), depth: 0 }),
        Err(e) => {
            let at = start + byte_of(body, e.line(), e.column());
            Err(Malformed { at: Span::new(at, at + 1), message: reason(&e) })
        }
    }
}

impl<'a> Node<'a> {
    /// Returns the place of the value.
    pub(super) fn span(self) -> Span {
        Span::new(self.start, self.start + self.text.len())
    }

    /// Returns the form of the value.
    ///
    /// # Errors
    /// The value cannot be opened, such as a string with a broken escape.
    pub(super) fn shape(self) -> Result<Shape<'a>, Malformed> {
        let broken = |e: serde_json::Error| Malformed { at: self.span(), message: reason(&e) };
        Ok(match self.text.as_bytes().first() {
            Some(b'{') => Shape::Object(self.object().map_err(broken)?),
            Some(b'[') => {
                let items: Vec<&RawValue> = serde_json::from_str(self.text).map_err(broken)?;
                Shape::Array(items.into_iter().map(|i| self.inner(i.get())).collect())
            }
            Some(b'"') => Shape::Text(serde_json::from_str(self.text).map_err(broken)?),
            Some(b't') => Shape::Bool(true),
            Some(b'f') => Shape::Bool(false),
            Some(b'n') => Shape::Null,
            _ => Shape::Number(self.text),
        })
    }

    fn object(self) -> serde_json::Result<Object<'a>> {
        let Pairs(pairs) = serde_json::from_str(self.text)?;
        let member = |(key, value): (&'a RawValue, &'a RawValue)| {
            let key_span = self.inner(key.get()).span();
            let key = serde_json::from_str::<Cow<'_, str>>(key.get())?.into_owned();
            Ok(Member { key, key_span, value: self.inner(value.get()) })
        };
        let members = pairs.into_iter().map(member).collect::<serde_json::Result<_>>()?;
        Ok(Object { span: self.span(), members })
    }

    fn inner(self, text: &'a str) -> Node<'a> {
        Node { text, start: self.start + offset(self.text, text), depth: self.depth + 1 }
    }

    /// Returns the number of objects and arrays around the value.
    pub(super) fn depth(self) -> u32 {
        self.depth
    }
}

/// Returns the offset of a piece of a text.
fn offset(text: &str, piece: &str) -> usize {
    (piece.as_ptr() as usize).saturating_sub(text.as_ptr() as usize)
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

/// The members of an object in their order, including equal keys.
struct Pairs<'a>(Vec<(&'a RawValue, &'a RawValue)>);

impl<'de> Deserialize<'de> for Pairs<'de> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(PairsVisitor)
    }
}

struct PairsVisitor;

impl<'de> Visitor<'de> for PairsVisitor {
    type Value = Pairs<'de>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an object")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
        let mut pairs = Vec::new();
        while let Some(pair) = map.next_entry()? {
            pairs.push(pair);
        }
        Ok(Pairs(pairs))
    }
}

/// Returns the path from the root to the value at a byte of the text: `automata[1].edges[3].guard`.
pub(super) fn path(text: &str, at: usize) -> Option<String> {
    let mut node = document(text).ok()?;
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
        let Ok(Shape::Object(Object { members, .. })) = document(text).map_err(|_| ()).unwrap().shape()
        else {
            panic!()
        };
        assert_eq!(&text[members[0].key_span.range()], "\"a\"");
        assert_eq!(&text[members[0].value.span().range()], "[1, {\"b\": \"x\\n\"}]");
        let at = text.find("\"x").unwrap();
        assert_eq!(path(text, at).as_deref(), Some("a[1].b"));
        assert_eq!(path(text, text.find('1').unwrap()).as_deref(), Some("a[0]"));
    }

    #[test]
    fn the_place_of_an_error_of_syntax_is_found() {
        let malformed = document("\u{feff}{\"a\": 1,\n \"b\" 2}").err().unwrap();
        assert_eq!(malformed.message, "expected `:`");
        assert_eq!(malformed.at.start(), "\u{feff}{\"a\": 1,\n \"b\" ".len());
    }
}
