//! The types of the reports give a JSON schema of each `--json` object. Every output fits its schema, in the order of
//! its fields too, and every field occurs in some output.

use serde_json::{Map, Value};

use crate::cli::direction::{lamps_and, power, register};
use crate::cli::schema::Validator;
use crate::common::prelude::*;

/// The schema of the parts that several reports have.
const COMMON: &str = "common";

/// A field: its type in words, and whether it is in every object and never null.
type Field = (String, bool);
/// The fields of each report and part, by path.
type Fields = BTreeMap<String, BTreeMap<String, Field>>;

/// Returns the schemas, by name. They are made strict: a field that they do not name is an error.
fn schemas() -> BTreeMap<&'static str, Value> {
    let mut schemas = meliora_report::schema::schemas();
    schemas.values_mut().for_each(forbid_others);
    schemas
}

fn forbid_others(schema: &mut Value) {
    if let Value::Object(object) = schema {
        let types = object.get("type");
        let is_object = types.is_some_and(|ty| *ty == "object" || ty[0] == "object");
        if is_object && object.contains_key("properties") {
            object.entry("additionalProperties").or_insert(false.into());
        }
        object.values_mut().for_each(forbid_others);
    } else if let Value::Array(items) = schema {
        items.iter_mut().for_each(forbid_others);
    }
}

/// Returns the fields that the schemas name: those of each report, and of each common part.
fn described(schemas: &BTreeMap<&'static str, Value>) -> Fields {
    let all = meliora_report::fields::fields(schemas).into_iter();
    let known =
        |field: meliora_report::fields::Field| (field.path, (field.kind, !field.optional && !field.nullable));
    all.map(|(name, fields)| (name, fields.into_iter().map(known).collect())).collect()
}

/// Checks that the fields of a value and of all its parts come in the order of the schema.
fn in_order(schemas: &BTreeMap<&'static str, Value>, schema: &Value, value: &Value) {
    if schema["anyOf"][1].get("$ref").is_some() {
        return in_order(schemas, &schemas[name_of(value)], value);
    }
    let schema = followed(schemas, schema);
    match value {
        Value::Object(fields) => {
            let Some(named) = schema["properties"].as_object() else { return };
            let place = |name: &String| named.keys().position(|other| other == name);
            assert!(fields.keys().map(place).is_sorted(), "{:?}, not {:?}", fields.keys(), named.keys());
            fields.iter().for_each(|(name, value)| in_order(schemas, &named[name], value));
        }
        Value::Array(items) => items.iter().for_each(|item| in_order(schemas, &schema["items"], item)),
        _ => {}
    }
}

/// Returns the schema to which a reference leads.
fn followed<'s>(schemas: &'s BTreeMap<&'static str, Value>, schema: &'s Value) -> &'s Value {
    let reference = schema["$ref"].as_str().or(schema["anyOf"][0]["$ref"].as_str());
    let Some(reference) = reference else { return schema };
    let (file, place) = reference.split_once('#').unwrap_or((reference, ""));
    let name = file.strip_suffix(".json").unwrap_or(COMMON);
    schemas[name].pointer(place).unwrap()
}

/// The fields that occur in reports, by section and path.
struct Seen<'f> {
    fields: &'f Fields,
    found: BTreeSet<(&'f str, String)>,
}

impl<'f> Seen<'f> {
    /// Adds the fields of an object that lie under `prefix` in a section.
    fn add(&mut self, section: &'f str, prefix: &str, object: &Map<String, Value>) {
        for (key, value) in object {
            let path = format!("{prefix}{key}");
            let Some((ty, _)) = self.fields[section].get(&path) else { continue };
            self.found.insert((section, path.clone()));
            self.inside(section, path, ty, value);
        }
    }

    fn inside(&mut self, section: &'f str, path: String, ty: &str, value: &Value) {
        if let (Some(items), Some(values)) = (ty.strip_prefix("list of "), value.as_array()) {
            let item = if items.starts_with("list") { items } else { items.trim_end_matches('s') };
            values.iter().for_each(|value| self.inside(section, format!("{path}[]"), item, value));
        } else if let Some(object) = value.as_object() {
            let name = if ty == "report" { name_of(value) } else { ty };
            match self.fields.get_key_value(name) {
                Some((section, _)) => self.add(section, "", object),
                None => self.add(section, &format!("{path}."), object),
            }
        }
    }
}

/// Returns the name of the schema of a report.
fn name_of(report: &Value) -> &str {
    let schema = report["schema"].as_str().unwrap_or_default();
    schema.strip_prefix("meliora.").and_then(|name| name.strip_suffix("/1")).unwrap_or(schema)
}

/// Commands with their exit status. TOY and ROBOT are a model with its preferences, OUT is a new
/// folder, TINY is a model with options under which the explicit engine runs out of memory.
const COMMANDS: &[(i32, &str)] = &[
    (0, "check TOY"),
    (0, "check TOY --safety action --engine explicit"),
    (0, "check ROBOT --max-level 1"),
    (0, "check models/courier.prism models/courier.pref"),
    (0, "check POND"),
    (0, "check models/pursuit.prism models/pursuit.pref -c N=4 --coalition guard"),
    (0, "strategy TOY --kind achieve --objective First --at s=5"),
    (0, "simulate TOY --kind achieve --objective First --at s=5"),
    (0, "check models/counter.prism models/counter.pref --jointly"),
    (0, "check models/toy.prism OUT/many.pref --jointly"),
    (4, "check TINY models/scramble.pref"),
    (0, "reach models/toy.prism --target s=3"),
    (1, "reach models/toy.prism --property P>=1[F(s=3)]"),
    (0, "reach models/toy.prism --property filter(printall,s>=0,true)"),
    (0, "reach models/toy.prism --property multi(Pmax=?[F(s=3)],Pmax=?[F(s=2)])"),
    (0, "reach models/toy.prism --property filter(print,Pmax=?[F(s=3)],true)"),
    (1, "reach models/toy.prism --properties OUT/some.props"),
    (0, "reach OUT/paid.prism --property Rmin=?[F(x=0)]"),
    (0, "reach models/pond.prism --target at=5 --require G(at!=4)"),
    (0, "reach models/pond.prism --target at=5 --stop-at-target"),
    (0, "reach OUT/register.prism --property Pmax>0[F(done)]"),
    (1, "reach OUT/lamps.pddl OUT/dark.pddl"),
    (0, "reach models/responders.pddl --property Pmax>=1[F(\"goal\")] --property Pmax>0[F(\"goal\")]"),
    (0, "reach OUT/paid.prism --property Pmax=?[F(x=1)]"),
    (0, "reach models/toy.prism --target s=3 --out OUT/regions"),
    (0, "reach models/responders.pddl --strong --policy OUT/policy.txt"),
    (0, "verify OUT/policy.txt models/responders.pddl"),
    (1, "verify OUT/policy.txt models/responders.pddl --strong"),
    (0, "simulate models/responders.pddl --policy OUT/policy.txt --runs 3"),
    (0, "reach models/toy.prism --property multi(Pmax=?[F(s=3)],P>=0.25[F(s=2)]) --policy OUT/mix.json"),
    (0, "verify OUT/mix.json models/toy.prism"),
    (0, "simulate models/toy.prism --policy OUT/mix.json --runs 20"),
    (0, "strategy TOY --kind plan --policy OUT/nodes.json"),
    (0, "verify OUT/nodes.json TOY"),
    (0, "simulate TOY --policy OUT/nodes.json --runs 3"),
    (0, "info OUT/paid.prism"),
    (0, "info OUT/rounded.prism"),
    (0, "info OUT/third.prism -c p=1/3"),
    (4, "reach TINY --target oil=1"),
    (0, "info models/toy.prism"),
    (0, "info models/courier.prism --preferences models/courier.pref --engine explicit"),
    (0, "info models/workshop.jani -c N=1"),
    (0, "info models/pursuit.prism -c N=4"),
    (4, "info TINY"),
    (0, "strategy TOY"),
    (0, "strategy TOY --rank 0"),
    (0, "strategy TOY --all"),
    (0, "strategy OUT/again.prism OUT/again.pref --kind spi --safety action"),
    (0, "strategy POND"),
    (0, "strategy models/pursuit.prism models/pursuit.pref -c N=4 --at x=1,y=0,g=1,robots_turn=false"),
    (0, "strategy ROBOT --kind spi --at b=8"),
    (0, "strategy models/courier.prism models/courier.pref --kind spi --safety prefix"),
    (4, "strategy TINY models/scramble.pref"),
    (0, "values TOY --within 2 --exact --by-goal"),
    (0, "values POND --all"),
    (0, "values models/courier.prism models/courier.pref --safety transition"),
    (4, "values TINY models/scramble.pref"),
    (
        0,
        "shield models/toy.prism --property <n,PreSafety,gamma=0.5>Pmax=?[F<=2(s=3)] --limit 1 --out OUT/shield",
    ),
    (0, "shield models/pursuit.prism -c N=4 --property <<robot>>Pmin=?[F(x=0)] --threshold 0.5"),
    (0, "strategy TOY --choose cheap"),
    (0, "strategy models/drone.prism models/drone.pref --kind achieve --objective Cabin --choose likely"),
    (0, "simulate models/drone.prism models/drone.pref --kind achieve --objective Cabin --choose likely"),
    (0, "simulate TOY --runs 3"),
    (0, "simulate TOY --choose cheap"),
    (0, "simulate POND --runs 1"),
    (0, "simulate models/pursuit.prism models/pursuit.pref -c N=4 --runs 2 --opponent worst"),
    (0, "simulate OUT/cross.prism OUT/cross.pref --runs 1"),
    (0, "simulate ROBOT --kind spi --scheduler permissive --runs 3"),
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

/// Removes each field of a report, and gives each value another type: the schema notices it. Kinds of places that an
/// earlier report had are left out.
fn notices(
    validator: &Validator<'_>,
    tried: &mut BTreeSet<String>,
    fields: &BTreeMap<String, Field>,
    report: &Value,
) {
    let kind = name_of(report);
    for (name, (_, always)) in fields.iter().filter(|(name, _)| report.get(name).is_some()) {
        if *always && tried.insert(format!("{kind} {name}")) {
            let mut less = report.clone();
            less.as_object_mut().unwrap().shift_remove(name);
            assert!(!validator.fits(kind, &less), "`{name}` is missing in {less}");
        }
    }
    let mut places = Vec::new();
    leaves(report, String::new(), &mut places);
    // All items of a list have one schema.
    let of_items = |place: &String| place.replace(|c: char| c.is_ascii_digit(), "");
    places.retain(|place| tried.insert(format!("{kind} {}", of_items(place))));
    for place in places {
        let mut other = report.clone();
        *other.pointer_mut(&place).unwrap() = json!([{"another": "type"}]);
        assert!(!validator.fits(kind, &other), "another type at {place}");
    }
}

/// Returns the examples in the help of the commands that have no run of their own in [`COMMANDS`].
fn examples<'n>(names: impl Iterator<Item = &'n &'static str>) -> Vec<String> {
    let is_new = |name: &&&str| {
        let has_run = COMMANDS.iter().any(|(_, command)| command.split(' ').next() == Some(**name));
        !has_run && ![COMMON, "error", "sweep", "policy"].contains(*name)
    };
    let help = |name: &&str| run!("{name} --help").expect(0).stdout;
    let texts: Vec<String> = names.filter(is_new).map(help).collect();
    let own = |line: &str| Some(line.strip_prefix("  meliora ")?.replace(" --json", ""));
    texts.iter().flat_map(|text| text.lines()).filter_map(own).collect()
}

/// Lists the places of all values, except for those whose type depends on the input.
fn leaves(value: &Value, place: String, places: &mut Vec<String>) {
    match value {
        Value::Object(fields) => {
            let fixed = fields
                .iter()
                .filter(|(name, _)| !["constants", "exact_constants", "ranges"].contains(&name.as_str()));
            fixed.for_each(|(name, value)| leaves(value, format!("{place}/{name}"), places));
        }
        Value::Array(items) => {
            items.iter().enumerate().for_each(|(i, value)| leaves(value, format!("{place}/{i}"), places));
        }
        _ => places.push(place),
    }
}

const ROUNDED: &str =
    "mdp module m x : [0..1]; [] x=0 -> log(2,3)/2 : (x'=1) + 1-log(2,3)/2 : true; endmodule";

const THIRD: &str = "mdp const double p; module m x : [0..1]; [] x=0 -> p : (x'=1) + 1-p : true; endmodule";

const PAID: &str = "mdp module m x : [0..1] init 1; [] true -> true; endmodule\n\
    rewards \"pay\" true : 1; endrewards rewards true : y; endrewards";
/// A game in which an improvement can be made again and again.
const AGAIN: &str = "smg player p [try], [back], [stay] endplayer player q [home] endplayer\n\
    module m x : [0..4]; [try] x=0 -> 0.5: (x'=1) + 0.5: (x'=2); [stay] x=1 -> (x'=3);\n\
    [back] x=1 -> (x'=4); [home] x=4 -> (x'=0); [stay] x=2 | x=3 -> true; endmodule";
const PROPERTIES: &str = "\"sure\": Pmax>=1 [ F s=3 ];\nP=? [ F s=3 ];\n";

#[test]
fn every_output_fits_its_schema_and_every_field_occurs() {
    let many: String = (0..11).map(|i| format!("objective o{i} = F s>={};", i % 3)).collect();
    let register = register();
    let [lamps, problem] = lamps_and(24, &power("(power) (blown)"));
    let own = [
        ("some.props", PROPERTIES),
        ("paid.prism", PAID),
        ("register.prism", &register),
        ("lamps.pddl", &lamps),
        ("dark.pddl", &problem),
        ("rounded.prism", ROUNDED),
        ("third.prism", THIRD),
        ("many.pref", &many),
    ];
    let again = [("again.prism", AGAIN), ("again.pref", "objective B = F x=3; empty = gain;")];
    let scratch = Scratch::new(&[&own[..], &again, &crate::cli::strategies::CROSS].concat());
    let schemas = schemas();
    let (validator, fields) = (Validator(&schemas), described(&schemas));
    let (mut seen, mut tried) = (Seen { fields: &fields, found: BTreeSet::new() }, BTreeSet::new());
    let others = examples(schemas.keys());
    let others = others.iter().map(|command| (&0, command.as_str()));
    for (status, command) in COMMANDS.iter().map(|(status, command)| (status, *command)).chain(others) {
        let tiny = "models/scramble.prism -c cells=10007 --engine explicit --memory 1MiB";
        let command = command
            .replace("TOY", "models/toy.prism models/toy.pref")
            .replace("ROBOT", "models/robot5x5.prism models/robot5x5.pref")
            .replace("POND", "models/pond.prism models/pond.pref")
            .replace("TINY", tiny)
            .replace("OUT", &scratch.show(""));
        let report = run!("{command} --json").expect(*status).json();
        let faults = validator.faults(name_of(&report), &report);
        assert!(faults.is_empty(), "{command}: {faults:#?}");
        in_order(&schemas, &schemas[name_of(&report)], &report);
        notices(&validator, &mut tried, &fields[name_of(&report)], &report);
        let (section, _) = fields.get_key_value(name_of(&report)).unwrap();
        seen.add(section, "", report.as_object().unwrap());
    }
    // The fields of an incomplete report occur in some report, not in each kind.
    let rows = fields.iter().flat_map(|(section, rows)| rows.keys().map(move |path| (section, path)));
    let is_seen = |section: &str, path: &str| match path {
        "complete" | "error" => seen.found.iter().any(|(_, own)| own == path),
        _ => seen.found.contains(&(section, path.to_owned())),
    };
    let unseen: Vec<_> = rows.filter(|(section, path)| !is_seen(section, path)).collect();
    assert!(unseen.is_empty(), "fields that no output has: {unseen:#?}");
}

#[test]
fn an_object_that_does_not_fit_is_noticed() {
    let schemas = schemas();
    let fits = |report: &Value| Validator(&schemas).fits("error", report);
    let error = json!({
        "schema": "meliora.error/1", "kind": "input", "message": "m", "file": null, "line": 7, "column": null
    });
    assert!(fits(&error));
    let changes = [
        ("hint", json!("h")),
        ("kind", Value::Null),
        ("kind", json!("other")),
        ("line", json!("7")),
        ("schema", json!("meliora.other/1")),
    ];
    for (key, value) in changes {
        let mut changed = error.clone();
        changed[key] = value;
        assert!(!fits(&changed), "{changed}");
    }
}
