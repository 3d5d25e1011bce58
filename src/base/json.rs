//! JSON in which every character is displayed: `\u202e` and the like replace all others, which mean
//! the same for readers.

use std::io::{self, Write};

use serde::Serialize;
use serde_json::ser::{CompactFormatter, Formatter, PrettyFormatter};
use serde_json::{Result, Serializer};

use super::escape::is_shown;

/// Writes a value with line breaks and indentation.
///
/// # Errors
/// Writing fails, or the value has no JSON form.
pub fn write_pretty(value: &impl Serialize, out: impl Write) -> Result<()> {
    value.serialize(&mut Serializer::with_formatter(out, Shown(PrettyFormatter::new())))
}

/// Returns a value as text with line breaks and indentation.
///
/// # Errors
/// The value has no JSON form.
pub fn pretty(value: &impl Serialize) -> Result<String> {
    text(value, Shown(PrettyFormatter::new()))
}

/// Returns a value as one line.
///
/// # Errors
/// The value has no JSON form.
pub fn compact(value: &impl Serialize) -> Result<String> {
    text(value, Shown(CompactFormatter))
}

/// Returns a value as one line for an HTML script element: no `<` in a text ends it.
///
/// # Errors
/// The value has no JSON form.
pub fn script(value: &impl Serialize) -> Result<String> {
    Ok(compact(value)?.replace('<', "\\u003c"))
}

fn text(value: &impl Serialize, formatter: impl Formatter) -> Result<String> {
    let mut bytes = Vec::new();
    value.serialize(&mut Serializer::with_formatter(&mut bytes, formatter))?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

/// A layout in which strings have only characters that are displayed.
struct Shown<F>(F);

/// Forwards methods of the layout.
macro_rules! forward {
    ($($name:ident($($argument:ident: $ty:ty)?),)*) => {
        $(fn $name<W: ?Sized + Write>(&mut self, out: &mut W, $($argument: $ty)?) -> io::Result<()> {
            self.0.$name(out, $($argument)?)
        })*
    };
}

impl<F: Formatter> Formatter for Shown<F> {
    forward! {
        begin_array(), end_array(), begin_array_value(first: bool), end_array_value(),
        begin_object(), end_object(), begin_object_key(first: bool), end_object_key(),
        begin_object_value(), end_object_value(),
    }

    fn write_string_fragment<W: ?Sized + Write>(&mut self, out: &mut W, text: &str) -> io::Result<()> {
        shown(text, is_shown, out)
    }

    /// Writes JSON, whose line breaks are between its tokens.
    fn write_raw_fragment<W: ?Sized + Write>(&mut self, out: &mut W, text: &str) -> io::Result<()> {
        shown(text, |c| is_shown(c) || matches!(c, '\n' | '\r' | '\t'), out)
    }
}

fn shown(text: &str, keep: impl Fn(char) -> bool, out: &mut (impl ?Sized + Write)) -> io::Result<()> {
    let mut left = text;
    while let Some(at) = left.find(|c| !keep(c)) {
        out.write_all(&left.as_bytes()[..at])?;
        left = &left[at..];
        let c = left.chars().next().unwrap_or_default();
        c.encode_utf16(&mut [0; 2]).iter().try_for_each(|unit| write!(out, "\\u{unit:04x}"))?;
        left = &left[c.len_utf8()..];
    }
    out.write_all(left.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layouts_are_those_of_serde_json_and_all_characters_are_displayed() {
        let value = serde_json::json!({"a": ["é\n", {"b": null}], "c": {}});
        assert_eq!(pretty(&value).unwrap(), serde_json::to_string_pretty(&value).unwrap());
        assert_eq!(compact(&value).unwrap(), value.to_string());
        let text = "\u{1b}[2J\u{9b}\u{202e}\u{e0041}\u{7f}";
        assert_eq!(compact(&text).unwrap(), r#""\u001b[2J\u009b\u202e\udb40\udc41\u007f""#);
        let raw = serde_json::value::RawValue::from_string("[\"\u{202e}\",\n1]".to_owned()).unwrap();
        assert_eq!(compact(&raw).unwrap(), "[\"\\u202e\",\n1]");
    }
}
