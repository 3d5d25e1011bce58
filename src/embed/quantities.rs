//! Quantities of an analysis, and strategies that attain them.

use std::sync::Arc;

use super::Analysis;
use meliora_base::error::{Error, Result};
use meliora_model::State;
use meliora_planning::{FiniteMemoryStrategy, StrategyKind};
use meliora_quantities::choose::LEVELS;
use meliora_quantities::cost::Costs;
use meliora_quantities::state_values::StateValues;
use meliora_quantities::{Achiever, Choose, Chooser, Cost, Steps, ValueOptions, ValuedRule, Values};

/// The quantities that are wanted.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Wanted {
    /// The greatest number of improvements; `None` for the levels found, at most 10.
    pub levels: Option<usize>,
    /// The reward structure that is the cost of a step; `None` for steps.
    pub reward: Option<String>,
    /// Computes with fractions; for small models.
    pub exact: bool,
    /// The greatest number of steps of the success curves; `None` for no curves.
    pub within: Option<usize>,
}

impl Analysis {
    /// Computes the quantities of some states of the scope. Cost: see [`Values::compute`].
    ///
    /// # Errors
    /// [`Error::Usage`] if the analysis is not complete, or for an unknown reward structure; a reward
    /// is negative or has no value in some state of the scope; a limit is reached.
    pub fn values(&self, states: &[State], wanted: &Wanted) -> Result<Values> {
        let levels = wanted.levels.unwrap_or_else(|| Values::levels_found(self, LEVELS));
        let options = ValueOptions { levels, exact: wanted.exact, within: wanted.within };
        Values::compute(options, self, self.program(), states, &*self.cost(wanted.reward.as_deref())?)
    }

    /// Lets a strategy choose by value, for paths from some states. Without an aim, it takes the first
    /// action that makes progress.
    ///
    /// # Errors
    /// The errors of [`Analysis::values`].
    pub fn choose_by(
        &self,
        strategy: &mut FiniteMemoryStrategy,
        choose: Choose,
        states: &[State],
        wanted: &Wanted,
    ) -> Result<Option<Arc<dyn ValuedRule>>> {
        let Some(aim) = choose.aim() else { return Ok(None) };
        if strategy.kind() == StrategyKind::Achieve {
            if wanted.levels.is_some() || wanted.reward.as_deref().is_some_and(|name| name != Steps::NAME) {
                let message = "`levels` and `reward` are about improvements; the kind `achieve` aims at none";
                return Err(Error::Usage(message.to_owned()));
            }
            let rule = Arc::new(Achiever::compute(self, self.program(), states, strategy.objectives())?);
            strategy.choose_by(Arc::clone(&rule) as _);
            return Ok(Some(rule));
        }
        let costs = self.cost(wanted.reward.as_deref())?;
        let chooser = Chooser::compute(self, self.program(), states, (aim, wanted.levels), &*costs)?;
        let chooser = Arc::new(chooser);
        strategy.choose_by(Arc::clone(&chooser) as _);
        Ok(Some(chooser))
    }

    /// Returns the cost with a name, after checking it in all states of the scope.
    fn cost(&self, name: Option<&str>) -> Result<Box<dyn Cost + '_>> {
        let (program, name) = (self.program(), name.unwrap_or(Steps::NAME));
        let unknown = || Error::Usage(format!("the model has no reward structure `{name}`"));
        Costs::named(program, name).ok_or_else(unknown)?.check(self.engine(), program)
    }

    /// Returns the quantities of some states of the scope as plain data, as `meliora values` reports
    /// them.
    ///
    /// # Errors
    /// The errors of [`Analysis::values`].
    pub fn state_values(&self, states: &[State], wanted: &Wanted) -> Result<Vec<StateValues>> {
        let values = self.values(states, wanted)?;
        StateValues::all(self, self.program(), &values, states)
    }
}
