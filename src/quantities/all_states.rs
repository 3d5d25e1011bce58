//! The quantities of all states of the scope, as numbers for maps.

use std::sync::Arc;

use crate::choose::LEVELS;
use crate::{Steps, ValueOptions, Values};
use meliora_base::error::Result;
use meliora_engine::Engine;
use meliora_model::{Program, State};
use meliora_planning::Analysis;

/// Maximum number of states whose values are computed for maps.
pub const MOST_STATES: usize = 4096;

/// The values of the states of the scope.
#[derive(Debug)]
pub struct AllStates {
    /// The computed values.
    pub values: Arc<Values>,
    /// The states.
    pub states: Vec<State>,
    /// P_1, P_2, … per state.
    pub probabilities: Vec<Vec<f64>>,
    /// C_1, C_2, … per state, as far as they exist.
    pub costs: Vec<Vec<Option<f64>>>,
}

impl AllStates {
    /// Computes the values of all states; returns `None` if there are more than [`MOST_STATES`].
    /// Cost: see [`Values::compute`].
    ///
    /// # Errors
    /// The levels are not known; a limit is reached.
    pub fn compute<E: Engine>(analysis: &Analysis<E>, program: &Program) -> Result<Option<Self>> {
        let engine = analysis.engine();
        let states = engine.list_states(&engine.all_states(), MOST_STATES + 1)?;
        if states.len() > MOST_STATES {
            return Ok(None);
        }
        let levels = Values::levels_found(analysis, LEVELS);
        let options = ValueOptions { levels, exact: false, within: None };
        let mut values = Values::compute(options, analysis, program, &states, &Steps)?;
        values.decide_ties(engine)?;
        let (mut probabilities, mut costs) = (Vec::new(), Vec::new());
        for state in &states {
            let node = values.start(state);
            let known = |k| node.map(|node| (values.probability(node, k), values.cost(node, k)));
            let found: Vec<_> = (1..=levels).map(known).collect();
            probabilities.push(found.iter().map(|f| f.as_ref().map_or(0.0, |(p, _)| p.middle())).collect());
            costs.push(found.iter().map(|f| Some(f.as_ref()?.1.as_ref()?.middle())).collect());
        }
        Ok(Some(AllStates { values: Arc::new(values), states, probabilities, costs }))
    }
}
