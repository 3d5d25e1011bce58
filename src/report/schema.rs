//! The JSON schemas of the reports: they follow from the types of the fields and their comments.

use std::collections::BTreeMap;

use schemars::generate::SchemaSettings;
use schemars::{JsonSchema, SchemaGenerator};
use serde_json::{Map, Value as Json, json};

use super::REPORTS;

/// The parts that several reports have. The schema [`COMMON`] describes them.
const PARTS: &[&str] = &["bound", "bounds", "count", "counts", "memory", "model", "rank", "state"];

/// The name of the schema of the parts.
pub(super) const COMMON: &str = "common";

/// The reports that are parts of others.
const INNER: &[&str] = &["check", "compare", "error", "reach"];

/// Returns the JSON schemas by name: `check` describes the report of `meliora check`. They refer to
/// each other as files, such as `error.json` and `common.json#/$defs/count`.
pub fn schemas() -> BTreeMap<&'static str, Json> {
    let mut generator = SchemaSettings::draft2020_12().for_serialize().into_generator();
    let reports = REPORTS.iter().map(|(name, raw)| (*name, raw(&mut generator))).collect::<Vec<_>>();
    let definitions = generator.take_definitions(false);
    let outside = Finish { definitions: &definitions, common: format!("{COMMON}.json") };
    let mut all: BTreeMap<&str, Json> = BTreeMap::new();
    for (name, schema) in reports {
        let schema = outside.schema(schema);
        match all.get_mut(name) {
            Some(other) => either(other, schema),
            None => _ = all.insert(name, schema),
        }
    }
    let inside = Finish { definitions: &definitions, common: String::new() };
    let part = |&name: &&str| Some((name.to_owned(), inside.schema(definitions.get(name)?.clone())));
    let parts: Map<String, Json> = PARTS.iter().filter_map(part).collect();
    all.insert(COMMON, json!({"$defs": parts}));
    all.into_iter().map(|(name, schema)| (name, titled(name, schema))).collect()
}

/// Returns the schema of a type, as it is derived.
pub(super) fn raw<T: JsonSchema>(generator: &mut SchemaGenerator) -> Json {
    T::json_schema(generator).to_value()
}

/// Adds the version of the language and the name.
fn titled(name: &str, schema: Json) -> Json {
    let mut titled = Map::new();
    titled.insert("$schema".to_owned(), json!("https://json-schema.org/draft/2020-12/schema"));
    titled.insert("title".to_owned(), json!(name));
    if let Json::Object(fields) = schema {
        titled.extend(fields);
    }
    Json::Object(titled)
}

/// Turns a schema into one for objects of either kind: the fields that are not in both are optional. Each field keeps its
/// place behind the one before it.
fn either(one: &mut Json, mut other: Json) {
    let required =
        |schema: &Json, name: &Json| schema["required"].as_array().is_some_and(|r| r.contains(name));
    if let Some(names) = one["required"].as_array_mut() {
        names.retain(|name| required(&other, name));
    }
    let (Some(fields), Some(others)) =
        (one["properties"].as_object_mut(), other["properties"].as_object_mut())
    else {
        return;
    };
    let mut place = 0;
    for (name, schema) in std::mem::take(others) {
        match fields.keys().position(|own| *own == name) {
            Some(at) => {
                place = at;
                if fields[&name].get("properties").is_some() {
                    either(&mut fields[&name], schema);
                }
            }
            None => _ = fields.shift_insert(place, name, schema),
        }
        place += 1;
    }
}

/// The conversion of derived schemas to those of this program.
struct Finish<'a> {
    /// The schemas of types by name.
    definitions: &'a Map<String, Json>,
    /// The address of the schema of the parts.
    common: String,
}

impl Finish<'_> {
    /// Resolves the references to types that are not described on their own, and simplifies the rest:
    /// a field that may be absent is not `null`, unless it says so by `nullable`.
    fn schema(&self, schema: Json) -> Json {
        match schema {
            Json::Array(items) => items.into_iter().map(|item| self.schema(item)).collect(),
            Json::Object(fields) => self.object(fields),
            other => other,
        }
    }

    fn object(&self, fields: Map<String, Json>) -> Json {
        let mut object = self.resolved(fields);
        for (key, value) in &mut object {
            *value = match (key.as_str(), &mut *value) {
                ("description", Json::String(text)) => Json::from(one_line(text)),
                ("properties", Json::Object(all)) => {
                    all.iter_mut().map(|(name, field)| (name.clone(), self.schema(field.take()))).collect()
                }
                (_, value) => self.schema(value.take()),
            };
        }
        // The sizes of numbers in memory are not those of JSON.
        object.remove("format");
        simplify_names(&mut object);
        simplify_null(&mut object);
        let required = object.get("required").cloned().unwrap_or_default();
        for (name, field) in object.get_mut("properties").and_then(Json::as_object_mut).into_iter().flatten()
        {
            let is_required = required.as_array().is_some_and(|r| r.contains(&json!(name)));
            if let Json::Object(field) = field
                && field.remove("nullable").is_none()
                && !is_required
            {
                never_null(field);
            }
        }
        Json::Object(object)
    }

    /// Follows the reference of a schema. Its other fields win.
    fn resolved(&self, mut fields: Map<String, Json>) -> Map<String, Json> {
        let name =
            |fields: &Map<String, Json>| Some(fields.get("$ref")?.as_str()?.rsplit_once('/')?.1.to_owned());
        while let Some(name) = name(&fields) {
            let own = |names: &[&str]| names.contains(&name.as_str());
            let address = match () {
                () if own(PARTS) => format!("{}#/$defs/{name}", self.common),
                () if own(INNER) => format!("{name}.json"),
                () => String::new(),
            };
            if !address.is_empty() {
                fields.insert("$ref".to_owned(), address.into());
                break;
            }
            fields.remove("$ref");
            let mut all = self.definitions.get(&name).and_then(Json::as_object).cloned().unwrap_or_default();
            all.extend(fields);
            fields = all;
        }
        fields
    }
}

/// Formats a comment as one line without links.
fn one_line(text: &str) -> String {
    text.replace('\n', " ").replace("[`", "`").replace("`]", "`")
}

/// Lists the names of an enumeration instead of describing each.
fn simplify_names(schema: &mut Map<String, Json>) {
    let Some(Json::Array(variants)) = schema.get("oneOf") else { return };
    let Some(names) = variants.iter().map(|v| v.get("const").cloned()).collect::<Option<Vec<_>>>() else {
        return;
    };
    schema.remove("oneOf");
    schema.insert("type".to_owned(), "string".into());
    schema.insert("enum".to_owned(), names.into());
}

/// Writes "a type, or null" as the two names of one type, if the type has a name.
fn simplify_null(schema: &mut Map<String, Json>) {
    let Some(Json::Array(kinds)) = schema.get_mut("anyOf") else { return };
    let [Json::Object(kind), null] = kinds.as_mut_slice() else { return };
    if null["type"] != "null" || !kind.get("type").is_some_and(Json::is_string) {
        return;
    }
    let mut kind = std::mem::take(kind);
    kind["type"] = json!([kind["type"], "null"]);
    if let Some(Json::Array(names)) = kind.get_mut("enum") {
        names.push(Json::Null);
    }
    schema.remove("anyOf");
    kind.append(schema);
    *schema = kind;
}

/// Removes `null` from the values of a schema.
fn never_null(schema: &mut Map<String, Json>) {
    if let Some(Json::Array(types)) = schema.get("type")
        && let [first, _] = types.as_slice()
    {
        let first = first.clone();
        schema.insert("type".to_owned(), first);
    }
    if let Some(Json::Array(names)) = schema.get_mut("enum") {
        names.retain(|name| !name.is_null());
    }
    if let Some(Json::Array(kinds)) = schema.get("anyOf")
        && let [Json::Object(kind), null] = kinds.as_slice()
        && null["type"] == "null"
    {
        let mut kind = kind.clone();
        schema.remove("anyOf");
        kind.append(schema);
        *schema = kind;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_field_that_may_be_absent_is_null_only_if_it_says_so() {
        let schemas = schemas();
        let property = &schemas["reach"]["properties"]["properties"]["items"];
        assert_eq!(property["properties"]["reason"]["type"], "string");
        assert_eq!(property["properties"]["value"]["anyOf"][1]["type"], "null");
        assert!(!property["required"].as_array().unwrap().contains(&json!("value")));
    }

    #[test]
    fn a_field_of_one_kind_of_objects_is_optional() {
        let kind = |name: &str| json!({"properties": {"both": {"type": "string"}, name: {"type": "integer"}}, "required": ["both", name]});
        let mut schema = kind("one");
        either(&mut schema, kind("other"));
        assert_eq!(schema["required"], json!(["both"]));
        assert_eq!(schema["properties"].as_object().unwrap().len(), 3);
    }
}
