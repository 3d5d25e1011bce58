//! `manifest.json`: what the roots of a dump are and how to read its variables.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{self, Read};
use std::path::Path;
use std::{fmt, fs};

use serde::de::{Error as _, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::Value as Json;

use super::{Diagram, Edge};
use crate::error::{Error, Result};
use crate::escape::is_shown;

/// The schema that this version writes and reads.
pub const SCHEMA: &str = "meliora.dump/1";
/// The manifest's name in the directory.
pub const FILE: &str = "manifest.json";
/// The name of the file with the regions.
pub const REGIONS: &str = "regions.dddmp";
/// The name of the file with the certificate.
pub const CERTIFICATE: &str = "certificate.dddmp";
/// The name of the program that writes dumps.
pub const TOOL: &str = "meliora";
/// A manifest is never larger.
const LARGEST: u64 = 256 << 20;
/// Choices are numbered by at most so many bits.
const MOST_CHOICE_BITS: u32 = 20;

/// Everything that is needed to interpret a dump without the model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// [`SCHEMA`]
    pub schema: String,
    /// The program that wrote it.
    pub tool: Tool,
    /// The model.
    pub model: Source,
    /// The values of all constants of the model.
    #[serde(deserialize_with = "each_once")]
    pub constants: BTreeMap<String, Json>,
    /// The names of those that `--const` gave.
    pub given: Vec<String>,
    /// The preference file.
    pub preferences: Source,
    /// The objectives in the order of declaration.
    pub objectives: Vec<String>,
    /// `bottom`, `gain` or `incomparable`.
    pub empty: String,
    /// `play`, where objectives are judged over whole plays; none where they are from the present state on.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub history: Option<String>,
    /// `reachable` or `all`.
    pub scope: String,
    /// `action`, `transition` or `prefix`.
    pub safety: String,
    /// The greatest level that was computed, where `--max-level` cut the search.
    pub max_level: Option<usize>,
    /// How states are bits.
    pub encoding: Encoding,
    /// How choices are bits.
    pub choices: Choices,
    /// `regions.dddmp`
    pub regions: File,
    /// `certificate.dddmp`, if there is one.
    pub certificate: Option<File>,
}

/// The program that wrote a dump.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tool {
    /// `meliora`
    pub name: String,
    /// Its version.
    pub version: String,
}

/// A text that was read.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Source {
    /// Its path as the user gave it.
    pub path: String,
    /// The SHA-256 of its bytes, in hexadecimal.
    pub sha256: String,
}

/// How states are bits: a variable's value is `low` plus the number that its bits make, bit 0 the
/// least significant. Patterns past `high` are no values.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Encoding {
    /// The model's variables in the order of declaration.
    pub variables: Vec<Variable>,
    /// The names of the bits from the root down.
    pub order: Vec<String>,
}

/// A variable of the model.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Variable {
    /// Its name.
    pub name: String,
    /// `bool` or `int`.
    #[serde(rename = "type")]
    pub ty: String,
    /// The smallest value (of a Boolean 0), and what is added to the number of the bits.
    pub low: i64,
    /// The largest value (of a Boolean 1).
    pub high: i64,
    /// How many bits it has.
    pub bits: u32,
    /// The names of its bits, least significant first.
    pub names: Vec<String>,
    /// Its value in the initial state, where there is one for all of them.
    pub initial: Option<i64>,
    /// The names of its values from `low` on, where they have names, as locations do.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub values: Vec<String>,
    /// Whether it is the state of a monitor, which follows what an objective over whole plays asks.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub observer: bool,
}

/// How choices are bits: their number, bit 0 the least significant and deepest; these variables
/// stand above those of the states. Only roots of kind `choices` depend on them.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Choices {
    /// The names of the bits from the root down; none where no root has them.
    pub order: Vec<String>,
    /// What the numbers mean; numbers past these mean nothing.
    pub numbers: Vec<ChoiceNumber>,
}

/// Choices with one number: at most one of them is enabled in a state.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ChoiceNumber {
    /// The number.
    pub number: usize,
    /// The name for people: the label, with commands where several numbers have this label.
    pub name: String,
    /// The label; none where the commands have none.
    pub action: Option<String>,
    /// For each participating module the commands of which one is taken, `module#k`; of a `dtmc`, and
    /// for the self-loop of deadlocks, none.
    pub commands: Vec<Vec<String>>,
}

/// A file with a diagram.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct File {
    /// Its name in the directory.
    pub path: String,
    /// The SHA-256 of its bytes, in hexadecimal.
    pub sha256: String,
    /// How many nodes it has, the terminal among them.
    pub nodes: usize,
    /// What its roots are.
    pub roots: Vec<Root>,
}

/// A named function of a file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Root {
    /// Its name, as in `meliora query`.
    pub name: String,
    /// What it is a set of.
    pub kind: RootKind,
    /// Its position in `.rootids`, from 0.
    pub root: usize,
    /// What stands there: a node, negative where it is complemented.
    pub node: i32,
    /// How many inner nodes it has.
    pub nodes: usize,
    /// How many members it has.
    pub count: String,
    /// Its DOT file, if there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dot: Option<String>,
}

/// What a function is a set of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum RootKind {
    /// States.
    States,
    /// Pairs of a state and a choice enabled there.
    Choices,
}

/// What tells whether the rest can be read.
#[derive(Deserialize)]
struct Head {
    schema: Option<String>,
}

/// A map in which no key is there twice: readers differ in which of the values they take.
fn each_once<'de, D: Deserializer<'de>>(deserializer: D) -> Result<BTreeMap<String, Json>, D::Error> {
    struct Once;
    impl<'de> Visitor<'de> for Once {
        type Value = BTreeMap<String, Json>;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("a map")
        }

        fn visit_map<A: MapAccess<'de>>(self, mut entries: A) -> Result<Self::Value, A::Error> {
            let mut map = BTreeMap::new();
            while let Some((key, value)) = entries.next_entry::<String, Json>()? {
                if map.insert(key.clone(), value).is_some() {
                    return Err(A::Error::custom(format!("`{}` is there twice", key.escape_debug())));
                }
            }
            Ok(map)
        }
    }
    deserializer.deserialize_map(Once)
}

/// A name: something to see, and nothing that moves a cursor.
fn plain(what: &str, name: &str) -> Result<(), String> {
    if name.is_empty() || name.chars().any(|c| c.is_whitespace() || !is_shown(c)) {
        return Err(format!("`{}` is no name of {what}", name.escape_debug()));
    }
    Ok(())
}

impl Variable {
    /// Whether it is a Boolean.
    pub fn is_bool(&self) -> bool {
        self.ty == "bool"
    }

    fn check(&self) -> Result<(), String> {
        let name = &self.name;
        plain("a variable", name)?;
        self.names.iter().try_for_each(|bit| plain("a bit", bit))?;
        if !self.is_bool() && self.ty != "int" {
            return Err(format!(
                "the type of `{name}` is `{}`, neither `bool` nor `int`",
                self.ty.escape_debug()
            ));
        }
        if self.low > self.high || (self.is_bool() && (self.low, self.high) != (0, 1)) {
            return Err(format!("the range of `{name}` is {}..{}", self.low, self.high));
        }
        let width = u64::BITS - (self.high.wrapping_sub(self.low) as u64).leading_zeros();
        if self.bits != width || self.names.len() != width as usize {
            return Err(format!("`{name}` needs {width} bits for its range, not {}", self.bits));
        }
        Ok(())
    }
}

impl File {
    /// The root called `name`.
    pub fn root(&self, name: &str) -> Option<&Root> {
        self.roots.iter().find(|r| r.name == name)
    }

    /// Checks that the roots are those of the diagram, that their names differ, and that arcs are in order.
    fn check(&self, diagram: &Diagram) -> Result<(), String> {
        self.check_names(&self.path)?;
        if !diagram.is_ordered() {
            return Err(format!(
                "`{}` has an arc to a later node, or to a variable that is not deeper",
                self.path
            ));
        }
        if self.nodes != diagram.nodes.len() + 1 {
            return Err(format!("`{}` has {} nodes, not {}", self.path, diagram.nodes.len() + 1, self.nodes));
        }
        let mut positions = BTreeSet::new();
        for root in &self.roots {
            positions.insert(root.root);
            if diagram.roots.get(root.root).map(|e| e.number()) != Some(root.node) {
                return Err(format!("`{}` has no root {} that is node {}", self.path, root.root, root.node));
            }
        }
        let (named, roots) = (self.roots.len(), diagram.roots.len());
        if (named, roots) != (positions.len(), positions.len()) {
            return Err(format!(
                "`{}` has {roots} roots, which {named} names do not name once each",
                self.path
            ));
        }
        Ok(())
    }

    /// Whether it has the name of its part of the dump, and names that are names.
    fn check_names(&self, path: &str) -> Result<(), String> {
        if self.path != path {
            return Err(format!("the file is `{path}`, not `{}`", self.path.escape_debug()));
        }
        let mut names = BTreeSet::new();
        for root in &self.roots {
            plain("a region", &root.name)?;
            if !names.insert(&root.name) {
                return Err(format!("the region `{}` is there twice", root.name));
            }
        }
        Ok(())
    }
}

impl Manifest {
    /// Reads the manifest of a directory.
    ///
    /// # Errors
    /// It cannot be read, or is no manifest.
    pub fn read(directory: &Path) -> Result<Self> {
        let path = directory.join(FILE);
        let name = path.display().to_string();
        let failed = |e: io::Error| Error::Io { path: name.clone(), message: e.to_string() };
        let mut text = String::new();
        let input = fs::File::open(&path).map_err(failed)?;
        let length = input.take(LARGEST + 1).read_to_string(&mut text).map_err(failed)?;
        if length as u64 > LARGEST {
            let message = format!("the manifest is larger than {} MiB", LARGEST >> 20);
            return Err(Error::Dump { file: name, line: 0, message });
        }
        Manifest::parse(&name, &text)
    }

    /// Reads a manifest; whether it fits its files is checked by [`Manifest::check_file`].
    ///
    /// # Errors
    /// [`Error::Dump`] with the line for text that is no manifest.
    pub fn parse(name: &str, text: &str) -> Result<Self> {
        let wrong = |line: usize, message: String| Error::Dump { file: name.to_owned(), line, message };
        let head: Head = serde_json::from_str(text).map_err(|e| wrong(e.line(), e.to_string()))?;
        match head.schema.as_deref() {
            Some(SCHEMA) => {}
            Some(other) => {
                let other = other.escape_debug();
                return Err(wrong(0, format!("the schema is `{other}`; this version reads `{SCHEMA}`")));
            }
            None => return Err(wrong(0, format!("there is no `schema`: `{SCHEMA}` was expected"))),
        }
        let manifest: Manifest = serde_json::from_str(text).map_err(|e| wrong(e.line(), e.to_string()))?;
        manifest.check().map_err(|message| wrong(0, message))?;
        Ok(manifest)
    }

    /// The text of the file.
    pub fn text(&self) -> String {
        // The structure has string keys only and no fallible parts.
        serde_json::to_string_pretty(self).unwrap_or_default() + "\n"
    }

    /// Whether a file's diagram is the one described.
    ///
    /// # Errors
    /// [`Error::Dump`] that says what differs.
    pub fn check_file(&self, manifest: &str, file: &File, diagram: &Diagram) -> Result<()> {
        let wrong = |message: String| Error::Dump { file: manifest.to_owned(), line: 0, message };
        if !self.variables().eq(diagram.variables.iter()) {
            return Err(wrong(format!("the variables of `{}` are not those of the manifest", file.path)));
        }
        file.check(diagram).map_err(wrong)?;
        for root in file.roots.iter().filter(|r| r.kind == RootKind::States) {
            let edge = Edge::new(i64::from(root.node)).unwrap_or(Edge::FALSE);
            if (diagram.level(edge) as usize) < self.choices.order.len() {
                return Err(wrong(format!("`{}` is a set of states, but depends on choices", root.name)));
            }
        }
        Ok(())
    }

    /// The constants that were given, as `--const` takes them.
    pub fn given_constants(&self) -> String {
        let value = |name: &String| Some(format!("{name}={}", self.constants.get(name)?));
        self.given.iter().filter_map(value).collect::<Vec<_>>().join(",")
    }

    /// The names of all variables from the root down.
    pub fn variables(&self) -> impl Iterator<Item = &String> {
        self.choices.order.iter().chain(&self.encoding.order)
    }

    fn check(&self) -> Result<(), String> {
        self.regions.check_names(REGIONS)?;
        if let Some(file) = &self.certificate {
            file.check_names(CERTIFICATE)?;
        }
        for name in self.constants.keys().chain(&self.given) {
            plain("a constant", name)?;
        }
        for name in &self.objectives {
            plain("an objective", name)?;
        }
        let mut bits = BTreeSet::new();
        for variable in &self.encoding.variables {
            variable.check()?;
            for bit in &variable.names {
                if !bits.insert(bit) {
                    return Err(format!("the bit `{bit}` is there twice"));
                }
            }
        }
        let ordered: BTreeSet<&String> = self.encoding.order.iter().collect();
        if ordered != bits || self.encoding.order.len() != bits.len() {
            return Err("`order` does not have each bit of the variables once".to_owned());
        }
        let names: BTreeSet<&String> = self.encoding.variables.iter().map(|v| &v.name).collect();
        if names.len() != self.encoding.variables.len() {
            return Err("two variables have the same name".to_owned());
        }
        self.check_choices()
    }

    fn check_choices(&self) -> Result<(), String> {
        let (bits, numbers) = (self.choices.order.len(), &self.choices.numbers);
        for choice in numbers {
            let commands = choice.commands.iter().flatten();
            [&choice.name]
                .into_iter()
                .chain(&choice.action)
                .chain(commands)
                .try_for_each(|n| plain("a choice", n))?;
        }
        if bits > MOST_CHOICE_BITS as usize {
            return Err(format!("{bits} bits for choices are more than {MOST_CHOICE_BITS}"));
        }
        if numbers.iter().enumerate().any(|(position, n)| n.number != position) {
            return Err("the choices are not numbered in order".to_owned());
        }
        if bits > 0 && numbers.len() > 1 << bits {
            return Err(format!("{bits} bits do not number {} choices", numbers.len()));
        }
        Ok(())
    }
}
