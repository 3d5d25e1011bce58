//! Names in files of policies. A name that could be read as something else stands in double quotes, and each of its own
//! quotes is doubled.

use std::borrow::Cow;

use meliora_base::escape::{quoted, unquoted, value};
use meliora_model::Variable;

/// Returns a name as files contain it: in quotes if it has a separator, a quote or outer blanks, or looks like a negation.
pub(super) fn name(name: &str) -> Cow<'_, str> {
    let is_plain = !name.is_empty()
        && name.trim() == name
        && !name.contains(['/', '=', '"'])
        && !name.starts_with(NEGATION);
    if is_plain { Cow::Borrowed(name) } else { Cow::Owned(quoted(name)) }
}

/// Returns `x=1` for a variable with a value.
pub(super) fn equation(variable: &Variable, x: i64) -> String {
    let shown = match variable.value_name(x) {
        Some(own) if matches!(value(own), Cow::Borrowed(_)) => name(own),
        Some(own) => Cow::Owned(quoted(own)),
        None => variable.show(x).into(),
    };
    format!("{}={shown}", name(&variable.name))
}

/// The beginning of a negated condition.
const NEGATION: &str = "not(";

/// A condition of a file: a fact, or a variable with its value.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Condition {
    pub(super) name: String,
    /// The value, and whether it stood in quotes; `None` for a fact.
    pub(super) value: Option<(String, bool)>,
    pub(super) negated: bool,
}

/// The rest of a line.
pub(super) struct Rest<'t>(pub(super) &'t str);

impl Rest<'_> {
    /// Reads a name up to one of some texts, or to the end, and whether it stood in quotes; `None` if quotes are wrong.
    pub(super) fn name(&mut self, ends: &[&str]) -> Option<(String, bool)> {
        let text = self.0.trim_start();
        if text.starts_with('"') {
            let (name, rest) = unquoted(text)?;
            self.0 = rest;
            return Some((name, true));
        }
        let end = ends.iter().filter_map(|end| text.find(end)).min().unwrap_or(text.len());
        let (name, rest) = text.split_at(end);
        self.0 = rest;
        Some((name.trim().to_owned(), false))
    }

    /// Removes a text from the beginning of the rest; returns whether it stands there.
    pub(super) fn skip(&mut self, text: &str) -> bool {
        let rest = self.0.trim_start().strip_prefix(text);
        self.0 = rest.unwrap_or(self.0);
        rest.is_some()
    }

    /// Reads `fact`, `x=1`, or the negation of either, up to a slash or, if the text contains `one` condition, to its end;
    /// `has_values` for `x=1`. Returns `None` if it has another form.
    pub(super) fn condition(&mut self, has_values: bool, one: bool) -> Option<Condition> {
        let negated = self.skip(NEGATION);
        let end: &[&str] = if one { &[] } else { &["/"] };
        let ends = if has_values { [end, &["="]].concat() } else { end.to_vec() };
        let (mut name, mut in_quotes) = self.name(&ends)?;
        let mut value = None;
        if has_values {
            self.skip("=").then_some(())?;
            let found = self.name(end)?;
            in_quotes = found.1;
            value = Some(found);
        }
        if negated && in_quotes {
            self.skip(")").then_some(())?;
        } else if negated {
            let last = value.as_mut().map_or(&mut name, |value| &mut value.0);
            *last = last.strip_suffix(')')?.trim_end().to_owned();
        }
        let rest = self.0.trim_start();
        (rest.is_empty() || !one && rest.starts_with('/')).then_some(Condition { name, value, negated })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str, has_values: bool, one: bool) -> Option<Condition> {
        Rest(text).condition(has_values, one)
    }

    #[test]
    fn names_are_read_back_whatever_they_contain() {
        for own in
            ["a", "a/b", "a / b", "a=b", "\"", "a\"b", " a ", "not(c)", "c)", "", "true", "5", "a,b", "x y"]
        {
            let text = format!("{}={}", name(own), name(own));
            for text in [text.clone(), format!("not({text})")] {
                for (one, text) in [(true, text.clone()), (false, format!("{text}/b=1"))] {
                    let found = read(&text, true, one).unwrap_or_else(|| panic!("{text}"));
                    assert_eq!((found.name.as_str(), found.value.unwrap().0.as_str()), (own, own), "{text}");
                    assert_eq!(found.negated, text.starts_with("not("), "{text}");
                }
            }
            assert_eq!(read(&name(own), false, true).unwrap().name, own);
            assert_eq!(Rest(&format!("{} / SC", name(own))).name(&[" / "]).unwrap().0, own);
        }
    }

    #[test]
    fn other_texts_are_refused() {
        for text in ["x", "x=\"", "\"x=1", "not(x=1", "\"x\"y=1", "x=\"a\"b", "not(x=\"a\""] {
            assert_eq!(read(text, true, false), None, "{text}");
        }
        assert_eq!(read("not(p", false, false), None);
    }
}
