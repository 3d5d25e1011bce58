//! The table of `docs/json.md`: one row per report and shared part, with the names of its fields.

use std::collections::BTreeMap;

use serde_json::Value as Json;

use super::fields::{Field, fields};
use super::schema::COMMON;

/// The fields that most reports share, which the page explains once.
const OF_ALL: &[&str] = &["schema", "complete", "time", "memory", "error"];

const HEAD: &str = "| report | schema | fields |";

/// Returns a page with the table of the schemas; the text around it stays.
pub(super) fn with_table(page: &str, schemas: &BTreeMap<&'static str, Json>) -> String {
    let mut out = String::new();
    let mut skips = false;
    for line in page.lines() {
        let begins = line == HEAD;
        skips = begins || (skips && line.starts_with('|'));
        if begins {
            out += &table(schemas);
        } else if !skips {
            out = out + line + "\n";
        }
    }
    out
}

fn table(schemas: &BTreeMap<&'static str, Json>) -> String {
    let rows = fields(schemas).into_iter().map(|(name, fields)| {
        let file = if schemas.contains_key(name.as_str()) { name.as_str() } else { COMMON };
        format!("| {name} | [{file}.json](schema/{file}.json) | {} |\n", names(&name, &fields))
    });
    format!("{HEAD}\n| --- | --- | --- |\n{}", rows.collect::<String>())
}

/// Lists the fields of an object itself.
fn names(report: &str, fields: &[Field]) -> String {
    let is_inside = |path: &str| path.contains(['.', '[']);
    let is_own = |path: &str| report == "error" || !OF_ALL.contains(&path);
    let own = fields.iter().filter(|field| !is_inside(&field.path) && is_own(&field.path));
    own.map(|field| format!("`{}`", field.path)).collect::<Vec<_>>().join(", ")
}
