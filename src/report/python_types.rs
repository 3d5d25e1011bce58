//! The types of the reports for Python: a `TypedDict` for each object.

use std::collections::BTreeMap;

use serde_json::Value as Json;

use super::fields::{is_nullable, is_required, names, reference, simple};
use super::schema::COMMON;

const HEAD: &str = "\"\"\"The types of the reports: dictionaries with the fields of `--json`, in which infinite numbers are floats.\n\n\
    A test of the Rust crate `meliora-report` writes this file from the types there.\n\"\"\"\n\n\
    from __future__ import annotations\n\n\
    from typing import TYPE_CHECKING, Any, Dict, List, Literal, TypedDict, Union\n\n\
    if TYPE_CHECKING:\n    from typing_extensions import NotRequired\n";

/// The maximum number of characters of a line.
const WIDTH: usize = 110;

/// Returns the text of the module.
pub(super) fn python_types(schemas: &BTreeMap<&'static str, Json>) -> String {
    let mut module = Module::default();
    let parts = schemas.get(COMMON).and_then(|common| common["$defs"].as_object());
    for (name, part) in parts.into_iter().flatten() {
        module.named(&camel(name), part);
    }
    for (name, report) in schemas.iter().filter(|(name, _)| **name != COMMON) {
        module.named(&report_name(name), report);
    }
    let aliases: String = module.aliases.concat();
    let classes = module.classes.iter().map(|(name, text)| format!("\n\nclass {name}{text}"));
    format!("{HEAD}\n{aliases}{}", classes.collect::<String>())
}

fn report_name(name: &str) -> String {
    camel(name) + "Report"
}

#[derive(Default)]
struct Module {
    aliases: Vec<String>,
    /// The classes by name, with their texts.
    classes: Vec<(String, String)>,
}

impl Module {
    /// Adds a type with a name.
    fn named(&mut self, name: &str, schema: &Json) {
        if schema.get("properties").is_some() {
            self.class(name, schema);
            return;
        }
        let alias = format!("#: {}\n{name} = {}\n", text(schema), self.kind(schema, name));
        self.aliases.push(alias);
    }

    /// Adds a class, unless one with the same text and fields has been added; returns the name of the class.
    fn class(&mut self, name: &str, schema: &Json) -> String {
        let mut class = format!("(TypedDict):\n{}\n", doc(text(schema)));
        for (field, inner) in schema["properties"].as_object().into_iter().flatten() {
            let own = format!("{}{}", name.trim_end_matches("Report"), camel(field));
            let mut kind = self.kind(inner, &own);
            if is_nullable(inner) {
                kind = format!("Union[{kind}, None]");
            }
            if !is_required(schema, field) {
                kind = format!("NotRequired[{kind}]");
            }
            class += &format!("    {field}: {kind}\n{}", doc(text(inner)));
        }
        if let Some((known, _)) = self.classes.iter().find(|(_, text)| *text == class) {
            return known.clone();
        }
        self.classes.push((name.to_owned(), class));
        name.to_owned()
    }

    /// Returns the type of a schema, without `null`. An object without a name of its own gets `name`.
    fn kind(&mut self, schema: &Json, name: &str) -> String {
        if let Some(constant) = schema.get("const") {
            return format!("Literal[{constant}]");
        }
        if schema.get("$ref").is_some() {
            let file = schema["$ref"].as_str().unwrap_or_default();
            let target = reference(schema).unwrap_or_default();
            return if file.contains('#') { camel(target) } else { report_name(target) };
        }
        if let Some(all) = schema["anyOf"].as_array() {
            let kinds: Vec<String> =
                all.iter().filter(|one| !is_left_out(one)).map(|one| self.kind(one, name)).collect();
            return if let [one] = kinds.as_slice() {
                one.clone()
            } else {
                format!("Union[{}]", kinds.join(", "))
            };
        }
        let values = names(schema);
        if !values.is_empty() {
            return format!(
                "Literal[{}]",
                values.iter().map(|v| format!("\"{v}\"")).collect::<Vec<_>>().join(", ")
            );
        }
        if schema.get("properties").is_some() {
            return self.class(name, schema);
        }
        match simple(schema) {
            Some("array") => format!("List[{}]", self.kind(&schema["items"], name)),
            Some("object") if schema["additionalProperties"].is_object() => {
                format!("Dict[str, {}]", self.kind(&schema["additionalProperties"], name))
            }
            Some("object") => "Dict[str, Any]".to_owned(),
            _ => scalars(schema),
        }
    }
}

/// Returns true for `null`, which fields say, and for the texts of infinite numbers, which are floats in Python.
fn is_left_out(schema: &Json) -> bool {
    schema["type"] == "null" || schema["const"] == "inf" || schema["const"] == "-inf"
}

/// Returns the type of a number, a text or a truth value.
fn scalars(schema: &Json) -> String {
    let all: Vec<&str> = match &schema["type"] {
        Json::Array(all) => all.iter().filter_map(Json::as_str).collect(),
        one => one.as_str().into_iter().collect(),
    };
    let python = |name: &&str| match *name {
        "integer" => Some("int"),
        "number" => Some("float"),
        "boolean" => Some("bool"),
        "string" => Some("str"),
        _ => None,
    };
    let kinds: Vec<&str> = all.iter().filter_map(python).collect();
    if let [one] = kinds.as_slice() { (*one).to_owned() } else { format!("Union[{}]", kinds.join(", ")) }
}

fn text(schema: &Json) -> &str {
    schema["description"].as_str().unwrap_or_default()
}

/// Formats a docstring; nothing without a text.
fn doc(text: &str) -> String {
    if text.is_empty() {
        return String::new();
    }
    let (mut lines, mut line) = (Vec::new(), String::from("    \"\"\""));
    for (at, word) in text.replace('\\', "\\\\").split(' ').enumerate() {
        if line.chars().count() + 1 + word.chars().count() > WIDTH {
            lines.push(std::mem::replace(&mut line, "   ".to_owned()));
        }
        line = if at == 0 { line + word } else { line + " " + word };
    }
    let end = if line.ends_with('"') { "\n    \"\"\"\n" } else { "\"\"\"\n" };
    lines.push(line);
    lines.join("\n") + end
}

/// Converts a name such as `most_preferred` to `MostPreferred`.
fn camel(name: &str) -> String {
    let word = |word: &str| match word.char_indices().nth(1) {
        Some((at, _)) => word[..at].to_uppercase() + &word[at..],
        None => word.to_uppercase(),
    };
    name.split('_').map(word).collect()
}
