//! The results of an analysis as plain data: counts, ranks and names, no sets.

use super::improvement::Sizes;
use super::levels::Rank;
use crate::engine::{Count, Engine};
use crate::error::Result;
use crate::model::State;
use crate::model::preference::ObjectiveSet;

/// The contents of a report of `check`; results that are not known yet are `None` or empty.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
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
    pub sasi: LevelCounts,
    /// The SPI levels.
    pub spi: LevelCounts,
}

/// The size of a model.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ModelCounts {
    /// |S|
    pub states: Count,
    /// The number of states without monitors, if the model has monitors.
    pub model_states: Option<Count>,
    /// The number of enabled (state, choice) pairs.
    pub choices: Count,
    /// The number of triples (s, a, s').
    pub transitions: Count,
    /// The number of states without an enabled command.
    pub deadlocks: Count,
    /// The number of initial states.
    pub initial: Count,
}

impl ModelCounts {
    /// Counts the model of an engine. Cost: no image.
    ///
    /// # Errors
    /// A limit of the engine is reached.
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
    /// The objective, by its position.
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
    /// The number of states.
    pub states: Count,
}

/// The sizes of the levels of one kind.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct LevelCounts {
    /// |W_1| > |W_2| > …, counted over S and never 0.
    pub levels: Vec<Count>,
    /// The reason why there are no more levels, if known.
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
    /// Returns the number of states of unbounded rank; `None` if it is not known.
    pub fn unbounded(&self) -> Option<Count> {
        match &self.end {
            LevelsEnd::Open | LevelsEnd::Cut => None,
            LevelsEnd::Empty => Some(Count::ZERO),
            LevelsEnd::Unbounded(count) => Some(count.clone()),
        }
    }
}

/// The prospects of a state: its most preferred objectives and its plans.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Prospects {
    /// The state.
    pub state: State,
    /// MP of the state.
    pub most_preferred: ObjectiveSet,
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
