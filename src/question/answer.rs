//! Answers to requests: whether they hold in the initial states, and the number that they ask for.

use crate::asking::Asking;
use crate::evaluate::{Number, listed, sign};
use crate::goal::Target;
use meliora_base::error::{Error, Result};
use meliora_base::exact::{Exact, Ratio};
use meliora_engine::Engine;
use meliora_engine::regions::{Regions, Which, deciding, holds};
use meliora_lang::property::{Inequality, Measure, Optimum, Over, PropertyKind, Quantity, Strategies};
use meliora_model::Program;
use meliora_model::property::Bound as Likely;
use meliora_quantities::sought::{Compute, Sought, needed};
use meliora_quantities::state_values::Bound;
use std::sync::Arc;

/// The reason why a game has no value.
pub(crate) const NEITHER: &str = "values of a game other than 0 and 1 are not supported for a formula that is neither safe nor \
    co-safe";
/// The help for it.
pub(crate) const ASK_QUALITATIVELY: &str = "ask whether it is 0 or 1, by `P>=1` and `P>0`";

/// The answer to a request.
pub struct Answer {
    /// The value over the initial states.
    pub value: Option<Bound>,
    /// True if the property holds in all of them; `None` if it is not decided.
    pub holds: Option<bool>,
    /// The reason why a quantity that was asked for has no value.
    pub no_value: Option<String>,
    /// An error if a limit was hit, after which the bounds of the value may be wide.
    pub end: Result<()>,
}

impl Answer {
    /// Creates an answer without a number.
    pub fn of(holds: Option<bool>) -> Self {
        Answer { value: None, holds, no_value: None, end: Ok(()) }
    }

    /// Creates the answer for a quantity that has no value.
    pub fn without_value(reason: impl Into<String>) -> Self {
        Answer { no_value: Some(reason.into()), ..Answer::of(None) }
    }
}

/// The input of the computation of a number.
pub struct Computing<'n> {
    /// The numbers of the initial states, if they are known.
    pub optima: Option<&'n [Number]>,
    /// The greatest width of bounds.
    pub precision: f64,
    /// True if only numbers are asked for after this one: then the way of a race that has listed the states ends the others.
    pub settles: bool,
}

impl Asking {
    /// Returns the regions that the question needs; a target without a question needs all four.
    pub fn needed(&self) -> Vec<Which> {
        match &self.question {
            None => Which::ALL.to_vec(),
            Some(PropertyKind::Qualitative(strategies, bound)) => vec![deciding(*strategies, *bound).0],
            Some(PropertyKind::Quantity(quantity)) => {
                let is_reward = matches!(quantity.measure, Measure::Reward(_));
                needed(is_reward, quantity.optimum).to_vec()
            }
        }
    }

    /// Answers the question as far as the known regions decide it: a qualitative one, or a probability that is 0 or 1 in
    /// all initial states. Cost: no image.
    ///
    /// # Errors
    /// A limit is hit.
    pub fn decided<E: Engine>(&self, engine: &E, known: &Regions<Option<E::States>>) -> Result<Answer> {
        let quantity = match &self.question {
            Some(PropertyKind::Qualitative(strategies, bound)) => {
                return Ok(Answer::of(holds(engine, (*strategies, *bound), known)?));
            }
            Some(PropertyKind::Quantity(quantity)) if quantity.measure == Measure::Probability => quantity,
            _ => return Ok(Answer::of(None)),
        };
        let (one, zero) = match quantity.optimum {
            Optimum::Max => (Strategies::Some, Strategies::All),
            Optimum::Min => (Strategies::All, Strategies::Some),
        };
        let value = if holds(engine, (one, Likely::One), known)? == Some(true) {
            Exact::Int(1)
        } else if holds(engine, (zero, Likely::Zero), known)? == Some(true) {
            Exact::Int(0)
        } else {
            return Ok(Answer::of(None));
        };
        let values = [Number::of(value)];
        let holds = quantity.bound.as_ref().and_then(|bound| truth(&values, bound));
        Ok(Answer { value: over(&values, self.over), ..Answer::of(holds) })
    }

    /// Answers the question from the regions of its formula that it needs, and a target without a question not at all. The
    /// regions contain all states, also those with monitors that are not fresh. Cost: that of [`Sought::prepare`].
    ///
    /// # Errors
    /// A limit is hit, or a reward is wrong.
    pub fn answered<E: Engine>(
        &self,
        engine: &E,
        model: &Arc<Program>,
        regions: &Regions<Option<E::States>>,
        &Computing { optima, precision, settles }: &Computing<'_>,
    ) -> Result<Answer> {
        let decided = self.decided(engine, regions)?;
        let Some(PropertyKind::Quantity(quantity)) = &self.question else { return Ok(decided) };
        if decided.value.is_some() {
            return Ok(decided);
        }
        if let Some(values) = optima {
            let holds = quantity.bound.as_ref().map(|bound| truth(values, bound));
            if holds != Some(None) {
                return Ok(Answer { value: over(values, self.over), ..Answer::of(holds.flatten()) });
            }
        }
        let (program, no_states) = (&**self.goal.program(model), engine.no_states());
        let target = match &self.goal.target {
            Target::States(target) => engine.states_where(target)?,
            Target::Formula(_) => no_states,
        };
        let sought = match (&quantity.measure, &self.goal.target) {
            (Measure::Probability, Target::Formula(condition)) => Sought::Probability(Some(condition)),
            (Measure::Probability, Target::States(_)) => Sought::Probability(None),
            (Measure::Reward(rewards), _) => {
                let unknown = || Error::Usage("unknown reward structure".to_owned());
                Sought::Reward(rewards.find(program).ok_or_else(unknown)?, &target)
            }
        };
        let states = listed(engine, &engine.initial_states())?;
        match sought.prepare((engine, program), quantity.optimum, regions, &states, settles)? {
            Some(compute) => of_values(compute, quantity, self.over, precision),
            None => Ok(Answer::without_value(format!("{NEITHER}; {ASK_QUALITATIVELY}"))),
        }
    }
}

/// Answers a question from the values of the initial states; where bounds contain that of the property, fractions decide.
fn of_values(mut compute: Compute<'_>, quantity: &Quantity, part: Over, precision: f64) -> Result<Answer> {
    let mut found = compute(precision)?;
    let numbers =
        |found: &[meliora_equations::Value]| Vec::from_iter(found.iter().cloned().map(Number::from));
    let decided = |values: &[Number]| quantity.bound.as_ref().map(|bound| truth(values, bound));
    let mut values = numbers(&found.values);
    if found.end.is_ok() && decided(&values) == Some(None) {
        match compute(0.0) {
            Ok(exact) => (values, found.end) = (numbers(&exact.values), exact.end),
            Err(e) => found.end = Err(e),
        }
    }
    let holds = decided(&values).flatten();
    Ok(Answer { value: over(&values, part), holds, no_value: None, end: found.end })
}

/// Returns the bounds over all states: the lower one of the least value, the upper one of the
/// greatest; or both of the least or the greatest value alone.
fn over(values: &[Number], part: Over) -> Option<Bound> {
    let join = |a: Number, b: &Number| match part {
        Over::All => a.range(b),
        Over::Least => a.extreme(b, false),
        Over::Greatest => a.extreme(b, true),
    };
    let (first, rest) = values.split_first()?;
    Some(rest.iter().fold(first.clone(), join).interval.into())
}

/// Returns whether all values satisfy a comparison; `None` if the bounds do not decide it.
fn truth(values: &[Number], (comparison, bound): &(Inequality, Ratio)) -> Option<bool> {
    let bound = Number::fraction(bound);
    let each: Vec<Option<bool>> =
        values.iter().map(|value| value.satisfies(sign(*comparison), &bound)).collect();
    if each.contains(&Some(false)) {
        return Some(false);
    }
    if each.contains(&None) { None } else { Some(true) }
}
