//! Choices that attain the best average of a step in the long run, in models of one player.
//!
//! In each end component, relative value iteration ends where one step changes all numbers by almost the same. Whatever
//! the best choices for these numbers do, each average of theirs is between the least and the greatest change.
//! M. Puterman, "Markov Decision Processes" (1994), chapter 8.

use bitvec::vec::BitVec;
use meliora_base::error::Result;
use meliora_model::Optimum;

use super::equations::{Equations, Means, rounding};
use super::{Choices, Optimal};
use meliora_base::interval::Interval;
use meliora_equations::vector::{Accumulation, Asked};
use meliora_equations::{AVERAGE_WIDTH, Arena, EndComponents, Extremes, Meter, NONE, Rewards, SWEEP_PART};

/// Returns the strategy of a long-run average.
pub(super) fn optimal(
    arena: &Arena<'_>,
    rewards: &Rewards,
    goal: Extremes,
    precision: f64,
) -> Result<Optimal> {
    let values = Asked::all(arena, goal, precision).reward(rewards, &Accumulation::LongRun)?.bounds()?;
    let mut meter = arena.meter();
    let found = arena.choices.end_components(&mut meter)?;
    let staying = Staying { means: Means::new(arena, Some(rewards)), found, optimum: goal.ours };
    let (choices, averages) = staying.found(&mut meter)?;
    let is_near = |own: f64, value: &Interval| match goal.ours {
        Optimum::Max => own >= value.lower - AVERAGE_WIDTH * value.lower.abs(),
        Optimum::Min => own <= value.upper + AVERAGE_WIDTH * value.upper.abs(),
    };
    let stay: BitVec =
        averages.iter().zip(&values).map(|(own, x)| own.is_some_and(|own| is_near(own, x))).collect();
    let equations = Equations::new(arena, goal, &values, None);
    let mut all = equations.progressing(&stay, false, &mut meter)?;
    stay.iter_ones().for_each(|state| all[state] = choices[state]);
    let ends = BitVec::repeat(false, arena.states());
    Ok(Optimal::memoryless(values, all, ends))
}

/// The choices that stay in end components.
struct Staying<'a> {
    means: Means<'a>,
    found: EndComponents,
    optimum: Optimum,
}

impl Staying<'_> {
    /// Returns the best choice of each state of an end component, and the average there.
    fn found(&self, meter: &mut Meter<'_>) -> Result<(Choices, Vec<Option<f64>>)> {
        let states = self.means.arena.states();
        let (mut choices, mut averages) = (vec![NONE; states], vec![None; states]);
        let mut x = vec![0.0; states];
        for members in self.found.members(&self.means.arena.choices) {
            let average = self.iterated(&members, &mut x, meter)?;
            for state in members {
                averages[state as usize] = Some(average);
                choices[state as usize] = self.best(state, &x).0;
            }
        }
        Ok((choices, averages))
    }

    fn inside(&self, state: u32) -> impl Iterator<Item = usize> {
        self.means.arena.choices.of(state).filter(|&choice| self.found.inside[choice])
    }

    fn best(&self, state: u32, x: &[f64]) -> (u32, f64) {
        let mut best = (NONE, 0.0);
        for choice in self.inside(state) {
            let mean = self.means.of(choice, |to| x[to]);
            let is_better = if self.optimum == Optimum::Max { mean > best.1 } else { mean < best.1 };
            if best.0 == NONE || is_better {
                best = (choice as u32, mean);
            }
        }
        best
    }

    /// Iterates until all changes are almost the same, and returns them.
    fn iterated(&self, members: &[u32], x: &mut [f64], meter: &mut Meter<'_>) -> Result<f64> {
        let mut last = f64::INFINITY;
        for sweep in 1usize.. {
            let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
            let mut next = Vec::with_capacity(members.len());
            for &state in members {
                meter.step()?;
                let change = self.best(state, x).1 - x[state as usize];
                (least, most) = (least.min(change), most.max(change));
                next.push(SWEEP_PART.mul_add(change, x[state as usize]));
            }
            let (width, average) = (most - least, f64::midpoint(least, most));
            let first = next.first().copied().unwrap_or_default();
            members.iter().zip(next).for_each(|(&state, new)| x[state as usize] = new - first);
            // From some sweep on, rounding hides changes.
            let settles = sweep.is_power_of_two() && sweep > members.len();
            if width <= rounding(members.len()) * most.abs() || settles && width >= last {
                return Ok(average);
            }
            if settles {
                last = width;
            }
        }
        Ok(0.0)
    }
}
