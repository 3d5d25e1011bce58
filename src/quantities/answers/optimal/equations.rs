//! The choices of a state that keep its value, and those that make progress.

use bitvec::vec::BitVec;
use meliora_base::error::Result;
use num_traits::ToPrimitive;

use super::Choices;
use crate::equations::arena::{Arena, Extremes, Rewards};
use crate::equations::graph::NONE;
use crate::equations::meter::Meter;
use crate::equations::number::Interval;
use crate::solvers::components::end_components_of;

/// The values of an arena, and what choices do to them.
pub(super) struct Equations<'a> {
    pub(super) arena: &'a Arena<'a>,
    maximisers: BitVec,
    values: &'a [Interval],
    probabilities: Vec<f64>,
    /// The reward of each choice.
    gains: Option<Vec<f64>>,
}

/// Returns the largest part of a mean of some numbers that rounding may change, with what the choice earns.
pub(super) fn rounding(terms: usize) -> f64 {
    (terms as f64 + 2.0) * f64::EPSILON
}

/// Returns a fraction as a double.
pub(super) fn double(x: &meliora_base::exact::Ratio) -> f64 {
    x.to_f64().unwrap_or(f64::INFINITY)
}

impl<'a> Equations<'a> {
    pub(super) fn new(
        arena: &'a Arena<'a>,
        goal: Extremes,
        values: &'a [Interval],
        rewards: Option<&Rewards>,
    ) -> Self {
        let gain =
            |own: &Rewards| (0..arena.choices_in_all()).map(|choice| double(own.choice(choice))).collect();
        let probabilities = arena.fractions().iter().map(double).collect();
        Equations {
            arena,
            maximisers: arena.maximisers(goal),
            values,
            probabilities,
            gains: rewards.map(gain),
        }
    }

    /// Returns what a choice earns, and the mean of a bound after it.
    fn mean(&self, choice: usize, bound: fn(&Interval) -> f64) -> f64 {
        let mut all = self.arena.outcomes(choice).map(|(to, p)| (bound(&self.values[to as usize]), p));
        let first = all.clone().next().map_or(0.0, |(x, _)| x);
        // A mean of equal values is this value, without any rounding.
        let mean = match all.clone().all(|(x, _)| x == first) {
            true => first,
            false => all.by_ref().map(|(x, p)| self.probabilities[p as usize] * x).sum(),
        };
        mean + self.gains.as_ref().map_or(0.0, |gains| gains[choice])
    }

    /// Returns the choices of each state that keep what its side guarantees; of the opponent those that may be its best.
    fn kept(&self, meter: &mut Meter<'_>) -> Result<BitVec> {
        let (mut kept, mut means) = (BitVec::repeat(false, self.arena.choices_in_all()), Vec::new());
        for state in 0..self.arena.states() {
            meter.step()?;
            let (is_max, own) = (self.maximisers[state], self.values[state]);
            let choices = self.arena.choices.of(state as u32);
            if choices.len() == 1 {
                kept.set(choices.start, true);
                continue;
            }
            let bound: fn(&Interval) -> f64 = match is_max != self.arena.is_theirs(state as u32) {
                true => |value| value.lower,
                false => |value| value.upper,
            };
            means.clear();
            means.extend(choices.clone().map(|choice| self.mean(choice, bound)));
            let is_sure = own.lower == own.upper && [0.0, 1.0, f64::INFINITY].contains(&own.lower);
            let best = means.iter().copied().fold(None, |best: Option<f64>, x| match best {
                Some(best) if is_max => Some(best.max(x)),
                Some(best) => Some(best.min(x)),
                None => Some(x),
            });
            let best = best.unwrap_or_default();
            let least = if is_max { own.lower.min(best) } else { own.upper.max(best) };
            for (choice, &mean) in choices.zip(&means) {
                let terms = self.arena.choices.successors(choice).len();
                let rounding = if is_sure { 0.0 } else { rounding(terms) };
                let keeps = match is_max {
                    true => mean >= least * (1.0 - rounding),
                    false => mean <= least * (1.0 + rounding),
                };
                kept.set(choice, keeps || mean == least);
            }
        }
        Ok(kept)
    }

    /// Returns the choices that keep the value, and lead to `over` where some do. If a step that `earns` counts as progress,
    /// one of these will do. Cost: linear.
    ///
    /// # Errors
    /// The work is cancelled.
    pub(super) fn progressing(&self, over: &BitVec, earns: bool, meter: &mut Meter<'_>) -> Result<Choices> {
        let kept = self.kept(meter)?;
        let is_gain = |choice: usize| earns && self.gains.as_ref().is_some_and(|gains| gains[choice] > 0.0);
        let mut choices = toward(self.arena, &kept, over, &is_gain);
        let open = (0..).zip(&mut choices).filter(|(_, choice)| **choice == NONE);
        for (state, choice) in open.filter(|(state, _)| !self.arena.is_theirs(*state)) {
            let first = self.arena.choices.of(state).find(|&choice| kept[choice]);
            *choice = first.map_or(NONE, |choice| choice as u32);
        }
        Ok(choices)
    }

    /// Returns choices that earn again and again with positive probability, in models of one player.
    pub(super) fn earning_again(&self, rewards: &Rewards, target: &BitVec) -> Result<Choices> {
        let mut meter = self.arena.meter();
        let owner = self.arena.choices.reversed().owner;
        let stays = |choice: usize| {
            let all = self.arena.choices.successors(choice);
            !target[owner[choice] as usize] && all.iter().all(|&to| !target[to as usize])
        };
        let inside = (0..owner.len()).map(stays).collect();
        let found = end_components_of(&self.arena.choices, inside, &mut meter)?;
        let is_gain = |choice: usize| found.inside[choice] && !rewards.is_free(choice);
        let (kept, nowhere) = (found.inside.iter().collect(), BitVec::repeat(false, self.arena.states()));
        let mut choices = toward(self.arena, &kept, &nowhere, &is_gain);
        let earning: BitVec = choices.iter().map(|&choice| choice != NONE).collect();
        let all = BitVec::repeat(true, owner.len());
        let outside = toward(self.arena, &all, &earning, &|_| false);
        for (own, outside) in choices.iter_mut().zip(outside).filter(|(own, _)| **own == NONE) {
            *own = outside;
        }
        Ok(choices)
    }
}

/// Returns for each of our states outside of `target` a permitted choice that may lead nearer to it, or that satisfies
/// `leads`, in the fewest steps; [`NONE`] where there is none, and where the opponent can prevent it. Cost: linear.
pub(super) fn toward(
    arena: &Arena<'_>,
    permitted: &BitVec,
    target: &BitVec,
    leads: &dyn Fn(usize) -> bool,
) -> Choices {
    let (reversed, states) = (arena.choices.reversed(), arena.states());
    let (mut choices, mut done) = (vec![NONE; states], target.clone());
    let mut hit = BitVec::<usize>::repeat(false, arena.choices_in_all());
    let missing = |state: usize| arena.choices.of(state as u32).filter(|&choice| permitted[choice]).count();
    let mut missing: Vec<u32> = (0..states)
        .map(|state| if arena.is_theirs(state as u32) { missing(state) as u32 } else { 1 })
        .collect();
    let mut open: std::collections::VecDeque<u32> = target.iter_ones().map(|state| state as u32).collect();
    let mut enter = |choice: usize, choices: &mut Choices, open: &mut std::collections::VecDeque<u32>| {
        let state = reversed.owner[choice] as usize;
        if !permitted[choice] || done[state] || hit.replace(choice, true) {
            return;
        }
        missing[state] -= 1;
        if missing[state] == 0 {
            if !arena.is_theirs(state as u32) {
                choices[state] = choice as u32;
            }
            done.set(state, true);
            open.push_back(state as u32);
        }
    };
    (0..permitted.len())
        .filter(|&choice| leads(choice))
        .for_each(|choice| enter(choice, &mut choices, &mut open));
    while let Some(state) = open.pop_front() {
        for &choice in reversed.entering(state) {
            enter(choice as usize, &mut choices, &mut open);
        }
    }
    choices
}
