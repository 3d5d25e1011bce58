//! The states from which a set is reached possibly, and almost surely, where each state looks for the greatest or the
//! least probability.

use bitvec::vec::BitVec;

use crate::equations::choices::{Choices, Reversed};
use crate::equations::graph::NONE;
use crate::equations::meter::Meter;
use meliora_base::error::Result;

/// A game on some choices.
pub(crate) struct Sides<'a> {
    pub(crate) choices: &'a Choices,
    /// The states in which the greatest probability is looked for; in all others it is the least one.
    pub(crate) maximisers: &'a BitVec,
    /// The choices that may be taken; at least one in each state.
    pub(crate) allowed: &'a BitVec,
    reversed: Reversed,
}

impl<'a> Sides<'a> {
    /// Prepares searches. Cost: linear.
    ///
    /// # Errors
    /// The memory limit is reached.
    pub(crate) fn new(
        choices: &'a Choices,
        maximisers: &'a BitVec,
        allowed: &'a BitVec,
        meter: &mut Meter<'_>,
    ) -> Result<Self> {
        meter.take(choices.bytes())?;
        Ok(Sides { choices, maximisers, allowed, reversed: choices.reversed() })
    }

    /// Returns μX. T ∪ { s in `left`: a maximiser has a choice, a minimiser has only choices with a successor in X }:
    /// the states where the probability to reach T through `left` is positive. Cost: linear.
    pub(crate) fn positive(&self, target: &BitVec, left: &BitVec) -> BitVec {
        self.attracted(target, left, self.allowed).0
    }

    /// Returns νY. μX. T ∪ { s in `left`: a maximiser has a choice, a minimiser has only choices that stay in Y and
    /// have a successor in X }: the states where that probability is 1. Cost: linear for each round.
    ///
    /// # Errors
    /// The work is cancelled.
    pub(crate) fn almost_sure(
        &self,
        target: &BitVec,
        left: &BitVec,
        meter: &mut Meter<'_>,
    ) -> Result<BitVec> {
        let mut y = self.positive(target, left);
        loop {
            meter.step()?;
            let x = self.attracted_within(target, left, &y).0;
            if x == y {
                return Ok(y);
            }
            y = x;
        }
    }

    /// Returns a choice of each maximiser in [`Sides::positive`] that comes closer to the target, and all choices of the
    /// other states.
    pub(crate) fn strategy(&self, target: &BitVec, left: &BitVec) -> BitVec {
        self.only(&self.attracted(target, left, self.allowed).1)
    }

    /// Does the same for the result of [`Sides::almost_sure`], by choices that stay there.
    pub(crate) fn sure_strategy(&self, target: &BitVec, within: &BitVec) -> BitVec {
        self.only(&self.attracted_within(target, within, within).1)
    }

    /// Returns the choices that may be taken if maximisers take some of them, as far as they are given.
    fn only(&self, taken: &[u32]) -> BitVec {
        let mut only = self.allowed.clone();
        for state in self.maximisers.iter_ones().filter(|&state| taken[state] != NONE) {
            self.choices.of(state as u32).for_each(|choice| only.set(choice, choice as u32 == taken[state]));
        }
        only
    }

    /// Returns the attractor of T by steps that cannot leave Y.
    fn attracted_within(&self, target: &BitVec, left: &BitVec, y: &BitVec) -> (BitVec, Vec<u32>) {
        let mut staying = self.allowed.clone();
        for choice in self.allowed.iter_ones() {
            staying.set(choice, self.choices.successors(choice).iter().all(|&to| y[to as usize]));
        }
        // A minimiser with a choice that leaves Y is not attracted.
        let stays = |state: usize| self.maximisers[state] || self.all_allowed(state, &staying);
        let through: BitVec = (0..y.len()).map(|state| left[state] && stays(state)).collect();
        self.attracted(target, &through, &staying)
    }

    fn all_allowed(&self, state: usize, among: &BitVec) -> bool {
        self.choices.of(state as u32).all(|choice| !self.allowed[choice] || among[choice])
    }

    /// Returns the attractor of T through `left` by some choices, and the last choice that attracted each state.
    fn attracted(&self, target: &BitVec, left: &BitVec, by: &BitVec) -> (BitVec, Vec<u32>) {
        let mut taken = vec![NONE; left.len()];
        let (mut found, mut enters) = (target.clone(), BitVec::<usize>::repeat(false, by.len()));
        let count = |state: u32| self.choices.of(state).filter(|&choice| by[choice]).count() as u32;
        let mut open: Vec<u32> = (0..left.len() as u32)
            .map(|state| if self.maximisers[state as usize] { 1 } else { count(state) })
            .collect();
        let mut layer: Vec<u32> = target.iter_ones().map(|state| state as u32).collect();
        while let Some(to) = layer.pop() {
            for &choice in self.reversed.entering(to) {
                let state = self.reversed.owner[choice as usize] as usize;
                if found[state] || !left[state] || !by[choice as usize] || enters[choice as usize] {
                    continue;
                }
                enters.set(choice as usize, true);
                open[state] -= 1;
                if open[state] == 0 {
                    found.set(state, true);
                    taken[state] = choice;
                    layer.push(state as u32);
                }
            }
        }
        (found, taken)
    }
}
