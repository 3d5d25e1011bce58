//! Numbers of all states of an arena: what `P`, `R` and `S` mean as operators of expressions over states.
//!
//! Every function returns one sound interval, or infinity, for each state. A `precision` of 0 asks for fractions.
//! Otherwise, fractions are computed where the bounds are wider.

use bitvec::vec::BitVec;

use crate::equations::arena::{Arena, Extremes, GameGraph, Rewards};
use crate::equations::meter::Meter;
use crate::path_values::{Answer, Value};
use crate::solvers::back::Back;
use crate::solvers::reaching::{Collected, Reaching, Vector};
use crate::solvers::{if_reached, long_run};
use meliora_base::error::Result;
use meliora_base::exact::Ratio;
use meliora_base::interval::{Bounds, Interval};
use meliora_base::number::Number;

/// The paths that reach a state of `right` through states of `left`, after at least `least` and at most `most` steps.
#[derive(Debug, Clone)]
pub struct Until {
    /// The states before.
    pub left: BitVec,
    /// The states to be reached.
    pub right: BitVec,
    /// The least number of steps; usually 0.
    pub least: u64,
    /// The greatest number of steps, if there is one.
    pub most: Option<u64>,
}

impl Until {
    /// Returns the formula `left U right`, without a bound on steps.
    pub fn unbounded(left: BitVec, right: BitVec) -> Self {
        Until { left, right, least: 0, most: None }
    }
}

/// The way in which rewards are accumulated.
#[derive(Debug, Clone)]
pub enum Accumulation {
    /// Until a state of the set is reached: `F t`. Infinite where that is not sure.
    Until(BitVec),
    /// Until a state of the set is reached, and in all steps where none is: `Fc t`.
    Anyway(BitVec),
    /// Until a state of the set is reached, and nothing where none is: `F0 t`.
    IfReached(BitVec),
    /// In the first steps: `C<=k`.
    Within(u64),
    /// In all steps: `C`. Infinite if a positive reward recurs with positive probability.
    Total,
    /// The reward of the state after some steps: `I=k`.
    At(u64),
    /// The average per step over the long run: `S`.
    LongRun,
}

/// Computes the probability of an until formula in all states. Cost: one pass over the arena per step of bounded
/// formulas; the equations of the states between 0 and 1 else.
///
/// # Errors
/// A limit is reached before anything is known.
pub fn probability(arena: &Arena<'_>, until: &Until, goal: Extremes, precision: f64) -> Result<Answer> {
    Ok(probabilities(arena, until, goal, precision)?.answer(1.0))
}

/// Computes the same as [`probability`], without the form of an answer.
///
/// # Errors
/// See [`probability`].
pub(crate) fn probabilities(
    arena: &Arena<'_>,
    until: &Until,
    goal: Extremes,
    precision: f64,
) -> Result<Computed> {
    let near = || until_of::<Interval>(arena, until, goal, &mut arena.meter());
    computed(precision, near, || until_of::<Ratio>(arena, until, goal, &mut arena.meter()))
}

/// Computes the probability that the next state is in a set. Cost: one pass over the arena.
///
/// # Errors
/// A limit is reached.
pub fn next(arena: &Arena<'_>, set: &BitVec, goal: Extremes, precision: f64) -> Result<Answer> {
    fn found<N: Number>(arena: &Arena<'_>, set: &BitVec, goal: Extremes) -> Result<Vector<N>> {
        let mut meter = arena.meter();
        let x = indicator(set);
        let back = Back::new(arena, goal, None, &mut meter)?;
        back.steps(x, 1, &mut meter, |_, best| best()).map(Vector::of)
    }
    let near = || found::<Interval>(arena, set, goal);
    Ok(computed(precision, near, || found::<Ratio>(arena, set, goal))?.answer(1.0))
}

/// Computes expected rewards in all states. Cost: as [`probability`].
///
/// # Errors
/// The accumulation is not supported for the model; a limit is reached before anything is known.
pub fn reward(
    arena: &Arena<'_>,
    rewards: &Rewards,
    accumulation: &Accumulation,
    goal: Extremes,
    precision: f64,
) -> Result<Answer> {
    Ok(rewards_of_all(arena, rewards, accumulation, goal, precision)?.answer(f64::INFINITY))
}

/// Computes the same as [`reward`], without the form of an answer.
///
/// # Errors
/// See [`reward`].
pub(crate) fn rewards_of_all(
    arena: &Arena<'_>,
    rewards: &Rewards,
    accumulation: &Accumulation,
    goal: Extremes,
    precision: f64,
) -> Result<Computed> {
    let near = || reward_of::<Interval>(arena, rewards, accumulation, goal, &mut arena.meter());
    computed(precision, near, || reward_of::<Ratio>(arena, rewards, accumulation, goal, &mut arena.meter()))
}

/// Computes the long-run fraction of time in a set, for models of one player.
///
/// # Errors
/// Players look for different extremes; a limit is reached before anything is known.
pub fn long_run(arena: &Arena<'_>, set: &BitVec, goal: Extremes, precision: f64) -> Result<Answer> {
    let rewards = Rewards::of_set(arena, set);
    let mut found = reward(arena, &rewards, &Accumulation::LongRun, goal, precision)?;
    for value in &mut found.values {
        if let Value::Finite(bounds) = value {
            bounds.interval.upper = bounds.interval.upper.min(1.0);
        }
    }
    Ok(found)
}

/// The values of all states as they were computed.
pub(crate) enum Computed {
    Near(Vector<Interval>),
    Exact(Vector<Ratio>),
}

impl Computed {
    /// Returns the values as an answer; none exceeds `most`.
    pub(crate) fn answer(self, most: f64) -> Answer {
        match self {
            Computed::Near(found) => found.answer(most),
            Computed::Exact(found) => found.answer(most),
        }
    }

    /// Returns the bounds of the values, which may be infinite; none exceeds `most`.
    ///
    /// # Errors
    /// A limit was reached.
    pub(crate) fn bounds(self, most: f64) -> Result<Vec<Interval>> {
        let of = |x: Option<Interval>| match x {
            Some(Interval { lower, upper }) => Interval { lower, upper: upper.min(most) },
            None => Interval::point(f64::INFINITY),
        };
        match self {
            Computed::Near(found) => found.end.map(|()| found.values.into_iter().map(of).collect()),
            Computed::Exact(found) => {
                found.end.map(|()| found.values.iter().map(|x| of(x.as_ref().map(Number::bounds))).collect())
            }
        }
    }

    /// Forgets all but the values of the first states.
    pub(crate) fn first(self, count: usize) -> Self {
        match self {
            Computed::Near(found) => Computed::Near(found.first(count)),
            Computed::Exact(found) => Computed::Exact(found.first(count)),
        }
    }
}

/// Computes bounds, and fractions where these are too wide or asked for.
pub(crate) fn computed(
    precision: f64,
    bounds: impl FnOnce() -> Result<Vector<Interval>>,
    exact: impl FnOnce() -> Result<Vector<Ratio>>,
) -> Result<Computed> {
    if precision <= 0.0 {
        return exact().map(Computed::Exact);
    }
    let found = bounds()?;
    let is_narrow = found.values.iter().flatten().all(|x| x.relative_width() <= precision);
    if is_narrow || found.end.is_err() {
        return Ok(Computed::Near(found));
    }
    Ok(match exact() {
        Ok(exact) => Computed::Exact(exact),
        Err(e) => Computed::Near(Vector { end: Err(e), ..found }),
    })
}

impl<N: Number> Vector<N> {
    /// Creates a vector of finite values.
    pub(crate) fn of(values: Vec<N>) -> Self {
        Vector { values: values.into_iter().map(Some).collect(), end: Ok(()) }
    }

    /// Returns the values at some positions.
    pub(crate) fn selected(self, positions: &[usize]) -> Self {
        let values = positions.iter().map(|&at| self.values[at].clone()).collect();
        Vector { values, end: self.end }
    }

    fn first(mut self, count: usize) -> Self {
        self.values.truncate(count);
        self
    }

    pub(crate) fn answer(self, most: f64) -> Answer {
        let value = |x: Option<N>| match x {
            None => Value::Infinite,
            Some(x) => Value::Finite(Bounds::of(&x).at_most(most)),
        };
        Answer { values: self.values.into_iter().map(value).collect(), end: self.end }
    }
}

/// Returns 1 in the states of a set, and 0 in all others.
pub(crate) fn indicator<N: Number>(set: &BitVec) -> Vec<N> {
    set.iter().map(|inside| if *inside { N::one() } else { N::zero() }).collect()
}

/// Computes the probabilities of an until formula in all states of a game.
///
/// # Errors
/// A limit is reached before anything is known.
pub(crate) fn until_of<N: Number>(
    game: &GameGraph,
    until: &Until,
    goal: Extremes,
    meter: &mut Meter<'_>,
) -> Result<Vector<N>> {
    let Until { left, right, least, most } = until;
    meter.take(2 * N::BYTES * game.states())?;
    let back = Back::new(game, goal, None, meter)?;
    let (x, end) = match most {
        Some(most) if most < least => (vec![N::zero(); game.states()], Ok(())),
        Some(most) => {
            let step = |state: usize, best: &dyn Fn() -> N| match (right[state], left[state]) {
                (true, _) => N::one(),
                (false, true) => best(),
                (false, false) => N::zero(),
            };
            (back.steps(indicator(right), most - least, meter, step)?, Ok(()))
        }
        None => {
            let reaching = Reaching { game, target: right, left, collected: Collected::Target, goal };
            let found = reaching.values::<N>(meter)?;
            (found.values.into_iter().map(|x| x.unwrap_or_else(N::zero)).collect(), found.end)
        }
    };
    let step = |state: usize, best: &dyn Fn() -> N| if left[state] { best() } else { N::zero() };
    let values = back.steps(x, *least, meter, step)?;
    Ok(Vector { end, ..Vector::of(values) })
}

/// Computes rewards in all states of a game.
///
/// # Errors
/// A limit is reached before anything is known.
pub(crate) fn reward_of<N: Number>(
    game: &GameGraph,
    rewards: &Rewards,
    accumulation: &Accumulation,
    goal: Extremes,
    meter: &mut Meter<'_>,
) -> Result<Vector<N>> {
    meter.take(2 * N::BYTES * game.states())?;
    let collected = |collected: Collected<'_>, target: &BitVec, meter: &mut Meter<'_>| {
        let left = BitVec::repeat(true, game.states());
        Reaching { game, target, left: &left, collected, goal }.values::<N>(meter)
    };
    match accumulation {
        Accumulation::Until(target) => collected(Collected::Until(rewards), target, meter),
        Accumulation::Anyway(target) => collected(Collected::Always(rewards), target, meter),
        Accumulation::IfReached(target) => if_reached::values(game, rewards, target, goal, meter),
        Accumulation::Total => {
            let nowhere = BitVec::repeat(false, game.states());
            collected(Collected::Always(rewards), &nowhere, meter)
        }
        Accumulation::Within(steps) => {
            let back = Back::new(game, goal, Some(rewards), meter)?;
            let x = vec![N::zero(); game.states()];
            back.steps(x, *steps, meter, |_, best| best()).map(Vector::of)
        }
        Accumulation::At(steps) => {
            let back = Back::new(game, goal, None, meter)?;
            let x = (0..game.states()).map(|state| N::of(rewards.state(state))).collect();
            back.steps(x, *steps, meter, |_, best| best()).map(Vector::of)
        }
        Accumulation::LongRun => long_run::values(game, rewards, goal, meter),
    }
}
