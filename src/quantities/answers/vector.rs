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

/// Computes values by [`refined`] with an expression, in which a name stands for the kind of numbers. The expression also
/// returns something else about the values.
macro_rules! computed_with {
    ($precision:expr, $most:expr, $number:ident => $values:expr) => {{
        let near = || {
            type $number = meliora_base::interval::Interval;
            $values
        };
        $crate::vector::refined(($precision, $most), near, || {
            type $number = meliora_base::exact::Ratio;
            $values
        })
    }};
}
pub(crate) use computed_with;

/// Does the same for values alone.
macro_rules! computed {
    ($precision:expr, $most:expr, $number:ident => $values:expr) => {
        $crate::vector::computed_with!($precision, $most, $number => Ok(($values?, ()))).map(|(found, ())| found)
    };
}
pub(crate) use computed;

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
    computed!(precision, 1.0, N => until_of::<N>(arena, until, goal, &mut arena.meter()))
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
    computed!(precision, 1.0, N => found::<N>(arena, set, goal))
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
    computed!(precision, f64::INFINITY, N => reward_of::<N>(arena, rewards, accumulation, goal, &mut arena.meter()))
}

/// Computes the long-run fraction of time in a set, for models of one player.
///
/// # Errors
/// Players look for different extremes; a limit is reached before anything is known.
pub fn long_run(arena: &Arena<'_>, set: &BitVec, goal: Extremes, precision: f64) -> Result<Answer> {
    let rewards = Rewards::of_set(arena, set);
    let average = &Accumulation::LongRun;
    computed!(precision, 1.0, N => reward_of::<N>(arena, &rewards, average, goal, &mut arena.meter()))
}

/// Computes bounds with a precision, and fractions where they are too wide or asked for, as an answer in which no value
/// exceeds `most`. Also returns the other results of the same computation.
pub(crate) fn refined<T>(
    (precision, most): (f64, f64),
    bounds: impl FnOnce() -> Result<(Vector<Interval>, T)>,
    exact: impl FnOnce() -> Result<(Vector<Ratio>, T)>,
) -> Result<(Answer, T)> {
    if precision <= 0.0 {
        return exact().map(|(found, more)| (found.answer(most), more));
    }
    let (mut found, more) = bounds()?;
    let is_narrow = found.values.iter().flatten().all(|x| x.relative_width() <= precision);
    if !is_narrow && found.end.is_ok() {
        match exact() {
            Ok((exact, more)) => return Ok((exact.answer(most), more)),
            Err(e) => found.end = Err(e),
        }
    }
    Ok((found.answer(most), more))
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

    /// Returns the values as an answer; none exceeds `most`.
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
