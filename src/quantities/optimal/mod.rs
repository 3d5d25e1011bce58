//! Strategies that attain the optimum of one operator in a model or a game, from the values of all states.
//!
//! | module | contents |
//! | --- | --- |
//! | `equations` | the choices that keep the value, and those of them that make progress |
//! | `steps` | choices by the number of steps, for bounds |
//! | `rounds` | choices that visit sets again and again, for formulas that recur |
//! | `average` | choices that attain an average in the long run |
//! | `nodes` | the states that a strategy visits, with its memory |
//! | `attained` | the value that a strategy attains |
//!
//! A choice keeps the value if the bounds that its side guarantees hold after one step: lower bounds for the maximiser,
//! upper bounds for the minimiser. Upper bounds that hold so are never exceeded. Lower bounds are attained if paths also
//! come to their end, so a search backward from the ends orders the choices. The values have errors. So nothing here is
//! a proof: the value that a strategy attains is computed again from its nodes.

mod attained;
mod average;
mod equations;
mod nodes;
mod rounds;
mod steps;

use bitvec::vec::BitVec;
use meliora_base::error::{Error, Result};
use meliora_model::Optimum;

pub use self::attained::attained;
use self::equations::Equations;
pub use self::nodes::Nodes;
use self::rounds::Rounds;
use meliora_base::interval::Interval;
use meliora_equations::vector::{Accumulation, Asked, Until};
use meliora_equations::{Arena, Extremes, NONE, Rewards, Stage};

/// The number whose optimum is wanted.
pub enum Aim<'a> {
    /// The probability of an until formula.
    Until(&'a Until),
    /// The probability that one of some conditions holds in the long run; in models of one player.
    Recur(&'a [Accepting]),
    /// A reward.
    Reward(&'a Rewards, &'a Accumulation),
}

/// A condition on the states that a path visits again and again.
pub struct Accepting {
    /// It visits only these from some step on.
    pub always: BitVec,
    /// It visits each of these sets infinitely often.
    pub again: Vec<BitVec>,
}

/// The choice of each state, [`NONE`] in those of the opponent.
type Choices = Vec<u32>;

/// A strategy for all states of an arena.
pub struct Optimal {
    /// The values of the states.
    pub values: Vec<Interval>,
    /// The choices by the number of steps so far.
    stages: Vec<Stage>,
    /// The choices after these steps; `None` if the path is decided then.
    rest: Option<Choices>,
    rounds: Option<Rounds>,
    /// The states in which the path is decided after some steps, and the number of these.
    ends: (BitVec, u64),
}

impl Optimal {
    /// Returns a strategy without stages.
    fn memoryless(values: Vec<Interval>, choices: Choices, ends: BitVec) -> Self {
        Optimal { values, stages: Vec::new(), rest: Some(choices), rounds: None, ends: (ends, 0) }
    }

    /// Lets the strategy continue where paths are decided.
    pub fn never_ends(&mut self) {
        self.ends.0.fill(false);
    }
}

/// Computes a strategy that attains an optimum from all states, up to the precision of the values; 0 asks for
/// fractions. Cost: that of the values, and some passes over the arena; of a bound, one pass per step.
///
/// # Errors
/// The errors of [`Asked::probability`] and [`Asked::reward`]; the choices of all steps do not fit into the memory.
pub fn optimal(arena: &Arena<'_>, aim: &Aim<'_>, goal: Extremes, precision: f64) -> Result<Optimal> {
    match aim {
        Aim::Until(until) if until.least > 0 || until.most.is_some() => {
            steps::until(arena, until, goal, precision)
        }
        Aim::Until(until) => reached(arena, until, goal, precision),
        Aim::Recur(all) => recurring(arena, all, goal, precision),
        Aim::Reward(rewards, accumulation) => match accumulation {
            Accumulation::Within(_) | Accumulation::At(_) => {
                steps::rewards(arena, rewards, accumulation, goal, precision)
            }
            Accumulation::LongRun => average::optimal(arena, rewards, goal, precision),
            Accumulation::IfReached(_) => {
                let message = "strategies for `F0` depend on the reward so far, and are not supported: ask for `Fc`, or \
                               let a variable of the model count the reward";
                Err(Error::Usage(message.to_owned()))
            }
            Accumulation::Until(target) | Accumulation::Anyway(target) => {
                earned(arena, rewards, (accumulation, target), goal, precision)
            }
            Accumulation::Total => {
                let nowhere = BitVec::repeat(false, arena.states());
                earned(arena, rewards, (accumulation, &nowhere), goal, precision)
            }
        },
    }
}

/// Returns the strategy of an until formula without bounds.
fn reached(arena: &Arena<'_>, until: &Until, goal: Extremes, precision: f64) -> Result<Optimal> {
    let values = Asked::all(arena, goal, precision).probability(until)?.bounds()?;
    let choices = choices_to_reach(arena, until, goal, &values)?;
    let is_end = |state: usize| until.right[state] || !until.left[state];
    Ok(Optimal::memoryless(values, choices, (0..arena.states()).map(is_end).collect()))
}

/// Returns the choices of an until formula without bounds that has these values.
fn choices_to_reach(
    arena: &Arena<'_>,
    until: &Until,
    goal: Extremes,
    values: &[Interval],
) -> Result<Choices> {
    let is_over = |state: usize| until.right[state] || !until.left[state] || values[state].upper == 0.0;
    let over: BitVec = (0..arena.states()).map(is_over).collect();
    Equations::new(arena, goal, values, None).progressing(&over, false, &mut arena.meter())
}

/// Returns the strategy that satisfies one of some conditions: it reaches a component that it can stay in, and visits the
/// sets of its condition there, one after the other.
fn recurring(arena: &Arena<'_>, all: &[Accepting], goal: Extremes, precision: f64) -> Result<Optimal> {
    let rounds = Rounds::new(arena, all)?;
    let left = BitVec::repeat(true, arena.states());
    let until = Until::unbounded(left, rounds.members());
    let mut found = reached(arena, &until, goal, precision)?;
    found.never_ends();
    found.rounds = Some(rounds);
    Ok(found)
}

/// Returns the strategy of the rewards of the steps before a target, which is to be reached or not.
fn earned(
    arena: &Arena<'_>,
    rewards: &Rewards,
    (accumulation, target): (&Accumulation, &BitVec),
    goal: Extremes,
    precision: f64,
) -> Result<Optimal> {
    let values = Asked::all(arena, goal, precision).reward(rewards, accumulation)?.bounds()?;
    let equations = Equations::new(arena, goal, &values, Some(rewards));
    let is_infinite = |value: &Interval| goal.ours == Optimum::Max && value.lower.is_infinite();
    let is_endless = values.iter().any(is_infinite);
    let (mut choices, endless) = if let Accumulation::Until(_) = accumulation {
        // An infinite reward is attained by paths that miss the target.
        let until = Until::unbounded(BitVec::repeat(true, arena.states()), target.clone());
        let missing = || reached(arena, &until, goal.opposite(), precision);
        let choices = equations.progressing(target, false, &mut arena.meter())?;
        (choices, is_endless.then(missing).transpose()?.and_then(|missing| missing.rest))
    } else {
        let is_over = |state: usize| target[state] || values[state].upper == 0.0;
        let over: BitVec = (0..arena.states()).map(is_over).collect();
        let choices = equations.progressing(&over, true, &mut arena.meter())?;
        (choices, is_endless.then(|| equations.earning_again(rewards, target)).transpose()?)
    };
    for (state, endless) in endless.into_iter().flatten().enumerate() {
        if is_infinite(&values[state]) && endless != NONE {
            choices[state] = endless;
        }
    }
    Ok(Optimal::memoryless(values, choices, target.clone()))
}
