//! The choices of a state that keep its value, and those that make progress.

use bitvec::vec::BitVec;
use meliora_base::error::Result;
use num_traits::ToPrimitive;

use super::Choices;
use meliora_base::interval::Interval;
use meliora_equations::{Arena, Extremes, Meter, NONE, Rewards};

/// The choices of an arena as sums of doubles.
pub(super) struct Means<'a> {
    pub(super) arena: &'a Arena<'a>,
    probabilities: Vec<f64>,
    /// The reward of each choice.
    gains: Option<Vec<f64>>,
}

impl<'a> Means<'a> {
    pub(super) fn new(arena: &'a Arena<'a>, rewards: Option<&Rewards>) -> Self {
        let gain =
            |own: &Rewards| (0..arena.choices_in_all()).map(|choice| double(own.choice(choice))).collect();
        let probabilities = arena.fractions().iter().map(double).collect();
        Means { arena, probabilities, gains: rewards.map(gain) }
    }

    /// Returns what a choice earns, and the mean of `x` after it.
    pub(super) fn of(&self, choice: usize, x: impl Fn(usize) -> f64) -> f64 {
        let terms = self.arena.outcomes(choice);
        let mean: f64 = terms.map(|(to, p)| self.probabilities[p as usize] * x(to as usize)).sum();
        mean + self.gain(choice)
    }

    /// Does the same; the mean of equal values is this value, without any rounding.
    fn of_bounds(&self, choice: usize, x: impl Fn(usize) -> f64) -> f64 {
        let all = self.arena.choices.successors(choice);
        let first = all.first().map_or(0.0, |&to| x(to as usize));
        match all.iter().all(|&to| x(to as usize) == first) {
            true => first + self.gain(choice),
            false => self.of(choice, x),
        }
    }

    fn gain(&self, choice: usize) -> f64 {
        self.gains.as_ref().map_or(0.0, |gains| gains[choice])
    }
}

/// The values of an arena, and what choices do to them.
pub(super) struct Equations<'a> {
    pub(super) arena: &'a Arena<'a>,
    means: Means<'a>,
    maximisers: BitVec,
    values: &'a [Interval],
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
        let means = Means::new(arena, rewards);
        Equations { arena, means, maximisers: arena.maximisers(goal), values }
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
            let is_lower = is_max != self.arena.is_theirs(state as u32);
            let bound = |to: usize| if is_lower { self.values[to].lower } else { self.values[to].upper };
            means.clear();
            means.extend(choices.clone().map(|choice| self.means.of_bounds(choice, bound)));
            let is_sure = own.lower == own.upper && [0.0, 1.0, f64::INFINITY].contains(&own.lower);
            let best = means.iter().copied().reduce(if is_max { f64::max } else { f64::min });
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
        let gains: Option<BitVec> =
            earns.then(|| (0..kept.len()).map(|choice| self.means.gain(choice) > 0.0).collect());
        let mut choices = self.arena.toward(&kept, over, gains.as_ref(), meter)?;
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
        let owner = self.arena.choices.owners();
        let stays = |choice: usize| {
            let all = self.arena.choices.successors(choice);
            !target[owner[choice] as usize] && all.iter().all(|&to| !target[to as usize])
        };
        let inside = (0..owner.len()).map(stays).collect();
        let found = self.arena.choices.end_components_among(inside, &mut meter)?;
        let (kept, nowhere): (BitVec, _) =
            (found.inside.iter().collect(), BitVec::repeat(false, self.arena.states()));
        let gains = (0..kept.len()).map(|choice| kept[choice] && !rewards.is_free(choice)).collect();
        let mut choices = self.arena.toward(&kept, &nowhere, Some(&gains), &mut meter)?;
        let earning: BitVec = choices.iter().map(|&choice| choice != NONE).collect();
        let all = BitVec::repeat(true, owner.len());
        let outside = self.arena.toward(&all, &earning, None, &mut meter)?;
        for (own, outside) in choices.iter_mut().zip(outside).filter(|(own, _)| **own == NONE) {
            *own = outside;
        }
        Ok(choices)
    }
}
