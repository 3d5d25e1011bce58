//! The index: the kind and the size of a model, and its annotations and valuations.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use meliora_base::reading::each_once;

/// The index of an archive.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct Index {
    /// The major version of the format; this program knows version 1.
    pub format_version: u32,
    /// The minor version of the format.
    pub format_revision: u32,
    /// The program that wrote the archive, if it is named.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub file_data: Option<FileData>,
    /// The kind and the size of the model.
    pub transition_system: TransitionSystem,
    /// Annotations by group and identifier.
    #[serde(default, deserialize_with = "each_once", skip_serializing_if = "BTreeMap::is_empty")]
    pub annotations: BTreeMap<String, Annotations>,
    /// Valuations by their owners: "states", "choices", …
    #[serde(default, deserialize_with = "each_once", skip_serializing_if = "BTreeMap::is_empty")]
    pub valuations: BTreeMap<String, Valuations>,
}

/// The program that wrote the archive.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct FileData {
    /// The name of the program.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tool: Option<String>,
    /// Its version.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tool_version: Option<String>,
}

/// The kind and the size of a model.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct TransitionSystem {
    /// The kind of time, such as "discrete".
    pub time: String,
    /// The number of players; 0 for Markov chains.
    #[serde(rename = "#players")]
    pub players: u32,
    /// The number of states.
    #[serde(rename = "#states")]
    pub states: u64,
    /// The number of initial states.
    #[serde(rename = "#initial-states")]
    pub initial_states: u64,
    /// The number of choices.
    #[serde(rename = "#choices")]
    pub choices: u64,
    /// The number of names of choices.
    #[serde(rename = "#choice-actions")]
    pub choice_actions: u32,
    /// The number of branches.
    #[serde(rename = "#branches")]
    pub branches: u64,
    /// The number of names of branches.
    #[serde(rename = "#branch-actions")]
    pub branch_actions: u32,
    /// The number of observations.
    #[serde(rename = "#observations")]
    pub observations: u64,
    /// The type of the probabilities; `None` if there are none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub branch_probability_type: Option<Type>,
    /// The names of the players of a game.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub player_names: Option<Vec<String>>,
}

/// The type of stored values.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Type {
    /// The type without its size.
    #[serde(rename = "type")]
    pub(crate) base: Base,
    /// The size in bits, if it is not the default of the type.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) size: Option<u32>,
}

/// The types without their sizes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, strum::Display)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum Base {
    /// Truth values.
    Bool,
    /// Signed integers.
    Int,
    /// Unsigned integers.
    Uint,
    /// Intervals of signed integers.
    IntInterval,
    /// Intervals of unsigned integers.
    UintInterval,
    /// Floating-point numbers.
    Double,
    /// Intervals of floating-point numbers.
    DoubleInterval,
    /// Fractions.
    Rational,
    /// Intervals of fractions.
    RationalInterval,
    /// Strings.
    String,
}

impl Type {
    /// Returns a type of a size in bits.
    pub fn sized(base: Base, size: u32) -> Self {
        Type { base, size: Some(size) }
    }

    /// Returns the size in bits.
    pub fn bits(self) -> u32 {
        self.size.unwrap_or(match self.base {
            Base::Bool => 1,
            Base::Int | Base::Uint | Base::Double | Base::String => 64,
            Base::IntInterval | Base::UintInterval | Base::DoubleInterval | Base::Rational => 128,
            Base::RationalInterval => 256,
        })
    }

    /// Returns whether values are intervals.
    pub(crate) fn is_interval(self) -> bool {
        use Base::{DoubleInterval, IntInterval, RationalInterval, UintInterval};
        matches!(self.base, IntInterval | UintInterval | DoubleInterval | RationalInterval)
    }
}

/// The annotations of a group by identifier.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Annotations(#[serde(deserialize_with = "each_once")] pub BTreeMap<String, Annotation>);

/// Values of states, choices or branches.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct Annotation {
    /// The name for people, if it differs from the identifier.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub alias: Option<String>,
    /// A description for people.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub description: Option<String>,
    /// The entities that have values: "states", "choices" or "branches".
    pub applies_to: Vec<String>,
    /// The type of the values.
    #[serde(rename = "type")]
    pub ty: Type,
    /// The type of probabilities, if values are distributions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub probability_type: Option<Type>,
}

/// The variables of states.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Valuations {
    /// True if no two entities have the same values.
    pub unique: bool,
    /// The number of strings that values refer to.
    #[serde(default, rename = "#strings", skip_serializing_if = "Option::is_none")]
    pub strings: Option<u32>,
    /// The classes of entities.
    pub classes: Vec<Class>,
}

/// Variables that some states have in common.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Class {
    /// The variables, in the order of their bits.
    pub variables: Vec<Field>,
}

/// A part of a valuation.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Field {
    /// Bits without a meaning.
    Padding {
        /// The number of bits.
        padding: u64,
    },
    /// A variable.
    Variable(Variable),
}

/// A variable of a valuation.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct Variable {
    /// The name.
    pub name: String,
    /// True if one more bit, before the value, says whether there is one.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub is_optional: bool,
    /// The type of the values.
    #[serde(rename = "type")]
    pub ty: Type,
    /// The least value.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lower: Option<i64>,
    /// The greatest value.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub upper: Option<i64>,
    /// The number that is added to the stored value.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub offset: Option<i64>,
}

impl Field {
    /// Returns the size in bits.
    pub(crate) fn bits(&self) -> u64 {
        match self {
            Field::Padding { padding } => *padding,
            Field::Variable(v) => u64::from(v.ty.bits()) + u64::from(v.is_optional),
        }
    }
}
