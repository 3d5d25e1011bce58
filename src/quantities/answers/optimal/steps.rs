//! Choices by the number of steps, for bounds: steps backward from the end, which give the values, too.

use std::sync::Arc;

use bitvec::vec::BitVec;
use meliora_base::error::Result;

use super::{Choices, Optimal, choices_to_reach};
use crate::equations::arena::{Arena, Extremes, Rewards};
use crate::equations::graph::NONE;
use crate::equations::meter::Meter;
use crate::solvers::back::Back;
use crate::solvers::reaching::Vector;
use crate::sought::{MOST_STATES, too_many_states};
use crate::vector::{self, Until, computed_with};
use meliora_base::interval::Interval;
use meliora_base::number::Number;

/// The choices of some steps, those of the first step first.
type Stages = Vec<Arc<Choices>>;

/// Takes steps backward from the values `x`. `fixed` returns the value of a state that does not depend on choices when some
/// steps are left; `steady` says that it is the same for all steps. Adds the choices, and returns the values before all steps.
fn staged<N: Number>(
    (arena, back): (&Arena<'_>, &Back<'_, N>),
    (mut x, count): (Vec<N>, u64),
    (fixed, steady): (impl Fn(usize, u64) -> Option<N>, bool),
    stages: &mut Stages,
    meter: &mut Meter<'_>,
) -> Result<Vec<N>> {
    // The strategy has at least one node for each step.
    let all = usize::try_from(count).ok().filter(|&all| all <= MOST_STATES).ok_or_else(too_many_states)?;
    for left in 1..=count {
        meter.progress_at(left as usize, &|| format!("step {left} of {count}"));
        let before = stages.last().cloned();
        let (mut choices, mut next) = (Vec::with_capacity(x.len()), Vec::with_capacity(x.len()));
        for state in 0..x.len() {
            meter.step()?;
            let known = before.as_ref().map_or(NONE, |before| before[state]);
            let (choice, value) = back.pick(state, &x, known);
            choices.push(if arena.is_theirs(state as u32) { NONE } else { choice });
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
    Ok(x)
}

/// The choices of the steps that a bound counts, and those after them; `None` if the path is decided then.
type Bounded = (Stages, Option<Choices>);

/// Returns the strategy of an until formula with bounds.
pub(super) fn until(arena: &Arena<'_>, until: &Until, goal: Extremes, precision: f64) -> Result<Optimal> {
    let (found, (stages, rest)) = computed_with!(precision, 1.0, N => until_of::<N>(arena, until, goal))?;
    let values = found.bounds()?;
    let is_over = |state: usize| until.right[state] || !until.left[state];
    let ends = (0..arena.states()).map(is_over).collect();
    Ok(Optimal { values, stages, rest, rounds: None, ends: (ends, until.least) })
}

/// Returns the strategy of the rewards of some steps, or of the state after them.
pub(super) fn rewards(
    arena: &Arena<'_>,
    rewards: &Rewards,
    steps: (u64, bool),
    goal: Extremes,
    precision: f64,
) -> Result<Optimal> {
    let (found, stages) =
        computed_with!(precision, f64::INFINITY, N => rewards_of::<N>(arena, rewards, steps, goal))?;
    let values = found.bounds()?;
    let ends = (BitVec::repeat(false, arena.states()), 0);
    Ok(Optimal { values, stages, rest: None, rounds: None, ends })
}

/// Returns the values of an until formula, and the choices that attain them.
fn until_of<N: Number>(arena: &Arena<'_>, until: &Until, goal: Extremes) -> Result<(Vector<N>, Bounded)> {
    let (mut stages, mut rest) = Bounded::default();
    let (Until { left, right, least, most }, mut meter) = (until, arena.meter());
    let (x, count) = match most {
        Some(most) if most < least => (vec![N::zero(); arena.states()], *most),
        Some(most) => (vector::indicator(right), *most),
        None => {
            let unbounded = Until { least: 0, ..until.clone() };
            let found = vector::until_of::<N>(arena, &unbounded, goal, &mut meter)?;
            found.end?;
            let x: Vec<N> = found.values.into_iter().map(|x| x.unwrap_or_else(N::zero)).collect();
            let bounds: Vec<Interval> = x.iter().map(Number::bounds).collect();
            rest = Some(choices_to_reach(arena, &unbounded, goal, &bounds)?);
            (x, *least)
        }
    };
    let fixed = |state: usize, remaining: u64| {
        let may_stop = count - remaining >= *least;
        match (may_stop && right[state], left[state]) {
            (true, _) => Some(N::one()),
            (false, true) => None,
            (false, false) => Some(N::zero()),
        }
    };
    let back = Back::new(arena, goal, None, &mut meter)?;
    let values = staged((arena, &back), (x, count), (fixed, *least == 0), &mut stages, &mut meter)?;
    Ok((Vector::of(values), (stages, rest)))
}

/// Returns the rewards of some steps, if they are a sum, or of the state after them, and the choices that attain them.
fn rewards_of<N: Number>(
    arena: &Arena<'_>,
    rewards: &Rewards,
    (count, is_sum): (u64, bool),
    goal: Extremes,
) -> Result<(Vector<N>, Stages)> {
    let mut stages = Stages::new();
    let mut meter = arena.meter();
    let last = |state: usize| if is_sum { N::zero() } else { N::of(rewards.state(state)) };
    let x = (0..arena.states()).map(last).collect();
    let back = Back::new(arena, goal, is_sum.then_some(rewards), &mut meter)?;
    let values = staged((arena, &back), (x, count), (|_, _| None, true), &mut stages, &mut meter)?;
    Ok((Vector::of(values), stages))
}
