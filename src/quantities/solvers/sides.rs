//! The states from which a set is reached possibly, and almost surely, where each state looks for the greatest or the
//! least probability.

use bitvec::vec::BitVec;

use crate::equations::choices::{Choices, Reversed};
use crate::equations::meter::Meter;
use meliora_base::error::Result;

/// The choices that may be taken, and those of them that hit in themselves, if some do.
type By<'b> = (&'b BitVec, Option<&'b BitVec>);

/// A game on some choices.
pub(crate) struct Sides<'a> {
    pub(crate) choices: &'a Choices,
    /// The states in which the greatest probability is looked for; in all others it is the least one.
    pub(crate) maximisers: &'a BitVec,
    /// The choices that may be taken; at least one in each state.
    pub(crate) allowed: &'a BitVec,
    pub(crate) reversed: Reversed,
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
        self.attracted(target, left, (self.allowed, None))
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
            let x = self.attracted_within(target, left, &y, (self.allowed, None));
            if x == y {
                return Ok(y);
            }
            y = x;
        }
    }

    /// Returns the states where maximisers take one of the choices `gains` with positive probability, through `left`. Cost:
    /// linear.
    pub(crate) fn earning(&self, gains: &BitVec, left: &BitVec) -> BitVec {
        self.attracted(&BitVec::repeat(false, left.len()), left, (self.allowed, Some(gains)))
    }

    /// Returns the states where maximisers take choices of `gains` infinitely often with positive probability, without
    /// leaving `left`: those from which they reach a state where they do it almost surely, again and again among the
    /// states that are left. Cost: linear for each round.
    ///
    /// # Errors
    /// The work is cancelled.
    pub(crate) fn recurring(&self, gains: &BitVec, left: &BitVec, meter: &mut Meter<'_>) -> Result<BitVec> {
        let none = BitVec::repeat(false, left.len());
        let (mut found, mut rest, mut allowed) = (none.clone(), left.clone(), self.allowed.clone());
        loop {
            // νY. μX. choices that stay in Y and are in `gains` or have a successor in X.
            let mut y = rest.clone();
            loop {
                meter.step()?;
                let x = self.attracted_within(&none, &rest, &y, (&allowed, Some(gains)));
                if x == y {
                    break;
                }
                y = x;
            }
            if y.not_any() {
                return Ok(found);
            }
            let more = self.attracted(&y, &rest, (&allowed, None));
            found |= &more;
            rest &= &!more;
            // Minimisers take no choice that may enter the found states; maximisers have none.
            for choice in 0..allowed.len() {
                let stays = !self.choices.successors(choice).iter().any(|&to| found[to as usize]);
                let is_allowed = allowed[choice] && stays;
                allowed.set(choice, is_allowed);
            }
        }
    }

    /// Returns the attractor of T by steps that cannot leave Y; see [`Sides::attracted`].
    fn attracted_within(&self, target: &BitVec, left: &BitVec, y: &BitVec, (by, hits): By<'_>) -> BitVec {
        let mut staying = by.clone();
        for choice in by.iter_ones() {
            staying.set(choice, self.choices.successors(choice).iter().all(|&to| y[to as usize]));
        }
        // A minimiser with a choice that leaves Y is not attracted.
        let all_stay =
            |state: usize| self.choices.of(state as u32).all(|choice| !by[choice] || staying[choice]);
        let stays = |state: usize| self.maximisers[state] || all_stay(state);
        let through: BitVec = (0..y.len()).map(|state| left[state] && stays(state)).collect();
        self.attracted(target, &through, (&staying, hits))
    }

    /// Returns the attractor of T through `left` by some choices, of which some hit in themselves.
    fn attracted(&self, target: &BitVec, left: &BitVec, (by, hits): By<'_>) -> BitVec {
        let (mut found, mut enters) = (target.clone(), BitVec::<usize>::repeat(false, by.len()));
        let count = |state: u32| self.choices.of(state).filter(|&choice| by[choice]).count() as u32;
        let mut open: Vec<u32> = (0..left.len() as u32)
            .map(|state| if self.maximisers[state as usize] { 1 } else { count(state) })
            .collect();
        let mut layer: Vec<u32> = target.iter_ones().map(|state| state as u32).collect();
        let mut enter = |choice: usize, found: &mut BitVec| {
            let state = self.reversed.owner[choice] as usize;
            if found[state] || !left[state] || !by[choice] || enters[choice] {
                return None;
            }
            enters.set(choice, true);
            open[state] -= 1;
            if open[state] > 0 {
                return None;
            }
            found.set(state, true);
            Some(state as u32)
        };
        for choice in hits.iter().flat_map(|hits| hits.iter_ones()) {
            layer.extend(enter(choice, &mut found));
        }
        while let Some(to) = layer.pop() {
            for &choice in self.reversed.entering(to) {
                layer.extend(enter(choice as usize, &mut found));
            }
        }
        found
    }
}
