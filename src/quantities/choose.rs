//! Strategies that attain the values: a decision rule from computed quantities.

use std::sync::Arc;

use num_traits::ToPrimitive;

use crate::cost::Cost;
use crate::values::{Aim, ChoiceValues, Node, ValueOptions, Values};
use meliora_base::error::{Error, Result};
use meliora_base::interval::Bounds;
use meliora_engine::Engine;
use meliora_equations::Likely;
use meliora_model::preference::ObjectiveSet;
use meliora_model::{Program, State};
use meliora_planning::{Analysis, DecisionRule, Kind, Memory, Rank, StrategyKind};

/// The default of the greatest number of improvements with values.
pub const LEVELS: usize = 10;

meliora_base::named! {
    /// The permitted action that a strategy takes.
    #[derive(Default)]
    pub enum Choose {
        /// The first one that comes closer to an improvement.
        #[default]
        First,
        /// The one with the greatest probability of all possible improvements (SPI), or of the objective to
        /// achieve.
        Likely,
        /// The one with the least expected cost until the last certain improvement (SASI).
        Cheap,
    }
}

impl Choose {
    /// Returns what the actions are best at; `None` if they do not depend on values.
    pub fn aim(self) -> Option<Aim> {
        match self {
            Choose::First => None,
            Choose::Likely => Some(Aim::Likely),
            Choose::Cheap => Some(Aim::Cheap),
        }
    }

    /// Returns whether strategies of a kind can choose this way.
    pub fn fits(self, kind: StrategyKind) -> bool {
        match (self, kind) {
            (Choose::First, _) | (_, StrategyKind::Plan) => true,
            (Choose::Likely, kind) => matches!(kind, StrategyKind::Spi | StrategyKind::Achieve),
            (Choose::Cheap, kind) => kind == StrategyKind::Sasi,
        }
    }

    /// Returns the kind of improvements that a strategy makes: a plan makes those of its values, else
    /// the guaranteed ones.
    pub fn levels(self, kind: StrategyKind) -> Kind {
        match kind {
            StrategyKind::Achieve => kind.levels(),
            _ => self.kind().unwrap_or(kind.levels()),
        }
    }

    /// Returns the kind of improvements that the values are about; `None` for both.
    pub fn kind(self) -> Option<Kind> {
        match self {
            Choose::First => None,
            Choose::Likely => Some(Kind::Spi),
            Choose::Cheap => Some(Kind::Sasi),
        }
    }
}

/// A decision rule with values.
pub trait ValuedRule: DecisionRule {
    /// Returns the value of a state where planning starts; `None` if the state was not explored.
    fn attained(&self, state: &[i64]) -> Option<Attained>;
}

/// The value that a strategy attains from a state.
#[derive(Debug, Clone, PartialEq)]
pub struct Attained {
    /// The objective that the strategy achieves, if it does nothing else.
    pub objective: Option<String>,
    /// The number of improvements k that the strategy aims at.
    pub improvements: usize,
    /// P_k, or the probability of the objective.
    pub probability: Bounds,
    /// C_k, if the improvements are certain.
    pub cost: Option<Bounds>,
}

/// The decision rule that attains P_k or C_k.
///
/// For [`Aim::Likely`], k is the greatest number with P_k > 0, for [`Aim::Cheap`] the greatest with
/// P_k = 1: the SASI rank, or under `transition` that of `action`. Both are at most
/// [`ValueOptions::levels`](crate::ValueOptions::levels). If a step leaves the states with this number, the rule
/// continues with the greatest number that is left.
#[derive(Debug)]
pub struct Chooser {
    values: Arc<Values>,
    aim: Aim,
}

impl Chooser {
    /// Creates a rule from computed values.
    pub fn new(values: Arc<Values>, aim: Aim) -> Self {
        Chooser { values, aim }
    }

    /// Computes the values of some states for a rule; it knows the states that they reach. `levels` is
    /// the greatest number of improvements that is aimed at: by default all that are certain for
    /// [`Aim::Cheap`], and those that are possible, but at most [`LEVELS`], for [`Aim::Likely`].
    ///
    /// # Errors
    /// The errors of [`Values::compute`].
    pub fn compute<E: Engine>(
        analysis: &Analysis<E>,
        program: &Program,
        states: &[State],
        (aim, levels): (Aim, Option<usize>),
        costs: &dyn Cost,
    ) -> Result<Self> {
        let found = || match aim {
            Aim::Likely => Values::levels_found(analysis, LEVELS),
            Aim::Cheap => analysis.levels(Kind::Sasi).found.len(),
        };
        let levels = levels.unwrap_or_else(found);
        let options = ValueOptions { levels, exact: false, within: None };
        let mut values = Values::compute(options, analysis, program, states, costs)?;
        values.decide_ties(analysis.engine())?;
        Ok(Chooser::new(Arc::new(values), aim))
    }

    /// Returns the values.
    pub fn values(&self) -> &Values {
        &self.values
    }

    /// Returns the positions of the choices that attain the value of a state where planning starts, as far as
    /// the bounds tell, with the one that is taken first.
    pub fn best(&self, state: &[i64]) -> Vec<usize> {
        let Some(node) = self.values.start(state) else { return Vec::new() };
        let choices = self.values.choices(node, self.values.aimed(node, self.aim), self.aim);
        let meet = |a: &Bounds, b: &Bounds| {
            a.interval.lower <= b.interval.upper && b.interval.lower <= a.interval.upper
        };
        let Some(first) = choices.first() else { return Vec::new() };
        let is_best = |other: &&ChoiceValues| {
            meet(&first.probability, &other.probability)
                && match (&first.cost, &other.cost) {
                    (Some(a), Some(b)) => meet(a, b),
                    (a, b) => a.is_none() && b.is_none(),
                }
        };
        choices.iter().filter(is_best).map(|choice| choice.position).collect()
    }

    /// Returns the node of a state and the number of improvements that are aimed at.
    fn at(&self, memory: Memory, state: &[i64]) -> Option<(Node, usize)> {
        let Rank::Finite(level) = memory.level else { return None };
        Some((self.values.node(memory.arena, state)?, level))
    }
}

impl ValuedRule for Chooser {
    fn attained(&self, state: &[i64]) -> Option<Attained> {
        let node = self.values.start(state)?;
        let improvements = self.values.aimed(node, self.aim);
        let probability = self.values.attained_probability(node, improvements);
        let cost = self.values.attained_cost(node, improvements);
        Some(Attained { objective: None, improvements, probability, cost })
    }
}

impl DecisionRule for Chooser {
    fn level(&self, arena: Option<usize>, state: &[i64]) -> Option<usize> {
        Some(self.values.aimed(self.values.node(arena, state)?, self.aim))
    }

    fn pick(&self, memory: Memory, state: &[i64]) -> Option<usize> {
        let (node, level) = self.at(memory, state)?;
        self.values.best_choice(node, level, self.aim)
    }

    fn cost(&self, memory: Memory, state: &[i64]) -> f64 {
        let at = self.at(memory, state);
        let cost = at.and_then(|(node, level)| self.values.best_choice_cost(node, level, self.aim));
        cost.and_then(ToPrimitive::to_f64).unwrap_or(0.0)
    }

    fn after(&self, memory: Memory, from: &[i64], to: &[i64]) -> Option<(usize, bool)> {
        let (node, level) = self.at(memory, from)?;
        let (next, left) = self.values.successor(node, level, self.aim, to)?;
        Some((left.min(self.values.aimed(next, self.aim)), left < level))
    }
}

/// The decision rule that achieves an objective with the greatest probability. Where the objective is
/// almost sure, the strategy needs no rule.
#[derive(Debug)]
pub struct Achiever {
    objective: String,
    likely: Likely,
}

impl Achiever {
    /// Computes the probabilities of some states for a rule; it knows the states that they reach.
    ///
    /// # Errors
    /// [`Error::Usage`] for several objectives, or before the winning regions are known; a limit is
    /// reached, or a command has no meaning in some state.
    pub fn compute<E: Engine>(
        analysis: &Analysis<E>,
        program: &Program,
        states: &[State],
        objectives: &ObjectiveSet,
    ) -> Result<Self> {
        let mut all = objectives.iter();
        let (Some(objective), None) = (all.next(), all.next()) else {
            let message =
                "`likely` is for one objective; with `history = play`, one objective can be the conjunction";
            return Err(Error::Usage(message.to_owned()));
        };
        let regions = analysis.outcomes().and_then(|outcomes| outcomes.get(objective));
        let missing = || Error::Usage("the winning regions are not known; run the analysis first".to_owned());
        let regions = regions.ok_or_else(missing)?;
        let both = (&regions.almost_sure, &regions.positive);
        let likely = Likely::compute(analysis.engine(), program, both, states)?;
        let objective = analysis.preferences().objectives[objective].name.clone();
        Ok(Achiever { objective, likely })
    }
}

impl ValuedRule for Achiever {
    fn attained(&self, state: &[i64]) -> Option<Attained> {
        let probability = self.likely.probability(state)?;
        Some(Attained { objective: Some(self.objective.clone()), improvements: 0, probability, cost: None })
    }
}

impl DecisionRule for Achiever {
    fn level(&self, _: Option<usize>, state: &[i64]) -> Option<usize> {
        self.likely.probability(state).map(|_| 0)
    }

    fn pick(&self, _: Memory, state: &[i64]) -> Option<usize> {
        self.likely.pick(state)
    }

    fn cost(&self, _: Memory, _: &[i64]) -> f64 {
        0.0
    }

    fn after(&self, _: Memory, _: &[i64], _: &[i64]) -> Option<(usize, bool)> {
        Some((0, false))
    }
}
