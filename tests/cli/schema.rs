//! Checks JSON by the schemas of the reports: the definitions of the keywords that these use, and of no others.

use serde_json::Value;

use crate::common::prelude::*;

/// The schemas by name, which may refer to each other.
pub(super) struct Validator<'s>(pub(super) &'s BTreeMap<&'static str, Value>);

impl Validator<'_> {
    /// Returns what does not fit the schema of a report.
    pub(super) fn faults(&self, name: &str, report: &Value) -> Vec<String> {
        let mut faults = Vec::new();
        self.check((name, &self.0[name]), report, name, &mut faults);
        faults
    }

    pub(super) fn fits(&self, name: &str, report: &Value) -> bool {
        self.faults(name, report).is_empty()
    }

    /// Checks a value by a part of a file of schemas.
    fn check(&self, (file, schema): (&str, &Value), value: &Value, at: &str, faults: &mut Vec<String>) {
        let fits = |schema: &Value| {
            let mut inner = Vec::new();
            self.check((file, schema), value, at, &mut inner);
            inner.is_empty()
        };
        for (keyword, wanted) in schema.as_object().expect("a schema is an object") {
            let done = match keyword.as_str() {
                "$schema" | "title" | "description" | "$defs" => true,
                "$ref" => {
                    let (other, place) =
                        wanted.as_str().unwrap().split_once('#').unwrap_or((wanted.as_str().unwrap(), ""));
                    let other = other.strip_suffix(".json").unwrap_or(file);
                    let part = self.0[other].pointer(place).expect("a reference leads to a schema");
                    self.check((other, part), value, at, faults);
                    true
                }
                "anyOf" => wanted.as_array().unwrap().iter().any(fits),
                "properties" | "additionalProperties" | "items" => {
                    self.parts((file, schema), value, at, faults);
                    true
                }
                _ => simple(keyword, wanted, value),
            };
            if !done {
                faults.push(format!("{at}: {value} does not fit {keyword}: {wanted}"));
            }
        }
    }

    /// Checks the fields of an object, or the items of a list.
    fn parts(&self, (file, schema): (&str, &Value), value: &Value, at: &str, faults: &mut Vec<String>) {
        let named = |name: &String| schema["properties"].get(name).or(schema.get("additionalProperties"));
        let fields = value
            .as_object()
            .into_iter()
            .flatten()
            .filter_map(|(name, part)| Some((name.clone(), named(name)?, part)));
        let items = value.as_array().into_iter().flatten().enumerate();
        let items = items.filter_map(|(i, part)| Some((i.to_string(), schema.get("items")?, part)));
        for (name, wanted, part) in fields.chain(items) {
            match wanted {
                Value::Bool(true) => {}
                Value::Bool(false) => faults.push(format!("{at}/{name}: not in the schema")),
                schema => self.check((file, schema), part, &format!("{at}/{name}"), faults),
            }
        }
    }
}

/// Returns whether a value fits a keyword without inner schemas.
fn simple(keyword: &str, wanted: &Value, value: &Value) -> bool {
    let of = |ty: &Value| ty.as_str().is_some_and(|ty| is_of(value, ty));
    let count = wanted.as_u64().map(|n| n as usize);
    match keyword {
        "type" => std::slice::from_ref(wanted).iter().chain(wanted.as_array().into_iter().flatten()).any(of),
        "const" => value == wanted,
        "enum" => wanted.as_array().unwrap().contains(value),
        "required" => value.as_object().is_none_or(|object| {
            wanted.as_array().unwrap().iter().all(|name| object.contains_key(name.as_str().unwrap()))
        }),
        "minimum" => value.as_f64().is_none_or(|n| n >= wanted.as_f64().unwrap()),
        "minItems" => value.as_array().is_none_or(|items| items.len() >= count.unwrap()),
        "maxItems" => value.as_array().is_none_or(|items| items.len() <= count.unwrap()),
        "pattern" => {
            assert_eq!(wanted, "^[0-9]+$", "another pattern");
            value.as_str().is_none_or(|text| !text.is_empty() && text.bytes().all(|c| c.is_ascii_digit()))
        }
        other => panic!("the keyword {other} is not known here"),
    }
}

/// Returns whether a value is of a type; a whole number is of two.
fn is_of(value: &Value, ty: &str) -> bool {
    match value {
        Value::Null => ty == "null",
        Value::Bool(_) => ty == "boolean",
        Value::String(_) => ty == "string",
        Value::Array(_) => ty == "array",
        Value::Object(_) => ty == "object",
        Value::Number(n) => ty == "number" || ty == "integer" && n.as_f64().unwrap().fract() == 0.0,
    }
}
