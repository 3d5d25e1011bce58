//! Answers to properties: whether they hold in the initial states, and the number that they ask for.

use std::cmp::Ordering;

use crate::answers::path_values::{self, Paths, Value, Wanted};
use crate::answers::state_values::Bound;
use crate::equations::arena::{Arena, Goal};
use crate::equations::cost::check_rewards;
use crate::equations::number::{Number, Weight};
use crate::vector::{self, Accumulation, Until};
use crate::{Bounds, Earned, Interval};
use meliora_base::error::{Error, Limit, Result};
use meliora_base::exact::{Ratio, Real};
use meliora_engine::Engine;
use meliora_engine::regions::{Regions, Which, deciding, holds};
use meliora_model::predicate::Predicate;
use meliora_model::property::{Bound as Likely, Inequality, Measure, Over, Quantity, Question, Strategies};
use meliora_model::temporal::{Asks, Condition};
use meliora_model::{Optimum, Program};

pub use crate::equations::number::PRECISION;

/// The reason why a game has no value.
const NEITHER: &str = "values of a game other than 0 and 1 are not supported for a formula that is neither safe nor \
    co-safe; ask whether it is 0 or 1, by `P>=1` and `P>0`";

/// Maximum number of initial states with values.
const MOST_STATES: usize = 1 << 20;

/// The answer to a property.
pub struct Answer {
    /// The value over the initial states.
    pub value: Option<Bound>,
    /// True if the property holds in all of them; `None` if it is not decided.
    pub holds: Option<bool>,
    /// The reason why a quantity that was asked for has no value.
    pub no_value: Option<&'static str>,
    /// An error if a limit was hit, after which the bounds of the value may be wide.
    pub end: Result<()>,
}

impl Answer {
    /// Creates an answer without a number.
    pub fn of(holds: Option<bool>) -> Self {
        Answer { value: None, holds, no_value: None, end: Ok(()) }
    }

    /// Creates the answer for a quantity that has no value.
    pub fn without_value(reason: &'static str) -> Self {
        Answer { no_value: Some(reason), ..Answer::of(None) }
    }
}

/// A property over a program.
pub struct Asked<'a> {
    /// The program, with the monitors of the property's formula.
    pub program: &'a Program,
    /// The question; `None` for a target without a property.
    pub question: Option<&'a Question>,
    /// The part of the initial states that it is about.
    pub over: Over,
    /// The target of the paths; `None` for a temporal formula.
    pub target: Option<&'a Predicate>,
    /// The condition of a temporal formula on its monitors.
    pub condition: Option<&'a Condition>,
    /// The states in which the rewards that the question names are wrong.
    pub wrong: Option<&'a Predicate>,
}

impl Asked<'_> {
    /// Returns whether the formula is safe; false if it is co-safe, `None` if it is neither.
    fn is_safe(&self) -> Option<bool> {
        match self.condition {
            Some(condition) if !condition.only_asks(Asks::Accept) => {
                condition.only_asks(Asks::Avoid).then_some(true)
            }
            _ => Some(false),
        }
    }
}

/// Returns the regions that a question needs; a target without a question needs all four.
pub fn needed(question: Option<&Question>) -> Vec<Which> {
    match question {
        None => Which::ALL.to_vec(),
        Some(Question::Qualitative(strategies, bound)) => vec![deciding(*strategies, *bound).0],
        Some(Question::Quantity(quantity)) => {
            path_values::needed(&quantity.measure, quantity.optimum).to_vec()
        }
    }
}

/// Answers a property as far as the known regions decide it: a qualitative one, or a probability
/// that is 0 or 1 in all initial states. Cost: no image.
///
/// # Errors
/// A limit is hit.
pub fn decided<E: Engine>(
    engine: &E,
    asked: &Asked<'_>,
    known: &Regions<Option<E::States>>,
) -> Result<Answer> {
    let quantity = match asked.question {
        Some(Question::Qualitative(strategies, bound)) => {
            return Ok(Answer::of(holds(engine, (*strategies, *bound), known)?));
        }
        Some(Question::Quantity(quantity)) if quantity.measure == Measure::Probability => quantity,
        _ => return Ok(Answer::of(None)),
    };
    let (one, zero) = match quantity.optimum {
        Optimum::Max => (Strategies::Some, Strategies::All),
        Optimum::Min => (Strategies::All, Strategies::Some),
    };
    let value = if holds(engine, (one, Likely::One), known)? == Some(true) {
        Ratio::one()
    } else if holds(engine, (zero, Likely::Zero), known)? == Some(true) {
        Ratio::zero()
    } else {
        return Ok(Answer::of(None));
    };
    let values = [Value::Finite(Bounds::of(&value))];
    let holds = quantity.bound.as_ref().and_then(|bound| truth(&values, bound));
    Ok(Answer { value: over(&values, asked.over), ..Answer::of(holds) })
}

/// Answers a property from the regions of its formula that it needs, and a target without a property
/// not at all. The regions contain all states, also those with monitors that are not fresh.
///
/// # Errors
/// A limit is hit, or a reward is wrong.
pub fn answer<E: Engine>(
    engine: &E,
    asked: &Asked<'_>,
    regions: &Regions<Option<E::States>>,
    precision: f64,
) -> Result<Answer> {
    let decided = decided(engine, asked, regions)?;
    let Some(Question::Quantity(quantity)) = asked.question else { return Ok(decided) };
    if decided.value.is_some() {
        return Ok(decided);
    }
    if engine.is_game() && quantity.measure == Measure::Probability && asked.is_safe().is_none() {
        return Ok(Answer::without_value(NEITHER));
    }
    let compute = match engine.is_game() {
        true => in_game(engine, asked, quantity, regions)?,
        false => of_paths(engine, asked, quantity, regions)?,
    };
    of_values(compute, quantity, asked.over, precision)
}

/// Computes the values of the initial states up to a precision, or with fractions if it is 0.
type Compute<'a> = Box<dyn FnMut(f64) -> Result<path_values::Answer> + 'a>;

/// Answers a question from the values of the initial states; where bounds contain that of the property, fractions decide.
fn of_values(mut compute: Compute<'_>, quantity: &Quantity, part: Over, precision: f64) -> Result<Answer> {
    let decided = |found: &[Value]| quantity.bound.as_ref().map(|bound| truth(found, bound));
    let mut found = compute(precision)?;
    if found.end.is_ok() && decided(&found.values) == Some(None) {
        match compute(0.0) {
            Ok(exact) => found = exact,
            Err(e) => found.end = Err(e),
        }
    }
    let holds = decided(&found.values).flatten();
    Ok(Answer { value: over(&found.values, part), holds, no_value: None, end: found.end })
}

/// Prepares the states between the regions that the initial states reach.
///
/// # Errors
/// A limit is reached, or a reward is wrong.
fn of_paths<'a, E: Engine>(
    engine: &'a E,
    asked: &Asked<'_>,
    quantity: &Quantity,
    regions: &Regions<Option<E::States>>,
) -> Result<Compute<'a>> {
    let program = asked.program;
    let target = match asked.target {
        Some(target) => engine.states_where(target)?,
        None => engine.no_states(),
    };
    if let (Some(wrong), Measure::Reward(rewards)) = (asked.wrong, &quantity.measure)
        && let Some(structure) = rewards.find(program).and_then(|at| program.rewards.get(at))
    {
        check_rewards(engine, program, structure, wrong)?;
    }
    let states = engine.list_states(&engine.initial_states(), MOST_STATES + 1)?;
    if states.len() > MOST_STATES {
        return Err(Limit::Listed(MOST_STATES as u64).into());
    }
    let wanted = wanted(program, quantity, &target)?;
    let mut paths = Paths::explore(engine, program, (&wanted, quantity.optimum), regions, &states)?;
    Ok(Box::new(move |precision| {
        let found = paths.values(precision <= 0.0)?;
        // The values of several states may be far apart; each has narrow bounds of its own.
        let is_narrow = found.values.iter().all(|value| bound(value.interval()).width() <= precision);
        if precision <= 0.0 || found.end.is_err() || is_narrow {
            return Ok(found);
        }
        match paths.values(true).and_then(|exact| exact.end.map(|()| exact.values)) {
            Ok(values) => Ok(path_values::Answer { values, end: Ok(()) }),
            Err(e) => Ok(path_values::Answer { end: Err(e), ..found }),
        }
    }))
}

/// Prepares a game: the optimum is ours, and the opponent looks for the other one.
///
/// # Errors
/// A limit is reached, or a reward is wrong.
fn in_game<'a, E: Engine>(
    engine: &'a E,
    asked: &Asked<'a>,
    quantity: &Quantity,
    regions: &Regions<Option<E::States>>,
) -> Result<Compute<'a>> {
    let optimum = quantity.optimum;
    let (arena, goal) = (Arena::new(engine, asked.program)?, Goal::against(optimum));
    let members = |set: &E::States| arena.members(engine, set);
    let initial = members(&engine.initial_states())?;
    let of_initial = move |found: path_values::Answer| {
        let values = initial.iter_ones().map(|state| found.values[state].clone()).collect();
        path_values::Answer { values, end: found.end }
    };
    Ok(match &quantity.measure {
        Measure::Probability => {
            let (one, positive) = match optimum {
                Optimum::Max => (Which::PmaxOne, Which::PmaxPositive),
                Optimum::Min => (Which::PminOne, Which::PminPositive),
            };
            let (one, positive) = (members(regions.known(one)?)?, members(regions.known(positive)?)?);
            if asked.is_safe() == Some(true) {
                // 1 minus the value of reaching the states in which it is 0: whoever stays elsewhere satisfies it.
                let until = Until { left: !one, right: !positive, least: 0, most: None };
                return Ok(Box::new(move |precision| {
                    let mut found = vector::probability(&arena, &until, goal.opposite(), precision)?;
                    found.values.iter_mut().for_each(Value::complement);
                    Ok(of_initial(found))
                }));
            }
            // The value is the probability to reach the states in which it is 1.
            let until = Until { left: positive, right: one, least: 0, most: None };
            Box::new(move |precision| vector::probability(&arena, &until, goal, precision).map(&of_initial))
        }
        Measure::Reward(rewards) => {
            let structure = rewards.find(asked.program).ok_or_else(unknown_rewards)?;
            let target = asked.target.map_or_else(|| Ok(engine.no_states()), |t| engine.states_where(t))?;
            let until = Accumulation::Until(members(&target)?);
            let rewards = arena.rewards(engine, structure)?;
            Box::new(move |precision| {
                vector::reward(&arena, &rewards, &until, goal, precision).map(&of_initial)
            })
        }
    })
}

fn unknown_rewards() -> Error {
    Error::Usage("unknown reward structure".to_owned())
}

fn wanted<'p, S>(program: &'p Program, quantity: &Quantity, target: &'p S) -> Result<Wanted<'p, S>> {
    let Measure::Reward(rewards) = &quantity.measure else { return Ok(Wanted::Probability) };
    let structure = rewards.find(program).and_then(|at| program.rewards.get(at));
    let structure = structure.ok_or_else(unknown_rewards)?;
    Ok(Wanted::Reward(Earned { program, structure }, target))
}

/// Returns the bounds over all states: the lower one of the least value, the upper one of the
/// greatest; or both of the least or the greatest value alone.
fn over(values: &[Value], part: Over) -> Option<Bound> {
    let join = |a: Interval, b: Interval| match part {
        Over::All => Interval { lower: a.lower.min(b.lower), upper: a.upper.max(b.upper) },
        Over::Least => Interval { lower: a.lower.min(b.lower), upper: a.upper.min(b.upper) },
        Over::Greatest => Interval { lower: a.lower.max(b.lower), upper: a.upper.max(b.upper) },
    };
    let all = values.iter().map(Value::interval).reduce(join)?;
    Some(bound(all))
}

fn bound(Interval { lower, upper }: Interval) -> Bound {
    Bound { lower, upper, exact: None }
}

/// Returns whether all values satisfy a comparison; `None` if the bounds do not decide it.
fn truth(values: &[Value], (comparison, bound): &(Inequality, Ratio)) -> Option<bool> {
    let each: Vec<Option<bool>> = values.iter().map(|value| satisfies(value, *comparison, bound)).collect();
    if each.contains(&Some(false)) {
        return Some(false);
    }
    if each.contains(&None) { None } else { Some(true) }
}

fn satisfies(value: &Value, comparison: Inequality, bound: &Ratio) -> Option<bool> {
    let holds = |order: Ordering| match comparison {
        Inequality::Ge => order.is_ge(),
        Inequality::Gt => order.is_gt(),
        Inequality::Le => order.is_le(),
        Inequality::Lt => order.is_lt(),
    };
    if let Value::Finite(bounds) = value
        && let Some(exact) = &bounds.exact
    {
        return Some(holds(exact.cmp(bound)));
    }
    let Interval { lower, upper } = value.interval();
    let side = |x: f64| Real::from(x).compare(&Real::Finite(bound.clone()));
    match (side(lower), side(upper)) {
        (Some(Ordering::Greater), _) => Some(holds(Ordering::Greater)),
        (_, Some(Ordering::Less)) => Some(holds(Ordering::Less)),
        _ => None,
    }
}
