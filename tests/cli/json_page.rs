//! `docs/json.md` names each field of each `--json` object with its type, and no field that does
//! not occur.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::{Map, Value};

use crate::common::{Scratch, run};

/// The section with the fields that most reports share.
const SHARED: &str = "every report";

/// A row of a table of fields.
struct Row {
    /// The type, such as `count`, `list of strings` or the section of an object.
    ty: String,
    /// The field is present and not null in every object.
    always: bool,
}

/// The fields of each section of the page, by path.
type Page = BTreeMap<String, BTreeMap<String, Row>>;

/// Reads the tables of the page that have fields.
fn page() -> Page {
    let text = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/docs/json.md")).unwrap();
    let (mut page, mut section, mut fields) = (Page::new(), String::new(), false);
    for line in text.lines() {
        if let Some(heading) = line.strip_prefix('#') {
            section = heading.trim_start_matches('#').trim().to_lowercase();
        }
        fields = line.starts_with("| field |") || (fields && line.starts_with('|'));
        let cells: Vec<&str> = line.trim_matches('|').split(" | ").map(str::trim).collect();
        if let (true, [path, ty, _, absent]) = (fields, cells.as_slice())
            && let Some(path) = path.strip_prefix('`').and_then(|path| path.strip_suffix('`'))
        {
            let ty = ty.trim_start_matches('[').split(']').next().unwrap().to_owned();
            let row = Row { ty, always: *absent == "–" };
            let double = page.entry(section.clone()).or_default().insert(path.to_owned(), row);
            assert!(double.is_none(), "{section}: `{path}` twice");
        }
    }
    page
}

/// The comparison of objects with the page.
struct Audit {
    page: Page,
    seen: BTreeSet<(String, String)>,
    faults: BTreeSet<String>,
}

impl Audit {
    /// Compares an object with the section that its schema names.
    fn report(&mut self, report: &Value) {
        let schema = report["schema"].as_str().unwrap_or_default();
        let name = schema.strip_prefix("meliora.").and_then(|name| name.strip_suffix("/1"));
        match (name.filter(|name| self.page.contains_key(*name)), report.as_object()) {
            (Some(name), Some(object)) => self.object(name, "", object),
            _ => self.fault(format!("no section for the schema `{schema}`")),
        }
    }

    fn fault(&mut self, fault: String) {
        self.faults.insert(fault);
    }

    /// Compares the fields of an object with the rows of `section` that begin with `prefix`.
    fn object(&mut self, section: &str, prefix: &str, object: &Map<String, Value>) {
        for (key, value) in object {
            let path = format!("{prefix}{key}");
            let has = |name: &&str| self.page.get(*name).is_some_and(|rows| rows.contains_key(&path));
            let Some(home) = [section, SHARED].into_iter().find(has) else {
                self.fault(format!("{section}: no row for `{path}`"));
                continue;
            };
            let row = &self.page[home][&path];
            let (ty, always) = (row.ty.clone(), row.always);
            self.seen.insert((home.to_owned(), path.clone()));
            match value {
                Value::Null if always => self.fault(format!("{section}: `{path}` can be null")),
                Value::Null => (),
                // Fields of an inner object can be in the section of the report itself.
                Value::Object(inner) if ty == "object" => self.object(section, &format!("{path}."), inner),
                _ => self.value(home, &path, &ty, value),
            }
        }
        let parent = |path: &str| path.rfind('.').map_or("", |dot| &path[..=dot]) == prefix;
        let rows = self.page.get(section).into_iter().flatten();
        let absent = rows.filter(|(path, row)| row.always && parent(path));
        let absent = absent.filter(|(path, _)| !object.contains_key(&path[prefix.len()..]));
        let faults: Vec<_> = absent.map(|(path, _)| format!("{section}: `{path}` can be absent")).collect();
        self.faults.extend(faults);
    }

    /// Compares a value with its type.
    fn value(&mut self, section: &str, path: &str, ty: &str, value: &Value) {
        if let Some(items) = ty.strip_prefix("list of ") {
            let item = items.trim_end_matches('s');
            let Some(values) = value.as_array() else {
                return self.fault(format!("{section}: `{path}` is not a list: {value}"));
            };
            values.iter().for_each(|value| self.value(section, &format!("{path}[]"), item, value));
            return;
        }
        match (ty, value) {
            ("report", _) => return self.report(value),
            ("object", Value::Object(object)) => return self.object(section, &format!("{path}."), object),
            (name, Value::Object(object)) if self.page.contains_key(name) => {
                return self.object(name, "", object);
            }
            _ => (),
        }
        let is_value = |v: &Value| v.is_boolean() || v.is_i64() || v.is_string();
        let fits = match ty {
            "string" => value.is_string(),
            "count" => value.as_str().is_some_and(|n| !n.is_empty() && n.bytes().all(|b| b.is_ascii_digit())),
            "integer" => value.is_i64() || value.is_u64(),
            "number" => value.is_number(),
            "bound" => value.is_number() || value == "inf",
            "boolean" => value.is_boolean(),
            "rank" => value.is_u64() || value == "unbounded",
            "state" => value.as_object().is_some_and(|state| state.values().all(is_value)),
            "map" => value.is_object(),
            _ => false,
        };
        if !fits {
            self.fault(format!("{section}: `{path}` is not of type {ty}: {value}"));
        }
    }

    /// The rows whose field did not occur.
    fn unseen(&self) -> Vec<String> {
        let rows = self.page.iter().flat_map(|(section, rows)| rows.keys().map(move |path| (section, path)));
        let unseen =
            rows.filter(|(section, path)| !self.seen.contains(&((*section).clone(), (*path).clone())));
        unseen.map(|(section, path)| format!("{section}: `{path}`")).collect()
    }
}

/// Commands with their exit status. TOY and ROBOT are a model with its preferences, OUT is a new
/// folder, TINY is a model with options under which the explicit engine runs out of memory.
const COMMANDS: &[(i32, &str)] = &[
    (0, "check TOY"),
    (0, "check TOY --safety prefix --engine explicit"),
    (0, "check ROBOT --max-level 1"),
    (0, "check models/courier.prism models/courier.pref"),
    (0, "check POND"),
    (0, "strategy TOY --kind achieve --objective First --at s=5"),
    (0, "simulate TOY --kind achieve --objective First --at s=5"),
    (0, "check models/counter.prism models/counter.pref --jointly"),
    (4, "check TINY models/scramble.pref"),
    (0, "reach models/toy.prism --target s=3"),
    (1, "reach models/toy.prism --property P>=1[F(s=3)]"),
    (1, "reach models/toy.prism --properties OUT/some.props"),
    (0, "reach OUT/paid.prism --property Rmin=?[F(x=0)]"),
    (0, "reach models/pond.prism --target at=5 --require G(at!=4)"),
    (0, "reach OUT/paid.prism --property Pmax=?[F(x=1)]"),
    (0, "info OUT/paid.prism"),
    (4, "reach TINY --target oil=1"),
    (0, "info models/toy.prism"),
    (0, "info models/courier.prism --preferences models/courier.pref --engine explicit"),
    (0, "info models/workshop.jani -c N=1"),
    (4, "info TINY"),
    (0, "strategy TOY"),
    (0, "strategy TOY --rank 0"),
    (0, "strategy POND"),
    (0, "strategy ROBOT --kind spi --at b=8"),
    (0, "strategy models/courier.prism models/courier.pref --kind spi --safety prefix"),
    (4, "strategy TINY models/scramble.pref"),
    (0, "values TOY --within 2 --exact"),
    (0, "values POND --all"),
    (0, "values models/courier.prism models/courier.pref --safety transition"),
    (4, "values TINY models/scramble.pref"),
    (0, "strategy TOY --choose cheap"),
    (0, "simulate TOY --runs 3"),
    (0, "simulate TOY --choose cheap"),
    (0, "simulate POND --runs 1"),
    (0, "simulate ROBOT --kind spi --strategy permissive --runs 3"),
    (4, "simulate TINY models/scramble.pref"),
    (0, "export TOY --out OUT/dump"),
    (0, "export TOY --out OUT/values --values"),
    (0, "export TOY --out OUT/drn --format drn"),
    (0, "export TOY --out OUT/induced --format explicit --strategy sasi:progress"),
    (0, "query OUT/dump reachable"),
    (1, "query OUT/dump reachable --where s>1 --contains s=0 --list 1"),
    (0, "query OUT/dump strategy:sasi:1 --count --contains s=0 --list 1"),
    (0, "verify OUT/dump TOY"),
    (1, "verify OUT/dump models/toy.prism models/lateral.pref"),
    (0, "compare TOY"),
    (0, "compare TOY --membership 1"),
    (0, "report TOY --out OUT/page.html"),
    (0, "report TOY --out OUT/order.dot --format dot"),
    (0, "check models/chain.prism models/chain.pref -c N={1,2}"),
    (0, "reach models/chain.prism --target x=1 -c N=-1:1"),
    (2, "check"),
    (3, "check models/toy.prism missing"),
    (3, "reach models/toy.prism --target t"),
];

const PAID: &str = "mdp module m x : [0..1] init 1; [] true -> true; endmodule\n\
    rewards \"pay\" true : 1; endrewards rewards true : y; endrewards";
const PROPERTIES: &str = "\"sure\": Pmax>=1 [ F s=3 ];\nP=? [ F s=3 ];\n";

#[test]
fn the_page_of_json_names_every_field_and_no_other() {
    let scratch = Scratch::new(&[("some.props", PROPERTIES), ("paid.prism", PAID)]);
    let mut audit = Audit { page: page(), seen: BTreeSet::new(), faults: BTreeSet::new() };
    for (status, command) in COMMANDS {
        let tiny = "models/scramble.prism -c cells=10007 --engine explicit --memory 1MiB";
        let command = command
            .replace("TOY", "models/toy.prism models/toy.pref")
            .replace("ROBOT", "models/robot5x5.prism models/robot5x5.pref")
            .replace("POND", "models/pond.prism models/pond.pref")
            .replace("TINY", tiny)
            .replace("OUT", &scratch.show(""));
        audit.report(&run(&format!("{command} --json")).expect(*status).json());
    }
    let faults: Vec<_> = audit.faults.iter().collect();
    assert!(faults.is_empty(), "docs/json.md and the output differ:\n{faults:#?}");
    let unseen = audit.unseen();
    assert!(unseen.is_empty(), "docs/json.md has fields that no output has:\n{unseen:#?}");
}

#[test]
fn an_object_that_the_page_does_not_describe_is_noticed() {
    let faults = |report: Value| {
        let mut audit = Audit { page: page(), seen: BTreeSet::new(), faults: BTreeSet::new() };
        audit.report(&report);
        audit.faults.into_iter().collect::<Vec<_>>().join("; ")
    };
    let error =
        serde_json::json!({"schema": "meliora.error/1", "kind": "input", "message": "m", "file": null});
    assert_eq!(faults(error.clone()), "");
    let changed = |key: &str, value: Value| {
        let mut changed = error.clone();
        changed[key] = value;
        faults(changed)
    };
    assert_eq!(changed("hint", "h".into()), "error: no row for `hint`");
    assert_eq!(changed("kind", Value::Null), "error: `kind` can be null");
    assert_eq!(changed("line", "7".into()), "error: `line` is not of type integer: \"7\"");
    assert_eq!(changed("schema", "meliora.other/1".into()), "no section for the schema `meliora.other/1`");
}
