//! The results of an analysis as plain data: counts, ranks and names, no sets.
//!
//! They serialise as the fields of a report of `check`.

use serde::ser::{Serialize, SerializeStruct, Serializer};

use super::improvement::Sizes;
use super::levels::Rank;
use meliora_engine::{Count, Engine};
use meliora_model::State;
use meliora_model::error::Result;
use meliora_model::valuation::{Valuation, decimal};

/// The contents of a report of `check`; results that are not known yet are `None` or empty.
#[derive(Debug, Clone, Default, PartialEq, Eq, serde::Serialize)]
pub struct AnalysisResult {
    /// The size of the model.
    pub counts: Option<ModelCounts>,
    /// The objectives with known regions, in the order of declaration.
    pub objectives: Vec<ObjectiveCounts>,
    /// The non-empty classes.
    pub classes: Option<Vec<ClassCount>>,
    /// The size of the improvement MDP; `None` under `prefix`.
    pub improvement: Option<Sizes>,
    /// The SASI levels.
    #[serde(serialize_with = "begun")]
    pub sasi: LevelCounts,
    /// The SPI levels.
    #[serde(serialize_with = "begun")]
    pub spi: LevelCounts,
}

/// The size of a model.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct ModelCounts {
    /// |S|
    #[serde(serialize_with = "decimal")]
    pub states: Count,
    /// The number of states without monitors, if the model has monitors.
    #[serde(skip_serializing_if = "Option::is_none", serialize_with = "decimal_if_known")]
    pub model_states: Option<Count>,
    /// The number of enabled (state, choice) pairs.
    #[serde(serialize_with = "decimal")]
    pub choices: Count,
    /// The number of triples (s, a, s').
    #[serde(serialize_with = "decimal")]
    pub transitions: Count,
    /// The number of states without an enabled command.
    #[serde(serialize_with = "decimal")]
    pub deadlocks: Count,
    /// The number of initial states.
    #[serde(serialize_with = "decimal")]
    pub initial: Count,
    /// The number of states from which the requirements cannot be kept, if there are requirements.
    #[serde(rename = "unsafe", skip_serializing_if = "Option::is_none", serialize_with = "decimal_if_known")]
    pub unsafe_states: Option<Count>,
}

impl ModelCounts {
    /// Counts the model of an engine. Cost: no image.
    pub fn of<E: Engine>(engine: &E) -> Result<Self> {
        let states = engine.all_states();
        Ok(ModelCounts {
            model_states: engine.count_model_states(&states)?,
            ..Self::within(engine, &states)?
        })
    }

    /// Counts some states with their choices and transitions, and all initial states. Cost: no
    /// image.
    pub fn within<E: Engine>(engine: &E, states: &E::States) -> Result<Self> {
        let choices = engine.choices_in(&engine.all_choices(), states)?;
        Ok(ModelCounts {
            states: engine.count(states)?,
            model_states: None,
            choices: engine.count(&choices)?,
            transitions: engine.count_transitions(&choices, &engine.all_states())?,
            deadlocks: engine.count(&engine.intersection(&engine.deadlock_states(), states)?)?,
            initial: engine.count(&engine.initial_states())?,
            unsafe_states: None,
        })
    }
}

/// The sizes of an objective's regions.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct ObjectiveCounts {
    /// The objective, by its position.
    #[serde(skip)]
    pub objective: usize,
    /// Its name.
    pub name: String,
    /// |F|; for a temporal objective, the number of states in which it is secured. 0 deserves a
    /// warning.
    #[serde(serialize_with = "decimal")]
    pub target: Count,
    /// The number of states of its monitor; absent without a monitor.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub monitor: Option<u64>,
    /// Equal to `monitor`, under its former name.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub observer: Option<u64>,
    /// |ASWin(F)|
    #[serde(serialize_with = "decimal")]
    pub almost_sure: Count,
    /// |PWin(F)|
    #[serde(serialize_with = "decimal")]
    pub positive: Count,
}

/// The size of a class.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct ClassCount {
    /// MP of its states, by name and in the order of declaration; empty for `nothing`.
    pub most_preferred: Vec<String>,
    /// The number of states.
    #[serde(serialize_with = "decimal")]
    pub states: Count,
    /// The sets of at least two of these objectives that can be achieved together, if they were
    /// computed; larger sets first.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub jointly: Option<Vec<JointCount>>,
    /// The greatest number of objectives for which this is computed, if the class has more.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub jointly_limit: Option<usize>,
}

/// Objectives that one strategy achieves together, almost surely.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct JointCount {
    /// The objectives, by name and in the order of declaration.
    pub objectives: Vec<String>,
    /// The number of states of the class from which they are achieved together.
    #[serde(serialize_with = "decimal")]
    pub states: Count,
}

/// The sizes of the levels of one kind.
#[derive(Debug, Clone, Default, PartialEq, Eq, serde::Serialize)]
pub struct LevelCounts {
    /// |W_1| > |W_2| > …, counted over S and never 0.
    #[serde(serialize_with = "decimals")]
    pub levels: Vec<Count>,
    /// The reason why there are no more levels, if known; in JSON the number of states of unbounded
    /// rank.
    #[serde(rename = "unbounded")]
    pub end: LevelsEnd,
}

/// The reason why there are no more levels, if known.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub enum LevelsEnd {
    /// There may be more levels: the work ended early.
    #[default]
    Open,
    /// The requested greatest level was reached; there may be more.
    Cut,
    /// The next level is empty.
    Empty,
    /// This number of states have an unbounded rank; they are the last level.
    Unbounded(Count),
}

impl LevelCounts {
    /// Returns whether the search for levels has begun.
    pub fn is_begun(&self) -> bool {
        !self.levels.is_empty() || self.end != LevelsEnd::Open
    }

    /// Returns |W_k|; `None` if it is not known.
    pub fn size(&self, k: usize) -> Option<Count> {
        self.levels.get(k.checked_sub(1)?).cloned().or_else(|| self.unbounded())
    }

    /// Returns the number of states of unbounded rank; `None` if it is not known.
    pub fn unbounded(&self) -> Option<Count> {
        match &self.end {
            LevelsEnd::Open | LevelsEnd::Cut => None,
            LevelsEnd::Empty => Some(Count::ZERO),
            LevelsEnd::Unbounded(count) => Some(count.clone()),
        }
    }
}

/// A path to the violation of a requirement. In each of its states, every action may lead to a
/// further state from which the violation cannot be ruled out.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Escape {
    /// The states, each with the action that leads on; the last one violates a requirement.
    pub path: Vec<(Valuation, Option<String>)>,
    /// The requirement that is violated, as written.
    pub violated: Option<String>,
}

impl Serialize for Escape {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        let step = |(state, action): &(Valuation, Option<String>)| serde_json::json!({"state": state, "action": action});
        let mut fields = serializer.serialize_struct("Escape", 2)?;
        fields.serialize_field("violated", &self.violated)?;
        fields.serialize_field("path", &self.path.iter().map(step).collect::<Vec<_>>())?;
        fields.end()
    }
}

/// The prospects of a state: its most preferred objectives and its plans.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Prospects {
    /// The state.
    pub state: State,
    /// Its values by variable.
    pub values: Valuation,
    /// For a state from which the requirements cannot be kept, a path to a violation.
    pub escape: Option<Escape>,
    /// MP of the state, by name and in the order of declaration.
    pub most_preferred: Vec<String>,
    /// The greatest sets of these objectives that can be achieved together, if they were computed.
    pub jointly: Option<Vec<Vec<String>>>,
    /// The plan under SASI; `None` if no levels were computed.
    pub sasi: Option<Plan>,
    /// The plan under SPI; `None` if no levels were computed.
    pub spi: Option<Plan>,
}

/// The rank of a state and the actions of the permissive strategy of that rank when planning starts
/// there.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Plan {
    /// The rank.
    pub rank: Rank,
    /// The names of the permitted actions, in the order of the program; empty at rank 0.
    pub actions: Vec<String>,
}

impl Serialize for Prospects {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        let (sasi, spi) = (self.sasi.as_ref(), self.spi.as_ref());
        let mut fields = serializer.serialize_struct("Prospects", 8)?;
        fields.serialize_field("state", &self.values)?;
        match &self.escape {
            Some(escape) => fields.serialize_field("unsafe", escape)?,
            None => fields.skip_field("unsafe")?,
        }
        fields.serialize_field("most_preferred", &self.most_preferred)?;
        match &self.jointly {
            Some(jointly) => fields.serialize_field("jointly", jointly)?,
            None => fields.skip_field("jointly")?,
        }
        fields.serialize_field("sasi_rank", &sasi.map(|plan| plan.rank))?;
        fields.serialize_field("spi_rank", &spi.map(|plan| plan.rank))?;
        fields.serialize_field("sasi_actions", &sasi.map(|plan| &plan.actions))?;
        fields.serialize_field("spi_actions", &spi.map(|plan| &plan.actions))?;
        fields.end()
    }
}

impl Serialize for LevelsEnd {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        match self {
            LevelsEnd::Open | LevelsEnd::Cut => serializer.serialize_none(),
            LevelsEnd::Empty => serializer.serialize_str("0"),
            LevelsEnd::Unbounded(count) => decimal(count, serializer),
        }
    }
}

fn decimal_if_known<S: Serializer>(
    count: &Option<Count>,
    serializer: S,
) -> std::result::Result<S::Ok, S::Error> {
    count.as_ref().map(Count::to_string).serialize(serializer)
}

fn decimals<S: Serializer>(counts: &[Count], serializer: S) -> std::result::Result<S::Ok, S::Error> {
    serializer.collect_seq(counts.iter().map(Count::to_string))
}

/// Serialises levels, or `null` before the search has begun.
fn begun<S: Serializer>(levels: &LevelCounts, serializer: S) -> std::result::Result<S::Ok, S::Error> {
    levels.is_begun().then_some(levels).serialize(serializer)
}
