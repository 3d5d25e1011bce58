//! `manifest.json`: the meaning of the roots and variables of a dump.

use std::collections::BTreeMap;
use std::io::{self, Read};
use std::path::Path;

use serde::{Deserialize, Serialize};
use serde_json::Value as Json;

use super::bounds::Layout;
use super::{Diagram, Edge};
use meliora_base::error::{Error, Result, ensure};
use meliora_base::json;
use meliora_base::reading::{each_once, regular};
use meliora_model::trend::Trend;

/// The schema that this version writes and reads.
pub const SCHEMA: &str = "meliora.dump/1";
/// The name of the manifest in the directory.
pub const FILE: &str = "manifest.json";
/// The name of the file with the regions.
pub const REGIONS: &str = "regions.dddmp";
/// The name of the file with the certificate.
pub const CERTIFICATE: &str = "certificate.dddmp";
/// The name of the file with the bounds of quantities.
pub const VALUES: &str = "values.csv";
/// The name of the program that writes dumps.
pub const TOOL: &str = "meliora";
/// The maximum size of a manifest, in bytes.
const LARGEST: u64 = 256 << 20;

/// The information that is needed to interpret a dump without the model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// The schema, [`SCHEMA`].
    pub schema: String,
    /// The program that wrote the dump.
    pub tool: Tool,
    /// The model.
    pub model: Source,
    /// The values of all constants of the model.
    #[serde(deserialize_with = "each_once")]
    pub constants: BTreeMap<String, Json>,
    /// The exact values of the constants that are not the shortest decimals of doubles.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub exact: BTreeMap<String, String>,
    /// The names of the constants that `--const` gave.
    pub given: Vec<String>,
    /// The players of a game, in the order of declaration; none for other models.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub players: Vec<String>,
    /// The players of a game who we are; all others are the opponent.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub coalition: Vec<String>,
    /// The preference file.
    pub preferences: Source,
    /// The objectives in the order of declaration.
    pub objectives: Vec<String>,
    /// `bottom`, `gain` or `incomparable`.
    pub empty: String,
    /// `play` if objectives are judged over whole paths; none if they are judged from the present
    /// state.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub history: Option<String>,
    /// The requirements as they are written.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub requirements: Vec<String>,
    /// The questions whose regions the dump has, if it was written by `reach`. Such a dump has no
    /// preferences and no certificate.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub questions: Vec<Question>,
    /// `reachable` or `all`.
    pub scope: String,
    /// The safety mode that decided the kept choices.
    pub safety: SafetyMode,
    /// The greatest computed level, if `--max-level` cut the search.
    pub max_level: Option<usize>,
    /// The encoding of states as bits.
    pub encoding: Encoding,
    /// The encoding of choices as bits.
    pub choices: Choices,
    /// `regions.dddmp`
    pub regions: File,
    /// `certificate.dddmp`, if there is one.
    pub certificate: Option<File>,
    /// `values.csv`, if there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub values: Option<ValuesFile>,
}

/// The safety modes by their names in manifests; other names are refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum SafetyMode {
    /// `action`
    Action,
    /// `transition`
    Transition,
    /// `prefix`
    Prefix,
}

impl SafetyMode {
    /// Returns the name, as in manifests.
    pub fn name(self) -> &'static str {
        match self {
            SafetyMode::Action => "action",
            SafetyMode::Transition => "transition",
            SafetyMode::Prefix => "prefix",
        }
    }

    /// Returns whether the rows of `values.csv` name the arenas that they belong to.
    fn has_arenas(self) -> bool {
        match self {
            SafetyMode::Prefix => true,
            SafetyMode::Action | SafetyMode::Transition => false,
        }
    }
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

/// An input file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Source {
    /// Its path as the user gave it.
    pub path: String,
    /// The SHA-256 of its bytes, in hexadecimal.
    pub sha256: String,
}

/// A question about paths, with its regions.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Question {
    /// Its name in a property file; none without a name.
    pub name: Option<String>,
    /// The target or the property as written.
    pub text: String,
    /// The names of its regions.
    pub regions: Vec<String>,
    /// In a game, the players who we are in this question; empty for other models.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub coalition: Vec<String>,
}

/// The encoding of states as bits. The value of a variable is `low` plus the number formed by its
/// bits, where bit 0 is the least significant. Patterns above `high` are not values.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Encoding {
    /// The variables of the model, in the order of declaration.
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
    /// The smallest value (0 for a Boolean), which is added to the number of the bits.
    pub low: i64,
    /// The largest value (1 for a Boolean).
    pub high: i64,
    /// The number of its bits.
    pub bits: u32,
    /// The names of its bits, least significant first.
    pub names: Vec<String>,
    /// Its value in the initial states, if all of them agree.
    pub initial: Option<i64>,
    /// The names of its values from `low` on; locations have such names.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub values: Vec<String>,
    /// In a planning problem, the facts that its values stand for, from `low` on; empty texts for values
    /// without a fact.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub facts: Vec<String>,
    /// True if the variable is the state of a monitor, which follows an objective over whole paths.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub observer: bool,
}

/// The encoding of choices as bits of their number, where bit 0 is the least significant and
/// deepest. These variables are above those of the states. Only roots of kind `choices` depend on
/// them.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Choices {
    /// The names of the bits from the root down; empty if no root depends on them.
    pub order: Vec<String>,
    /// The meaning of the numbers; greater numbers have no meaning.
    pub numbers: Vec<ChoiceNumber>,
}

/// Choices with one number: at most one of them is enabled in a state.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ChoiceNumber {
    /// The number.
    pub number: usize,
    /// The displayed name: the label, with the commands if several numbers share this label.
    pub name: String,
    /// The label; none if the commands have none.
    pub action: Option<String>,
    /// For each participating module its alternative commands, `module#k`. Empty for a `dtmc` and
    /// for the self-loop of deadlocks.
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
    /// The number of its nodes, including the terminal.
    pub nodes: usize,
    /// The meaning of its roots.
    pub roots: Vec<Root>,
    /// The variables in the order in which they make a state a number, the first one most
    /// significant; for roots with a trend.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub order: Vec<Digit>,
    /// The order for rounds, if they have one of their own.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub order_of_rounds: Vec<Digit>,
    /// The regions that a certificate does not prove, because a limit ended a part of it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub uncertified: Vec<String>,
}

/// A variable as a digit of the number of a state.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Digit {
    /// Its name.
    pub variable: String,
    /// True if greater values make the number smaller.
    pub reversed: bool,
    /// True if rising steps make this digit smaller, too.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub steady: bool,
    /// All values from the one with the smallest digit, if their order is not the natural one.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub values: Vec<i64>,
}

/// The file with bounds of quantities; see [`super::bounds`].
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ValuesFile {
    /// Its name in the directory.
    pub path: String,
    /// The SHA-256 of its bytes, in hexadecimal.
    pub sha256: String,
    /// The greatest number of improvements.
    pub levels: usize,
    /// The reward structure that is the cost of a step, or `steps`.
    pub reward: String,
    /// The number of rows.
    pub rows: usize,
}

/// A named function of a file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Root {
    /// Its name, as in `meliora query`.
    pub name: String,
    /// The sort of its members.
    pub kind: RootKind,
    /// Its index in `.rootids`, from 0.
    pub root: usize,
    /// The value in `.rootids`: the number of a node, negative if complemented.
    pub node: Edge,
    /// The number of its inner nodes.
    pub nodes: usize,
    /// The number of its members, in decimal.
    pub count: String,
    /// Its DOT file, if there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dot: Option<String>,
    /// The steps that lead to other members, in a layer or round of a certificate; none if all
    /// steps lead to earlier layers or rounds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub trend: Option<Trend>,
}

/// The sort of the members of a set.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum RootKind {
    /// States.
    States,
    /// Pairs of a state and a choice enabled there.
    Choices,
}

/// The first part to be read: the schema says if the rest can be read.
#[derive(Deserialize)]
struct Head {
    schema: Option<String>,
}

impl Variable {
    /// Returns true if the variable is a Boolean.
    pub fn is_bool(&self) -> bool {
        self.ty == "bool"
    }
}

impl File {
    /// Returns the root called `name`.
    pub fn root(&self, name: &str) -> Option<&Root> {
        self.roots.iter().find(|r| r.name == name)
    }
}

impl Manifest {
    /// Reads the manifest of a directory.
    ///
    /// # Errors
    /// The file cannot be read, is too large, or is not a valid manifest.
    pub fn read(directory: &Path) -> Result<Self> {
        let path = directory.join(FILE);
        let name = path.display().to_string();
        let failed = |e: io::Error| Error::Io { path: name.clone(), message: e.to_string() };
        let mut text = String::new();
        let input = regular(&path).map_err(failed)?;
        let length = input.take(LARGEST + 1).read_to_string(&mut text).map_err(failed)?;
        ensure(length as u64 <= LARGEST, || {
            let message = format!("the manifest is larger than {} MiB", LARGEST >> 20);
            Error::Dump { file: name.clone(), line: 0, message }
        })?;
        Manifest::parse(&name, &text)
    }

    /// Parses a manifest. `Manifest::check_file` checks that it fits its files.
    ///
    /// # Errors
    /// [`Error::Dump`] with the line, if the text is not a valid manifest.
    pub fn parse(name: &str, text: &str) -> Result<Self> {
        let wrong = |line: usize, message: String| Error::Dump { file: name.to_owned(), line, message };
        let head: Head = serde_json::from_str(text).map_err(|e| wrong(e.line(), e.to_string()))?;
        match head.schema.as_deref() {
            Some(SCHEMA) => {}
            Some(other) => {
                let other = other.escape_debug();
                return Err(wrong(0, format!("the schema is `{other}`; this version reads `{SCHEMA}`")));
            }
            None => return Err(wrong(0, format!("`schema` is missing: expected `{SCHEMA}`"))),
        }
        let manifest: Manifest = serde_json::from_str(text).map_err(|e| wrong(e.line(), e.to_string()))?;
        manifest.check().map_err(|message| wrong(0, message))?;
        Ok(manifest)
    }

    /// Returns the text of the file.
    ///
    /// # Errors
    /// A value has no JSON form.
    pub fn text(&self) -> io::Result<String> {
        Ok(json::pretty(self)? + "\n")
    }

    /// Checks that the diagram of a file is the one described.
    ///
    /// # Errors
    /// [`Error::Dump`] with the difference.
    pub fn check_file(&self, manifest: &str, file: &File, diagram: &Diagram) -> Result<()> {
        let wrong = |message: String| Error::Dump { file: manifest.to_owned(), line: 0, message };
        ensure(self.variables().eq(diagram.variables.iter()), || {
            wrong(format!("the variables of `{}` are not those of the manifest", file.path))
        })?;
        file.check(diagram).map_err(wrong)?;
        for root in file.roots.iter().filter(|r| r.kind == RootKind::States) {
            ensure(diagram.level(root.node) as usize >= self.choices.order.len(), || {
                wrong(format!("`{}` is a set of states, but depends on choices", root.name))
            })?;
        }
        Ok(())
    }

    /// Returns the columns of `values.csv`, if there is one.
    pub(crate) fn values_layout(&self) -> Option<Layout> {
        let variables = self.encoding.variables.iter().map(|v| v.name.clone()).collect();
        let levels = self.values.as_ref()?.levels;
        Some(Layout { arenas: self.safety.has_arenas(), variables, levels })
    }

    /// Returns the given constants in the syntax of `--const`.
    pub fn given_constants(&self) -> String {
        let value = |name: &String| match self.exact.get(name) {
            Some(exact) => Some(format!("{name}={exact}")),
            None => Some(format!("{name}={}", self.constants.get(name)?)),
        };
        self.given.iter().filter_map(value).collect::<Vec<_>>().join(",")
    }

    /// Returns the names of all variables, from the root down.
    pub fn variables(&self) -> impl Iterator<Item = &String> {
        self.choices.order.iter().chain(&self.encoding.order)
    }
}
