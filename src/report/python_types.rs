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
    let bases = module.bases();
    let classes = bases.iter().chain(&module.classes).map(Class::text);
    format!("{HEAD}\n{aliases}{}", classes.collect::<String>())
}

/// Classes of fields that reports share, each after the one that it inherits from: the name, the description and the
/// fields.
const BASES: [(&str, &str, &[&str]); 2] = [
    ("Report", "The fields of most reports.", &["complete", "memory", "error"]),
    ("ModelReport", "The fields of most reports about a model.", &["model", "scope"]),
];

/// A class of a dictionary.
#[derive(Clone, PartialEq)]
struct Class {
    name: String,
    base: &'static str,
    doc: String,
    /// The fields by name, with their texts.
    fields: Vec<(String, String)>,
}

impl Class {
    fn text(&self) -> String {
        let fields: String = self.fields.iter().map(|(_, text)| text.as_str()).collect();
        format!("\n\nclass {}({}):\n{}\n{fields}", self.name, self.base, self.doc)
    }
}

fn report_name(name: &str) -> String {
    camel(name) + "Report"
}

#[derive(Default)]
struct Module {
    aliases: Vec<String>,
    classes: Vec<Class>,
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
        let (doc_, mut fields) = (doc(text(schema)), Vec::new());
        for (field, inner) in schema["properties"].as_object().into_iter().flatten() {
            let own = format!("{}{}", name.trim_end_matches("Report"), camel(field));
            let mut kind = self.kind(inner, &own);
            if is_nullable(inner) {
                kind = format!("Union[{kind}, None]");
            }
            if !is_required(schema, field) {
                kind = format!("NotRequired[{kind}]");
            }
            fields.push((field.clone(), format!("    {field}: {kind}\n{}", doc(text(inner)))));
        }
        let class = Class { name: name.to_owned(), base: "TypedDict", doc: doc_, fields };
        if let Some(known) =
            self.classes.iter().find(|known| (&known.doc, &known.fields) == (&class.doc, &class.fields))
        {
            return known.name.clone();
        }
        self.classes.push(class);
        name.to_owned()
    }

    /// Returns the classes of [`BASES`], from which reports with these fields inherit them.
    fn bases(&mut self) -> Vec<Class> {
        let mut bases = Vec::new();
        let mut base = "TypedDict";
        for (name, description, names) in BASES {
            let has =
                |class: &Class, shared: &[(String, String)]| shared.iter().all(|f| class.fields.contains(f));
            let of = |class: &Class| -> Vec<(String, String)> {
                class.fields.iter().filter(|(field, _)| names.contains(&field.as_str())).cloned().collect()
            };
            let own = |class: &&Class| class.base == base && of(class).len() == names.len();
            let Some(shared) = self.classes.iter().find(own).map(of) else { break };
            let inherits = |class: &&mut Class| class.base == base && has(class, &shared);
            for class in self.classes.iter_mut().filter(inherits) {
                class.base = name;
                class.fields.retain(|field| !shared.contains(field));
            }
            let doc = doc(description);
            bases.push(Class { name: name.to_owned(), base, doc, fields: shared });
            base = name;
        }
        bases
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
