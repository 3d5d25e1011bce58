//! The tables of `docs/json.md`: one per report and shared part, below the heading with its name.

use std::collections::BTreeMap;

use serde_json::Value as Json;

use super::fields::{Field, fields};

/// The section of the fields that most reports share.
const SHARED: &str = "every report";
/// These fields. Other sections leave them out.
const OF_ALL: &[&str] = &["schema", "complete", "time", "time.total", "memory", "error"];

const HEAD: &str = "| field | type | may be | meaning |\n| --- | --- | --- | --- |\n";

/// Returns a page with the tables of the schemas. The text around them stays; a report without a section receives one.
pub(super) fn with_tables(page: &str, schemas: &BTreeMap<&'static str, Json>) -> String {
    let mut fields = fields(schemas);
    let is_shared = |field: &Field| OF_ALL.contains(&field.path.as_str());
    let shared = fields["check"].iter().filter(|field| is_shared(field)).cloned().collect();
    for (name, own) in &mut fields {
        own.retain(|field| name == "error" && field.path != "schema" || !is_shared(field));
    }
    fields.insert(SHARED.to_owned(), shared);
    let links: Vec<String> = fields.keys().cloned().chain(["rank", "state"].map(str::to_owned)).collect();
    let mut out = String::new();
    let (mut section, mut skips) = (String::new(), false);
    for line in page.lines() {
        if line.starts_with('#') {
            section = line.trim_matches(['#', ' ']).to_lowercase();
        }
        let begins = line.starts_with("| field |");
        skips = begins || (skips && line.starts_with('|'));
        match if begins { fields.remove(&section) } else { None } {
            Some(own) => out += &table(&own, &links),
            None if skips => {}
            None => out = out + line + "\n",
        }
    }
    for (name, own) in &fields {
        out += &format!("\n## {name}\n\n`meliora.{name}/1`\n\n{}", table(own, &links));
    }
    out
}

fn table(fields: &[Field], links: &[String]) -> String {
    HEAD.to_owned() + &fields.iter().map(|field| row(field, links)).collect::<String>()
}

fn row(field: &Field, links: &[String]) -> String {
    let kind = match links.contains(&field.kind) {
        true => format!("[{0}](#{0})", field.kind),
        false => field.kind.clone(),
    };
    let may_be = match (field.nullable, field.optional) {
        (false, false) => "–",
        (true, false) => "`null`",
        (false, true) => "absent",
        (true, true) => "`null`, absent",
    };
    let meaning = field.meaning.replace('|', "\\|");
    format!("| `{}` | {kind} | {may_be} | {meaning} |\n", field.path)
}
