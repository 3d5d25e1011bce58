//! Choices by the number of steps, for bounds: steps backward from the end, which give the values, too.

use bitvec::vec::BitVec;
use meliora_base::error::Result;
use meliora_equations::vector::{Accumulation, Asked, Stages, Until};
use meliora_equations::{Arena, Extremes, Rewards};

use super::{Optimal, choices_to_reach};

/// Returns the strategy of an until formula with bounds.
pub(super) fn until(arena: &Arena<'_>, until: &Until, goal: Extremes, precision: f64) -> Result<Optimal> {
    let (found, Stages { choices, after }) = Asked::all(arena, goal, precision).staged_probability(until)?;
    let unbounded = Until { least: 0, ..until.clone() };
    let rest = after.map(|values| choices_to_reach(arena, &unbounded, goal, &values)).transpose()?;
    let is_over = |state: usize| until.right[state] || !until.left[state];
    let ends = ((0..arena.states()).map(is_over).collect(), until.least);
    Ok(Optimal { values: found.bounds()?, stages: choices, rest, rounds: None, ends })
}

/// Returns the strategy of the rewards of some steps, or of the state after them.
pub(super) fn rewards(
    arena: &Arena<'_>,
    rewards: &Rewards,
    accumulation: &Accumulation,
    goal: Extremes,
    precision: f64,
) -> Result<Optimal> {
    let (found, stages) = Asked::all(arena, goal, precision).staged_reward(rewards, accumulation)?;
    let ends = (BitVec::repeat(false, arena.states()), 0);
    Ok(Optimal { values: found.bounds()?, stages: stages.choices, rest: None, rounds: None, ends })
}
