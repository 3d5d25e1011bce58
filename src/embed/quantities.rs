//! Quantities of an analysis, and strategies that attain them.

use std::sync::Arc;

use super::Analysis;
use meliora_base::error::{Error, Result};
use meliora_engine::Engine;
use meliora_model::{Program, State};
use meliora_planning::{self as planning, FiniteMemoryStrategy, StrategyKind};
use meliora_quantities::choose::LEVELS;
use meliora_quantities::cost::Costs;
use meliora_quantities::state_values::StateValues;
use meliora_quantities::{Achiever, Choose, Chooser, Steps, ValueOptions, ValuedRule, Values};

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
        let (program, costs) = (self.program(), self.costs(wanted.reward.as_deref())?);
        Values::compute(options, self, program, states, &*costs.check(self.engine(), program)?)
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
        let aims = choose.aim().is_some() && strategy.kind() == StrategyKind::Achieve;
        if aims && (wanted.levels.is_some() || wanted.reward.as_deref().is_some_and(|own| own != Steps::NAME))
        {
            let message = "`levels` and `reward` are about improvements; the kind `achieve` aims at none";
            return Err(Error::Usage(message.to_owned()));
        }
        let reward = wanted.reward.as_deref().filter(|_| choose.aim().is_some());
        let costs = self.costs(reward)?;
        choose_by(self, self.program(), strategy, choose, states, (wanted.levels, &costs))
    }

    /// Returns the cost with a name.
    fn costs(&self, name: Option<&str>) -> Result<Costs> {
        let name = name.unwrap_or(Steps::NAME);
        let unknown = || Error::Usage(format!("the model has no reward structure `{name}`"));
        Costs::named(self.program(), name).ok_or_else(unknown)
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

/// Lets a strategy take the actions that attain the values of some states; returns nothing for [`Choose::First`]. Needs the
/// levels of both kinds. The choice aims at `levels` improvements; `None` for those that fit. Cost: see
/// [`Chooser::compute`] and [`Achiever::compute`].
///
/// # Errors
/// A reward is wrong in some state, or a limit is reached.
pub(super) fn choose_by<E: Engine>(
    analysis: &planning::Analysis<E>,
    program: &Program,
    strategy: &mut FiniteMemoryStrategy<E>,
    choose: Choose,
    states: &[State],
    (levels, costs): (Option<usize>, &Costs),
) -> Result<Option<Arc<dyn ValuedRule>>> {
    let Some(aim) = choose.aim() else { return Ok(None) };
    let rule: Arc<dyn ValuedRule> = if strategy.kind() == StrategyKind::Achieve {
        let rule = Arc::new(Achiever::compute(analysis, program, states, strategy.objectives())?);
        strategy.choose_by(Arc::clone(&rule) as _);
        rule
    } else {
        let costs = costs.check(analysis.engine(), program)?;
        let rule = Arc::new(Chooser::compute(analysis, program, states, (aim, levels), &*costs)?);
        strategy.choose_by(Arc::clone(&rule) as _);
        rule
    };
    Ok(Some(rule))
}
