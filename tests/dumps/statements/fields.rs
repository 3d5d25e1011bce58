//! The fields of the manifest, and those that it may have.

use super::{Counts, Place, least, places};
use crate::common::prelude::*;

/// Fields that nothing proves: any text is accepted.
const INFORMATIVE: &[&str] = meliora::certify::INFORMATIVE;

/// The fields that an object may have or not, by the place of the object, with values.
fn optional(place: &str) -> Vec<(&'static str, Json)> {
    let order = json!([{"variable": "x", "reversed": false}, {"variable": "b", "reversed": true}]);
    match place {
        "" => vec![
            ("exact", json!({"p": "1/3"})),
            ("players", json!(["us"])),
            ("coalition", json!(["us"])),
            ("history", json!("play")),
            ("requirements", json!(["G x!=1"])),
            ("questions", json!([{"name": null, "text": "x=1", "regions": ["initial"]}])),
            ("max_level", json!(1)),
            ("questions", json!([{"name": null, "text": "F x=1", "regions": ["initial"]}])),
            (
                "values",
                json!({"path": "values.csv", "sha256": "", "levels": 1, "reward": "steps", "rows": 0}),
            ),
        ],
        "regions" | "certificate" => vec![("order", order.clone()), ("order_of_rounds", order)],
        "regions.roots[]" | "certificate.roots[]" => {
            vec![("dot", json!("reachable.dot")), ("trend", json!("falling")), ("trend", json!("rising"))]
        }
        "encoding.variables[]" => {
            vec![("values", json!(["a", "b"])), ("facts", json!(["", "a"])), ("observer", json!(true))]
        }
        _ => Vec::new(),
    }
}

/// The words of a field that has few.
fn words(kind: &str) -> &'static [&'static str] {
    match kind {
        "scope" => &["reachable", "all"],
        "safety" => &["action", "transition", "prefix"],
        "empty" => &["bottom", "gain", "incomparable"],
        "history" => &["play", "state"],
        "encoding.variables[].type" => &["bool", "int"],
        "regions.roots[].kind" | "certificate.roots[].kind" => &["states", "choices"],
        "regions.roots[].trend" | "certificate.roots[].trend" => &["falling", "rising"],
        _ => &[],
    }
}

/// Other values of a field.
fn others(kind: &str, value: &Json) -> Vec<Json> {
    let all = match value {
        Json::Null => vec![json!(1), json!("x"), json!({})],
        Json::Bool(b) => vec![json!(!b)],
        Json::Number(n) => {
            let n = n.as_f64().unwrap();
            [n + 1.0, n - 1.0, 0.0, 1e300]
                .iter()
                .map(|x| if x.fract() == 0.0 && x.abs() < 1e15 { json!(*x as i64) } else { json!(x) })
                .collect()
        }
        Json::String(s) => {
            let words = words(kind).iter().map(|word| json!(word));
            words.chain([json!(format!("{s}x")), json!(""), json!(s.to_uppercase())]).collect()
        }
        Json::Array(all) => {
            let reversed = all.iter().rev().cloned().collect();
            let twice = all.iter().chain(all.first()).cloned().collect();
            vec![json!([]), reversed, twice, all.iter().skip(1).cloned().collect(), Json::Null]
        }
        Json::Object(all) => {
            let without = |name: &String| {
                let mut rest = all.clone();
                rest.remove(name);
                Json::Object(rest)
            };
            let mut more = all.clone();
            more.insert("note".to_owned(), json!("checked by hand"));
            all.keys().map(without).chain([Json::Object(more), Json::Null]).collect()
        }
    };
    all.into_iter().filter(|other| other != value).collect()
}

/// Calls `visit` with the pointer and the kind of each value: the path without numbers.
fn walk(value: &Json, pointer: &str, kind: &str, visit: &mut dyn FnMut(&str, &str, &Json)) {
    visit(pointer, kind, value);
    match value {
        Json::Array(all) => {
            for (at, item) in all.iter().enumerate() {
                walk(item, &format!("{pointer}/{at}"), &format!("{kind}[]"), visit);
            }
        }
        Json::Object(all) => {
            for (name, item) in all {
                // The names of constants are no fields.
                let kind = match kind {
                    "" => name.clone(),
                    "constants" | "exact" => kind.to_owned(),
                    _ => format!("{kind}.{name}"),
                };
                walk(item, &format!("{pointer}/{name}"), &kind, visit);
            }
        }
        _ => {}
    }
}

impl Place {
    /// Judges a manifest with another value at a place.
    fn is_value_refused(&mut self, all: &Json, pointer: &str, value: Json) -> bool {
        let mut edited = all.clone();
        *edited.pointer_mut(pointer).unwrap() = value;
        self.put_manifest(&edited.to_string());
        self.is_refused(pointer)
    }
}

#[test]
fn each_field_of_a_manifest_is_proved_or_said_to_inform_only() {
    let mut counts = Counts::new();
    for mut place in places() {
        let all = serde_json::to_value(&place.honest.manifest).unwrap();
        let mut fields = Vec::new();
        walk(&all, "", "", &mut |pointer, kind, value| {
            fields.push((pointer.to_owned(), kind.to_owned(), value.clone()));
        });
        assert!(!place.is_value_refused(&all, "", all.clone()), "an honest dump is refused");
        for (pointer, kind, value) in fields {
            for (name, more) in optional(&kind) {
                let absent = value.get(name).is_none_or(Json::is_null);
                let Some(mut with) = value.as_object().filter(|_| absent).cloned() else { continue };
                let kind = format!("{kind}.{name}");
                let kind = kind.trim_start_matches('.');
                if counts.takes(kind) {
                    with.insert(name.to_owned(), more);
                    counts.record(kind, &[place.is_value_refused(&all, &pointer, Json::Object(with))]);
                }
            }
            if !counts.takes(&kind) {
                continue;
            }
            let others = others(&kind, &value).into_iter();
            let refused: Vec<bool> =
                others.map(|other| place.is_value_refused(&all, &pointer, other)).collect();
            if !kind.is_empty() {
                counts.record(&kind, &refused);
            }
            if INFORMATIVE.contains(&kind.as_str()) {
                assert!(!refused.contains(&true), "{kind}");
            }
        }
    }
    let [statements, edits, refused] = counts.close();
    assert!(
        statements > least(3000) && edits > least(10_000) && refused * 10 > edits * 9,
        "{statements} {edits} {refused}"
    );
}
