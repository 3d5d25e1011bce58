//! What was found, as plain data: counts, ranks and names, no sets.

use super::improvement::Sizes;
use super::levels::Rank;
use crate::engine::{Count, Engine};
use crate::error::Result;
use crate::model::State;
use crate::model::preference::ObjectiveSet;

/// All that `check` reports; what was not reached yet is none or empty.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct AnalysisResult {
    /// The size of the model.
    pub counts: Option<ModelCounts>,
    /// The objectives that are known, in the order of declaration.
    pub objectives: Vec<ObjectiveCounts>,
    /// The non-empty classes.
    pub classes: Option<Vec<ClassCount>>,
    /// The size of the improvement MDP; none under `prefix`.
    pub improvement: Option<Sizes>,
    /// The SASI levels.
    pub sasi: LevelCounts,
    /// The SPI levels.
    pub spi: LevelCounts,
}

/// The size of a model.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ModelCounts {
    /// |S|
    pub states: Count,
    /// Where monitors watch plays, how many states the model has without them.
    pub model_states: Option<Count>,
    /// The enabled pairs of a state and a choice.
    pub choices: Count,
    /// The triples (s, a, s').
    pub transitions: Count,
    /// The states without an enabled command.
    pub deadlocks: Count,
    /// The initial states.
    pub initial: Count,
}

impl ModelCounts {
    /// The size of the model that an engine has.
    ///
    /// # Errors
    /// A limit of the engine. Cost: no image.
    pub fn of<E: Engine>(engine: &E) -> Result<Self> {
        let (states, choices) = (engine.all_states(), engine.all_choices());
        Ok(ModelCounts {
            model_states: engine.count_model_states(&states)?,
            states: engine.count(&states)?,
            choices: engine.count(&choices)?,
            transitions: engine.count_transitions(&choices, &states)?,
            deadlocks: engine.count(&engine.deadlock_states())?,
            initial: engine.count(&engine.initial_states())?,
        })
    }
}

/// The sizes of an objective's regions.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ObjectiveCounts {
    /// Which objective, by its position.
    pub objective: usize,
    /// |F|; 0 deserves a warning.
    pub target: Count,
    /// |ASWin(F)|
    pub almost_sure: Count,
    /// |PWin(F)|
    pub positive: Count,
}

/// The size of a class.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ClassCount {
    /// MP of its states.
    pub most_preferred: ObjectiveSet,
    /// How many states it has.
    pub states: Count,
}

/// The sizes of the levels of one kind.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct LevelCounts {
    /// |W_1| > |W_2| > …, counted over S, none of them 0.
    pub levels: Vec<Count>,
    /// Whether there are no more levels, and why.
    pub end: LevelsEnd,
}

/// Whether there are no more levels, and why.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub enum LevelsEnd {
    /// There may be more: the work ended early.
    #[default]
    Open,
    /// The greatest level asked for was reached; there may be more.
    Cut,
    /// The next level is empty.
    Empty,
    /// So many states have an unbounded rank; they are the last level.
    Unbounded(Count),
}

impl LevelCounts {
    /// The number of states of unbounded rank; none where it is not known.
    pub fn unbounded(&self) -> Option<Count> {
        match &self.end {
            LevelsEnd::Open | LevelsEnd::Cut => None,
            LevelsEnd::Empty => Some(Count::ZERO),
            LevelsEnd::Unbounded(count) => Some(count.clone()),
        }
    }
}

/// What can be done from a state.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Prospects {
    /// The state.
    pub state: State,
    /// MP of the state.
    pub most_preferred: ObjectiveSet,
    /// Under SASI; none where the levels were not begun.
    pub sasi: Option<Plan>,
    /// Under SPI; none where the levels were not begun.
    pub spi: Option<Plan>,
}

/// The rank of a state and what the permissive strategy of that rank permits when planning starts
/// there.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Plan {
    /// The rank.
    pub rank: Rank,
    /// The names of the permitted actions, in the order of the program; none at rank 0.
    pub actions: Vec<String>,
}
