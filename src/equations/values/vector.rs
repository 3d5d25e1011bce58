//! Numbers of all states of an arena, or of another game: what `P`, `R` and `S` mean as operators of expressions over states.
//!
//! Every function returns one sound interval, or infinity, for each state. A `precision` of 0 asks for fractions.
//! Otherwise, fractions are computed where the bounds are wider.

use bitvec::vec::BitVec;

use crate::graphs::arena::Arena;
use crate::graphs::game_graph::{Extremes, GameGraph, Rewards};
use crate::graphs::meter::Meter;
use crate::solvers::back::{Back, Stage};
use crate::solvers::reaching::{Collected, Reaching, Vector};
use crate::solvers::{if_reached, long_run};
use crate::values::value::Answer;
use meliora_base::error::{Limit, Result};
use meliora_base::exact::Ratio;
use meliora_base::interval::Interval;
use meliora_base::number::Number;

/// Maximum number of states with values, and of steps with choices of their own.
pub const MOST_STATES: usize = 1 << 20;

/// Returns the limit of [`MOST_STATES`], which no setting raises.
pub fn too_many_states() -> Limit {
    Limit::Size { what: format!("more than {MOST_STATES} states to list") }
}

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

/// The choices that attain the values of a number with a bound on steps.
#[derive(Debug, Default)]
pub struct Stages {
    /// The choices of the steps that the bound counts, those of the first step first.
    pub choices: Vec<Stage>,
    /// The values after these steps, if the path is not decided then.
    pub after: Option<Vec<Interval>>,
}

/// A number of a path, whose mean is a value.
#[derive(Clone, Copy)]
enum Counted<'a> {
    /// 1 if the path satisfies the formula.
    Until(&'a Until),
    /// The rewards of the path.
    Reward(&'a Rewards, &'a Accumulation),
}

/// A question for the values of the states of a game.
#[derive(Clone, Copy)]
pub struct Asked<'a> {
    /// The game; an arena is one.
    pub game: &'a GameGraph,
    /// The arena whose limits of memory and time hold.
    pub arena: &'a Arena<'a>,
    /// The states whose values are wanted, in their order; `None` for all.
    pub states: Option<&'a [usize]>,
    /// The extremes that are looked for.
    pub goal: Extremes,
    /// The greatest width of bounds, relative above 1; 0 for fractions.
    pub precision: f64,
}

impl<'a> Asked<'a> {
    /// Asks for the values of all states of an arena.
    pub fn all(arena: &'a Arena<'a>, goal: Extremes, precision: f64) -> Self {
        Asked { game: arena, arena, states: None, goal, precision }
    }

    /// Computes the probability of an until formula. Cost: one pass over the game per step of bounded formulas; the equations
    /// of the states between 0 and 1 else.
    ///
    /// # Errors
    /// A limit is reached before anything is known.
    pub fn probability(&self, until: &Until) -> Result<Answer> {
        self.answer(Counted::Until(until), 1.0, None)
    }

    /// Computes the probability that the next state is in a set. Cost: one pass over the game.
    ///
    /// # Errors
    /// A limit is reached.
    pub fn next(&self, set: &BitVec) -> Result<Answer> {
        let left = BitVec::repeat(true, self.game.states());
        self.probability(&Until { left, right: set.clone(), least: 1, most: Some(1) })
    }

    /// Computes expected rewards. Cost: as [`Asked::probability`].
    ///
    /// # Errors
    /// The accumulation is not supported for the model; a limit is reached before anything is known.
    pub fn reward(&self, rewards: &Rewards, accumulation: &Accumulation) -> Result<Answer> {
        self.answer(Counted::Reward(rewards, accumulation), f64::INFINITY, None)
    }

    /// Computes the long-run fraction of time in a set, for models of one player.
    ///
    /// # Errors
    /// Players look for different extremes; a limit is reached before anything is known.
    pub fn long_run(&self, set: &BitVec) -> Result<Answer> {
        let rewards = Rewards::of_set(self.game, set);
        self.answer(Counted::Reward(&rewards, &Accumulation::LongRun), 1.0, None)
    }

    /// Does the same as [`Asked::probability`] for a formula with a bound on steps, and returns the choices.
    ///
    /// # Errors
    /// A limit is reached; there are more than [`MOST_STATES`] steps.
    pub fn staged_probability(&self, until: &Until) -> Result<(Answer, Stages)> {
        self.staged(Counted::Until(until), until.most.unwrap_or(until.least), 1.0)
    }

    /// Does the same as [`Asked::reward`] for [`Accumulation::Within`] and [`Accumulation::At`], and returns the choices; for
    /// others there are none.
    ///
    /// # Errors
    /// A limit is reached; there are more than [`MOST_STATES`] steps.
    pub fn staged_reward(&self, rewards: &Rewards, accumulation: &Accumulation) -> Result<(Answer, Stages)> {
        let (Accumulation::Within(steps) | Accumulation::At(steps)) = *accumulation else {
            return Ok((self.reward(rewards, accumulation)?, Stages::default()));
        };
        self.staged(Counted::Reward(rewards, accumulation), steps, f64::INFINITY)
    }

    fn staged(&self, counted: Counted<'_>, steps: u64, most: f64) -> Result<(Answer, Stages)> {
        // A strategy has at least one node for each step.
        if steps > MOST_STATES as u64 {
            return Err(too_many_states().into());
        }
        let mut stages = Stages::default();
        let answer = self.answer(counted, most, Some(&mut stages))?;
        stages.choices.reverse();
        Ok((answer, stages))
    }

    /// Computes bounds with the precision, and fractions where they are too wide or asked for, as an answer in which no
    /// value exceeds `most`.
    fn answer(&self, counted: Counted<'_>, most: f64, mut stages: Option<&mut Stages>) -> Result<Answer> {
        if self.precision <= 0.0 {
            return Ok(self.found::<Ratio>(counted, stages)?.answer(most));
        }
        let mut found = self.found::<Interval>(counted, stages.as_deref_mut())?;
        let is_narrow = found.values.iter().flatten().all(|x| x.relative_width() <= self.precision);
        if !is_narrow && found.end.is_ok() {
            let mut exact_stages = Stages::default();
            let wanted = stages.is_some().then_some(&mut exact_stages);
            match self.found::<Ratio>(counted, wanted) {
                Ok(exact) => {
                    stages.into_iter().for_each(|stages| *stages = std::mem::take(&mut exact_stages));
                    return Ok(exact.answer(most));
                }
                Err(e) => found.end = Err(e),
            }
        }
        Ok(found.answer(most))
    }

    /// Computes the values of the wanted states.
    fn found<N: Number>(&self, counted: Counted<'_>, stages: Option<&mut Stages>) -> Result<Vector<N>> {
        let mut meter = self.arena.meter();
        meter.take(2 * N::BYTES * self.game.states())?;
        let found = match counted {
            Counted::Until(until) => self.until(until, stages, &mut meter)?,
            Counted::Reward(rewards, accumulation) => {
                self.earned(rewards, accumulation, stages, &mut meter)?
            }
        };
        let Some(states) = self.states else { return Ok(found) };
        let values = states.iter().map(|&state| found.values[state].clone()).collect();
        Ok(Vector { values, end: found.end })
    }

    fn until<N: Number>(
        &self,
        until: &Until,
        mut stages: Option<&mut Stages>,
        meter: &mut Meter<'_>,
    ) -> Result<Vector<N>> {
        let &Asked { game, goal, .. } = self;
        let Until { left, right, least, most } = until;
        let back = Back::new(game, goal, None, meter)?;
        let mut end = Ok(());
        let x = match most {
            Some(most) if most < least => vec![N::zero(); game.states()],
            Some(most) => {
                let fixed = |state: usize| match (right[state], left[state]) {
                    (true, _) => Some(N::one()),
                    (false, true) => None,
                    (false, false) => Some(N::zero()),
                };
                let x = right.iter().map(|inside| if *inside { N::one() } else { N::zero() }).collect();
                back.steps((x, most - least), fixed, choices(&mut stages), meter)?
            }
            None => {
                let reaching = Reaching { game, target: right, left, collected: Collected::Target, goal };
                let found = reaching.values::<N>(meter)?;
                end = found.end;
                found.values.into_iter().map(|x| x.unwrap_or_else(N::zero)).collect()
            }
        };
        if let (Some(stages), None) = (&mut stages, most) {
            std::mem::replace(&mut end, Ok(()))?;
            stages.after = Some(x.iter().map(Number::bounds).collect());
        }
        let fixed = |state: usize| (!left[state]).then(N::zero);
        let steps = most.map_or(*least, |most| most.min(*least));
        let values = back.steps((x, steps), fixed, choices(&mut stages), meter)?;
        Ok(Vector { end, ..Vector::of(values) })
    }

    fn earned<N: Number>(
        &self,
        rewards: &Rewards,
        accumulation: &Accumulation,
        mut stages: Option<&mut Stages>,
        meter: &mut Meter<'_>,
    ) -> Result<Vector<N>> {
        let &Asked { game, goal, .. } = self;
        let collected = |collected: Collected<'_>, target: &BitVec, meter: &mut Meter<'_>| {
            let left = BitVec::repeat(true, game.states());
            Reaching { game, target, left: &left, collected, goal }.values::<N>(meter)
        };
        let mut steps = |x: Vec<N>, count: u64, rewards: Option<&Rewards>, meter: &mut Meter<'_>| {
            let back = Back::new(game, goal, rewards, meter)?;
            back.steps((x, count), |_| None, choices(&mut stages), meter).map(Vector::of)
        };
        match accumulation {
            Accumulation::Until(target) => collected(Collected::Until(rewards), target, meter),
            Accumulation::Anyway(target) => collected(Collected::Always(rewards), target, meter),
            Accumulation::IfReached(target) => if_reached::values(game, rewards, target, goal, meter),
            Accumulation::Total => {
                let nowhere = BitVec::repeat(false, game.states());
                collected(Collected::Always(rewards), &nowhere, meter)
            }
            Accumulation::Within(count) => {
                steps(vec![N::zero(); game.states()], *count, Some(rewards), meter)
            }
            Accumulation::At(count) => {
                let x = (0..game.states()).map(|state| N::of(rewards.state(state))).collect();
                steps(x, *count, None, meter)
            }
            Accumulation::LongRun => long_run::values(game, rewards, goal, meter),
        }
    }
}

/// Returns the list to which steps add their choices.
fn choices<'s>(stages: &'s mut Option<&mut Stages>) -> Option<&'s mut Vec<Stage>> {
    stages.as_deref_mut().map(|stages| &mut stages.choices)
}
