//! JSON with places: values that know where they stand in the text.
//!
//! `serde_json` does all the parsing. Its values carry no places; but a [`RawValue`] that borrows from
//! the text is a piece of it, so the place of a value is the place of its piece. Objects and arrays are
//! opened one level at a time, when they are looked at: nothing of the document is kept beside the text.

use std::borrow::Cow;
use std::fmt;

use serde::de::{Deserialize, Deserializer, MapAccess, Visitor};
use serde_json::value::RawValue;

use crate::lang::ast::Span;

/// How deep objects and arrays may nest: expressions of real models stay below 60.
pub(super) const MOST_DEPTH: u32 = 500;

/// So many steps are named on the way to a value; nobody reads more.
const MOST_STEPS: usize = 40;

/// A value of a document.
#[derive(Debug, Clone, Copy)]
pub(super) struct Node<'a> {
    text: &'a str,
    start: usize,
    depth: u32,
}

/// What a value is; objects and arrays opened by one level.
pub(super) enum Shape<'a> {
    Null,
    Bool(bool),
    /// As it is written.
    Number(&'a str),
    Text(String),
    Array(Vec<Node<'a>>),
    Object(Vec<Member<'a>>),
}

/// A member of an object.
pub(super) struct Member<'a> {
    pub(super) key: String,
    pub(super) key_span: Span,
    pub(super) value: Node<'a>,
}

/// Why a text is no document that could be read, and where.
pub(super) struct Malformed {
    pub(super) at: Span,
    pub(super) message: String,
}

/// The document of a text, its syntax checked throughout. A byte order mark is skipped.
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
    /// Where the value stands.
    pub(super) fn span(self) -> Span {
        Span::new(self.start, self.start + self.text.len())
    }

    /// What the value is.
    pub(super) fn shape(self) -> Result<Shape<'a>, Malformed> {
        let broken = |e: serde_json::Error| Malformed { at: self.span(), message: reason(&e) };
        Ok(match self.text.as_bytes().first() {
            Some(b'{') => Shape::Object(self.members().map_err(broken)?),
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

    fn members(self) -> serde_json::Result<Vec<Member<'a>>> {
        let Pairs(pairs) = serde_json::from_str(self.text)?;
        let member = |(key, value): (&'a RawValue, &'a RawValue)| {
            let key_span = self.inner(key.get()).span();
            let key = serde_json::from_str::<Cow<'_, str>>(key.get())?.into_owned();
            Ok(Member { key, key_span, value: self.inner(value.get()) })
        };
        pairs.into_iter().map(member).collect()
    }

    fn inner(self, text: &'a str) -> Node<'a> {
        Node { text, start: self.start + offset(self.text, text), depth: self.depth + 1 }
    }

    /// How many objects and arrays stand around it.
    pub(super) fn depth(self) -> u32 {
        self.depth
    }
}

/// Where a piece of a text begins.
fn offset(text: &str, piece: &str) -> usize {
    (piece.as_ptr() as usize).saturating_sub(text.as_ptr() as usize)
}

/// The byte that a message of the parser speaks of; its columns are bytes, from 1.
fn byte_of(text: &str, line: usize, column: usize) -> usize {
    let before: usize = text.split_inclusive('\n').take(line.saturating_sub(1)).map(str::len).sum();
    (before + column.saturating_sub(1)).min(text.len())
}

/// The message without the place that it ends with.
fn reason(error: &serde_json::Error) -> String {
    let text = error.to_string();
    text.rsplit_once(" at line ").map_or(text.as_str(), |(message, _)| message).to_owned()
}

/// The members of an object in their order, equal keys too.
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

/// The way from the whole document to the value at a byte of its text: `automata[1].edges[3].guard`.
pub(super) fn path(text: &str, at: usize) -> Option<String> {
    let mut node = document(text).ok()?;
    let mut path = String::new();
    let holds = |n: &Node<'_>| n.span().range().contains(&at);
    for _ in 0..MOST_STEPS {
        node = match node.shape().ok()? {
            Shape::Object(members) => {
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
        let Ok(Shape::Object(members)) = document(text).map_err(|_| ()).unwrap().shape() else { panic!() };
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
