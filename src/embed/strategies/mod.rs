//! Strategies as reports and files show them: states with reasons, policies, runs.

mod explaining;
mod policy;
mod runs;

use std::sync::Arc;

pub use self::explaining::{Explaining, refuse_more};
pub use self::policy::PolicyNodes;
pub use self::runs::{Runs, opponent};
use super::quantities::choose_by;
use super::results::strategy_of;
use meliora_base::error::Result;
use meliora_engine::Engine;
use meliora_model::preference::ObjectiveSet;
use meliora_model::{Program, State};
use meliora_planning::{Analysis, FiniteMemoryStrategy, Phase, StrategyKind};
use meliora_quantities::cost::Costs;
use meliora_quantities::{Choose, ValuedRule};

/// The strategy that is asked for.
#[derive(Debug, Clone)]
pub struct StrategyOptions {
    /// Its kind.
    pub kind: StrategyKind,
    /// The action that it takes among the permitted ones.
    pub choose: Choose,
    /// The objectives that it achieves or pursues.
    pub objectives: ObjectiveSet,
    /// The cost of a step, if the choice depends on costs.
    pub costs: Costs,
    /// The greatest number of improvements that the choice aims at; `None` for those that fit.
    pub levels: Option<usize>,
}

impl StrategyOptions {
    /// Returns the phases for the levels that the strategy needs.
    pub fn phases(&self) -> &'static [Phase] {
        match (self.choose, self.choose.levels(self.kind)) {
            (Choose::First, meliora_planning::Kind::Sasi) => &[Phase::Sasi],
            (Choose::First, meliora_planning::Kind::Spi) => &[Phase::Spi],
            (Choose::Likely | Choose::Cheap, _) => &[Phase::Sasi, Phase::Spi],
        }
    }

    /// Returns the strategy of an analysis, before values are attached to it; see [`strategy_of`].
    ///
    /// # Errors
    /// The errors of [`strategy_of`].
    pub fn strategy<E: Engine>(
        &self,
        analysis: &Analysis<E>,
        program: &Arc<Program>,
    ) -> Result<FiniteMemoryStrategy<E>> {
        strategy_of(analysis, program, self.kind, self.choose.levels(self.kind), &self.objectives)
    }

    /// Lets the strategy take the actions that attain the values of some states; returns nothing for [`Choose::First`].
    /// Needs the levels of both kinds.
    ///
    /// # Errors
    /// A reward is wrong in some state, or a limit is reached.
    pub fn attach<E: Engine>(
        &self,
        analysis: &Analysis<E>,
        program: &Program,
        states: &[State],
        strategy: &mut FiniteMemoryStrategy<E>,
    ) -> Result<Option<Arc<dyn ValuedRule>>> {
        choose_by(analysis, program, strategy, self.choose, states, (self.levels, &self.costs))
    }
}
