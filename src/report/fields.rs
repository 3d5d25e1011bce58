//! The fields of the reports, read from their schemas: for the table of `docs/json.md` and the types of the
//! Python package.

use std::collections::BTreeMap;

use serde_json::{Value as Json, json};

use super::schema::COMMON;

/// Enumerations with fewer values than this have them in their type.
const MOST_NAMES: usize = 6;

/// A field of a report.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Field {
    /// Its place, such as `objectives[].name`.
    pub path: String,
    /// Its type in words, such as `list of counts`.
    pub kind: String,
    /// True if it may be `null`.
    pub nullable: bool,
    /// True if it may be absent.
    pub optional: bool,
}

/// Returns the fields of each report, and of each part that several reports have, in their order.
pub fn fields(schemas: &BTreeMap<&'static str, Json>) -> BTreeMap<String, Vec<Field>> {
    let parts = schemas.get(COMMON).and_then(|common| common["$defs"].as_object());
    let parts = parts.into_iter().flatten().map(|(name, part)| (name.as_str(), part));
    let reports = schemas.iter().filter(|(name, _)| **name != COMMON).map(|(name, report)| (*name, report));
    let objects = reports.chain(parts).filter(|(_, object)| object.get("properties").is_some());
    objects.map(|(name, object)| (name.to_owned(), fields_of(object, ""))).collect()
}

/// Returns the fields of an object and of its parts; their places begin with `prefix`.
fn fields_of(object: &Json, prefix: &str) -> Vec<Field> {
    let mut all = Vec::new();
    for (name, schema) in object["properties"].as_object().into_iter().flatten() {
        let path = format!("{prefix}{name}");
        let (mut inner, mut inside) = (schema, path.clone());
        all.push(Field {
            path,
            kind: kind(schema),
            nullable: is_nullable(schema),
            optional: !is_required(object, name),
        });
        while inner.get("items").is_some() {
            (inner, inside) = (&inner["items"], inside + "[]");
        }
        all.extend(fields_of(inner, &format!("{inside}.")));
    }
    all
}

/// Returns whether each object of this schema has a field.
pub(super) fn is_required(object: &Json, name: &str) -> bool {
    object["required"].as_array().is_some_and(|all| all.contains(&json!(name)))
}

/// Returns whether `null` is a value of a schema.
pub(super) fn is_nullable(schema: &Json) -> bool {
    let is_null = |schema: &Json| schema["type"] == "null" || schema["type"][1] == "null";
    is_null(schema) || schema["anyOf"].as_array().is_some_and(|all| all.iter().any(is_null))
}

/// Returns the name of the report or part to which a schema refers.
pub(super) fn reference(schema: &Json) -> Option<&str> {
    let reference = schema["$ref"].as_str().or(schema["anyOf"][0]["$ref"].as_str())?;
    reference.rsplit('/').next().map(|name| name.trim_end_matches(".json"))
}

/// Returns whether a schema describes reports of several kinds.
pub(super) fn is_any_report(schema: &Json) -> bool {
    schema["anyOf"][1].get("$ref").is_some()
}

/// Returns the type of a schema: its first one, if `null` is the other.
pub(super) fn simple(schema: &Json) -> Option<&str> {
    schema["type"].as_str().or(schema["type"][0].as_str())
}

/// Returns the type of a schema in words.
fn kind(schema: &Json) -> String {
    if is_any_report(schema) {
        return "report".to_owned();
    }
    if let Some(name) = reference(schema) {
        return name.to_owned();
    }
    match simple(schema) {
        Some("array") => {
            let items = kind(&schema["items"]);
            if items.ends_with('s') { format!("list of {items}") } else { format!("list of {items}s") }
        }
        Some("object") if schema.get("properties").is_none() => "map".to_owned(),
        Some(simple) => simple.to_owned() + &values(schema),
        None => "string".to_owned(),
    }
}

/// Lists the values of an enumeration, if they are short enough for a table.
fn values(schema: &Json) -> String {
    let names: Vec<String> = names(schema).iter().map(|name| format!("`{name}`")).collect();
    match names.split_last() {
        Some((last, others)) if !others.is_empty() && names.len() < MOST_NAMES => {
            format!(": {} or {last}", others.join(", "))
        }
        _ => String::new(),
    }
}

/// Returns the values of an enumeration, without `null`.
pub(super) fn names(schema: &Json) -> Vec<&str> {
    schema["enum"].as_array().into_iter().flatten().filter_map(Json::as_str).collect()
}
