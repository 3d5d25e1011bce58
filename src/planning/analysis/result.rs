//! The results of an analysis as plain data: counts, ranks and names, no sets.
//!
//! They serialise as the fields of a report of `check`.

use schemars::JsonSchema;
use serde::{Serialize, Serializer};

use super::improvement::Sizes;
use super::levels::Rank;
use super::winning_regions::RegionCounts;
use meliora_base::error::Result;
use meliora_engine::{Count, Engine};
use meliora_model::State;
use meliora_model::preference::Preferences;
use meliora_model::valuation::{Decimal, Valuation, decimal};

/// The contents of a report of `check`; results that are not known yet are `None` or empty.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, JsonSchema)]
pub struct AnalysisResult {
    /// The sizes of the model; `null` if unknown.
    pub counts: Option<ModelCounts>,
    /// The objectives in the order of declaration, as far as decided.
    pub objectives: Vec<ObjectiveCounts>,
    /// The classes that some state has; `null` if unknown.
    pub classes: Option<Vec<ClassCount>>,
    /// The sizes of the improvement MDP; `null` with `--safety prefix`, or if unknown.
    pub improvement: Option<Sizes>,
    /// The levels of SASI; `null` if not begun.
    #[serde(serialize_with = "begun")]
    #[schemars(with = "Option<LevelCounts>")]
    pub sasi: LevelCounts,
    /// The levels of SPI; `null` if not begun.
    #[serde(serialize_with = "begun")]
    #[schemars(with = "Option<LevelCounts>")]
    pub spi: LevelCounts,
}

/// The sizes of a model.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
#[schemars(rename = "counts")]
pub struct ModelCounts {
    /// |S|, the number of states of the scope; with monitors, of pairs of a state of the model and
    /// states of the monitors.
    #[serde(serialize_with = "decimal")]
    #[schemars(with = "Decimal")]
    pub states: Count,
    /// The number of states of the model without monitors; absent if there are no monitors.
    #[serde(skip_serializing_if = "Option::is_none", serialize_with = "decimal_if_known")]
    #[schemars(with = "Decimal")]
    pub model_states: Option<Count>,
    /// The number of pairs of a state and a choice enabled there.
    #[serde(serialize_with = "decimal")]
    #[schemars(with = "Decimal")]
    pub choices: Count,
    /// The number of triples (s, a, s').
    #[serde(serialize_with = "decimal")]
    #[schemars(with = "Decimal")]
    pub transitions: Count,
    /// The number of states without an enabled command.
    #[serde(serialize_with = "decimal")]
    #[schemars(with = "Decimal")]
    pub deadlocks: Count,
    /// The number of initial states.
    #[serde(serialize_with = "decimal")]
    #[schemars(with = "Decimal")]
    pub initial: Count,
    /// The number of states from which no strategy keeps the requirements; absent without
    /// requirements.
    #[serde(rename = "unsafe", skip_serializing_if = "Option::is_none", serialize_with = "decimal_if_known")]
    #[schemars(with = "Decimal")]
    pub unsafe_states: Option<Count>,
}

impl ModelCounts {
    /// Counts the model of an engine. Cost: no image.
    pub fn count<E: Engine>(engine: &E) -> Result<Self> {
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
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct ObjectiveCounts {
    /// The objective, by its position.
    #[serde(skip)]
    pub objective: usize,
    /// Its name.
    pub name: String,
    /// |F|, the number of states of the target; for an objective about whole paths, of states where
    /// it is secured. 0 deserves a warning.
    #[serde(serialize_with = "decimal")]
    #[schemars(with = "Decimal")]
    pub target: Count,
    /// The number of states of its monitor; absent without a monitor.
    #[serde(rename = "observer", skip_serializing_if = "Option::is_none")]
    pub monitor: Option<u64>,
    /// |ASWin(F)|, the number of states from which some strategy achieves it with probability 1.
    #[serde(serialize_with = "decimal")]
    #[schemars(with = "Decimal")]
    pub almost_sure: Count,
    /// |PWin(F)|, the number of states from which some strategy achieves it with positive
    /// probability.
    #[serde(serialize_with = "decimal")]
    #[schemars(with = "Decimal")]
    pub positive: Count,
    /// The share of the initial states from which some strategy achieves it with probability 1; in a game,
    /// against every opponent.
    pub sure: Share,
    /// The share of the initial states from which some strategy achieves it with positive
    /// probability.
    pub possible: Share,
}

impl ObjectiveCounts {
    /// Names the objective at this position to which the sizes belong.
    pub(crate) fn new(preferences: &Preferences, objective: usize, counts: RegionCounts) -> Self {
        let RegionCounts { target, positive, almost_sure, sure, possible } = counts;
        let declared = &preferences.objectives[objective];
        let (name, monitor) = (declared.name.clone(), declared.monitor());
        ObjectiveCounts { objective, name, target, monitor, almost_sure, positive, sure, possible }
    }
}

/// A share of the initial states.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema, strum::Display)]
#[serde(rename_all = "lowercase")]
#[strum(serialize_all = "lowercase")]
pub enum Share {
    /// All initial states.
    All,
    /// Some initial states, but not all.
    Some,
    /// Not a single initial state.
    None,
}

impl Share {
    /// Returns the share of the initial states that are in a set. Cost: no image.
    ///
    /// # Errors
    /// A limit of the engine is reached.
    pub fn of_initial<E: Engine>(engine: &E, states: &E::States) -> Result<Self> {
        let initial = engine.initial_states();
        let inside = engine.intersection(&initial, states)?;
        Ok(if engine.same(&inside, &initial)? {
            Share::All
        } else if engine.is_empty(&inside)? {
            Share::None
        } else {
            Share::Some
        })
    }
}

/// The size of a class.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct ClassCount {
    /// MP of its states: the most preferred outcomes, in the order of declaration; empty for
    /// `nothing`.
    pub most_preferred: Vec<String>,
    /// The number of states with this class.
    #[serde(serialize_with = "decimal")]
    #[schemars(with = "Decimal")]
    pub states: Count,
    /// The sets of at least two of these outcomes that one path can achieve, larger sets first; empty if no
    /// path can achieve two; absent if they were not computed (`--jointly`).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub jointly: Option<Vec<JointCount>>,
    /// The class has more outcomes than this, so `jointly` is not computed for it and its states;
    /// absent for other classes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub jointly_limit: Option<usize>,
}

/// Objectives that one strategy achieves together, almost surely.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct JointCount {
    /// The outcomes, in the order of declaration.
    pub objectives: Vec<String>,
    /// The number of states of the class from which a strategy achieves all of them almost surely.
    #[serde(serialize_with = "decimal")]
    #[schemars(with = "Decimal")]
    pub states: Count,
}

/// The sizes of the levels of one kind.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, JsonSchema)]
pub struct LevelCounts {
    /// |W_1| > |W_2| > …, the number of states of level 1, 2, …, never 0; the last one repeats
    /// `unbounded` where that is not 0. Empty if no state can improve, and before level 1 is known: then
    /// `unbounded` is `null`.
    #[serde(serialize_with = "decimals")]
    #[schemars(with = "Vec<Decimal>")]
    pub levels: Vec<Count>,
    /// The number of states of unbounded rank; `null` if unknown or cut by `--max-level`.
    #[serde(rename = "unbounded")]
    #[schemars(with = "Option<Decimal>")]
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
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Escape {
    /// The requirement that the path violates, as written.
    #[schemars(with = "String")]
    pub violated: Option<String>,
    /// A shortest path to the violation; from each of its states every action may lead to a violation.
    /// Empty if the state itself violates it.
    pub path: Vec<EscapeStep>,
}

/// A state of a path to a violation.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct EscapeStep {
    /// The values of the state.
    pub state: Valuation,
    /// The action that leads on; `null` in the last state, which violates the requirement.
    pub action: Option<String>,
}

/// The prospects of a state: its most preferred objectives and its plans.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(into = "Initial")]
#[schemars(with = "Initial")]
pub struct Prospects {
    /// The state.
    pub state: State,
    /// `opponent` for a state of a game in which the opponent chooses.
    pub owner: Option<&'static str>,
    /// Its values by variable.
    pub values: Valuation,
    /// For a state from which the requirements cannot be kept, a path to a violation.
    pub escape: Option<Escape>,
    /// The objectives that some strategy achieves from the state almost surely, by name and in the
    /// order of declaration; `None` if unknown.
    pub sure: Option<Vec<String>>,
    /// The objectives that some strategy achieves from the state with positive probability; `None` if
    /// unknown.
    pub possible: Option<Vec<String>>,
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
    /// The objectives that each improvement gains under the progress strategy; empty if they were not
    /// searched. See [`Analysis::gains`](crate::Analysis::gains).
    pub gains: Vec<Vec<String>>,
}

/// The prospects of an initial state in JSON.
#[derive(Serialize, JsonSchema)]
struct Initial {
    /// The values of the state.
    state: Valuation,
    /// `opponent`: in this state of a game the opponent chooses, so no actions are listed; absent for
    /// other states.
    #[serde(skip_serializing_if = "Option::is_none")]
    owner: Option<&'static str>,
    /// The state is unsafe: no strategy keeps the requirements, and the other fields are empty or 0;
    /// absent for other states.
    #[serde(rename = "unsafe", skip_serializing_if = "Option::is_none")]
    escape: Option<Escape>,
    /// The objectives that some strategy achieves from the state with probability 1, in the order of
    /// declaration; `null` if unknown.
    sure: Option<Vec<String>>,
    /// The objectives that some strategy achieves from the state with positive probability, in the
    /// order of declaration; those of `sure` are among them; `null` if unknown.
    possible: Option<Vec<String>>,
    /// The most preferred outcomes, in the order of declaration.
    most_preferred: Vec<String>,
    /// The largest sets of these outcomes that one path can achieve; absent if they were not
    /// computed (`--jointly`), and if the class has a `jointly_limit`.
    #[serde(skip_serializing_if = "Option::is_none")]
    jointly: Option<Vec<Vec<String>>>,
    /// The rank by SASI; `null` if unknown.
    sasi_rank: Option<Rank>,
    /// The rank by SPI; `null` if unknown.
    spi_rank: Option<Rank>,
    /// The actions of the permissive SASI strategy; empty at rank 0, and where the opponent of a game
    /// chooses; `null` if unknown.
    sasi_actions: Option<Vec<String>>,
    /// The actions of the permissive SPI strategy; empty at rank 0, and where the opponent of a game
    /// chooses; `null` if unknown.
    spi_actions: Option<Vec<String>>,
    /// The objectives that each improvement of the progress SASI strategy gains, of none that is sure in
    /// this state; absent at rank 0, and if the model has more than 4,096 states.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    sasi_gains: Vec<Vec<String>>,
    /// The objectives that each improvement of the progress SPI strategy may gain (for an unbounded rank:
    /// the first one); absent as before.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    spi_gains: Vec<Vec<String>>,
}

impl From<Prospects> for Initial {
    fn from(of: Prospects) -> Self {
        let split = |plan: Option<Plan>| match plan {
            Some(Plan { rank, actions, gains }) => (Some(rank), Some(actions), gains),
            None => (None, None, Vec::new()),
        };
        let (sasi_rank, sasi_actions, sasi_gains) = split(of.sasi);
        let (spi_rank, spi_actions, spi_gains) = split(of.spi);
        Initial {
            state: of.values,
            owner: of.owner,
            escape: of.escape,
            sure: of.sure,
            possible: of.possible,
            most_preferred: of.most_preferred,
            jointly: of.jointly,
            sasi_rank,
            spi_rank,
            sasi_actions,
            spi_actions,
            sasi_gains,
            spi_gains,
        }
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
