//! Choices by the number of steps, for bounds: steps backward from the end.

use std::sync::Arc;

use bitvec::vec::BitVec;
use meliora_base::error::Result;

use super::equations::{Means, double, rounding};
use super::{Choices, Optimal, bounds_of, reached};
use crate::equations::arena::{Arena, Extremes, Rewards};
use crate::equations::graph::NONE;
use crate::equations::meter::Meter;
use crate::sought::{MOST_STATES, too_many_states};
use crate::vector::{self, Accumulation, Until};

/// The equations of one step.
struct Backward<'a> {
    means: Means<'a>,
    maximisers: BitVec,
}

impl<'a> Backward<'a> {
    fn new(arena: &'a Arena<'a>, goal: Extremes, rewards: Option<&Rewards>) -> Self {
        Backward { means: Means::new(arena, rewards), maximisers: arena.maximisers(goal) }
    }

    fn mean(&self, choice: usize, x: &[f64]) -> f64 {
        self.means.of(choice, |to| x[to])
    }

    fn rounding(&self, choice: usize) -> f64 {
        rounding(self.means.arena.choices.successors(choice).len())
    }

    /// Returns the best choice of a state and its value; `known` if it is one of the best.
    fn best(&self, state: usize, x: &[f64], known: u32) -> (u32, f64) {
        let is_max = self.maximisers[state];
        let mut best: Option<(u32, f64)> = None;
        let choices = self.means.arena.choices.of(state as u32);
        for choice in choices.clone() {
            let mean = self.mean(choice, x);
            let is_better = |(_, old): (u32, f64)| {
                let least = self.rounding(choice) * old.abs();
                if is_max { mean > old + least } else { mean < old - least }
            };
            if best.is_none_or(is_better) {
                best = Some((choice as u32, mean));
            }
        }
        let (choice, value) = best.unwrap_or((NONE, 0.0));
        let is_known = choices.contains(&(known as usize))
            && (self.mean(known as usize, x) - value).abs() <= self.rounding(known as usize) * value.abs();
        (if is_known { known } else { choice }, value)
    }

    /// Takes steps backward from the values `x`. `fixed` returns the value of a state that does not depend on choices
    /// when some steps are left; `steady` says that it is the same for all steps. Returns the choices, those of the
    /// first step first.
    fn steps(
        &self,
        mut x: Vec<f64>,
        count: u64,
        (fixed, steady): (impl Fn(usize, u64) -> Option<f64>, bool),
        meter: &mut Meter<'_>,
    ) -> Result<Vec<Arc<Choices>>> {
        // The strategy has at least one node for each step.
        let all = usize::try_from(count).ok().filter(|&all| all <= MOST_STATES);
        let all = all.ok_or_else(too_many_states)?;
        let mut stages: Vec<Arc<Choices>> = Vec::new();
        for left in 1..=count {
            let before = stages.last().cloned();
            let (mut choices, mut next) = (Vec::with_capacity(x.len()), Vec::with_capacity(x.len()));
            for state in 0..x.len() {
                meter.step()?;
                let known = before.as_ref().map_or(NONE, |before| before[state]);
                let (choice, value) = self.best(state, &x, known);
                choices.push(if self.means.arena.is_theirs(state as u32) { NONE } else { choice });
                next.push(fixed(state, left).unwrap_or(value));
            }
            let is_settled = steady && next == x;
            x = next;
            stages.push(match before {
                Some(before) if *before == choices => before,
                _ => {
                    meter.take(choices.len() * 4)?;
                    Arc::new(choices)
                }
            });
            if let Some(last) = stages.last().cloned().filter(|_| is_settled) {
                stages.resize(all, last);
                break;
            }
        }
        stages.reverse();
        Ok(stages)
    }
}

/// Returns the strategy of an until formula with bounds.
pub(super) fn until(arena: &Arena<'_>, until: &Until, goal: Extremes, precision: f64) -> Result<Optimal> {
    let Until { left, right, least, most } = until;
    let values = vector::probabilities(arena, until, goal, precision)?.bounds(1.0)?;
    let backward = Backward::new(arena, goal, None);
    let (x, rest, count) = match most {
        Some(most) => (right.iter().map(|inside| f64::from(u8::from(*inside))).collect(), None, *most),
        None => {
            let unbounded = Until { least: 0, ..until.clone() };
            let found = reached(arena, &unbounded, goal, precision)?;
            (found.values.iter().map(|x| f64::midpoint(x.lower, x.upper)).collect(), found.rest, *least)
        }
    };
    let fixed = |state: usize, remaining: u64| {
        let may_stop = count - remaining >= *least;
        match (may_stop && right[state], left[state]) {
            (true, _) => Some(1.0),
            (false, true) => None,
            (false, false) => Some(0.0),
        }
    };
    let stages = backward.steps(x, count, (fixed, *least == 0), &mut arena.meter())?;
    let is_over = |state: usize| right[state] || !left[state];
    let ends = (0..arena.states()).map(is_over).collect();
    Ok(Optimal { values, stages, rest, rounds: None, ends: (ends, *least) })
}

/// Returns the strategy of the rewards of some steps, or of the state after them.
pub(super) fn rewards(
    arena: &Arena<'_>,
    rewards: &Rewards,
    (count, is_sum): (u64, bool),
    goal: Extremes,
) -> Result<Optimal> {
    let accumulation = if is_sum { Accumulation::Within(count) } else { Accumulation::At(count) };
    let values = bounds_of(arena, rewards, &accumulation, goal, f64::INFINITY)?;
    let backward = Backward::new(arena, goal, is_sum.then_some(rewards));
    let last = |state: usize| if is_sum { 0.0 } else { double(rewards.state(state)) };
    let x = (0..arena.states()).map(last).collect();
    let stages = backward.steps(x, count, (|_, _| None, true), &mut arena.meter())?;
    let ends = (BitVec::repeat(false, arena.states()), 0);
    Ok(Optimal { values, stages, rest: None, rounds: None, ends })
}
