//! The states from which a set is reached possibly, and almost surely, where each state looks for the greatest or the
//! least probability.

use bitvec::vec::BitVec;

use crate::graphs::choices::{Choices, Reversed};
use crate::graphs::game_graph::{Extremes, GameGraph, NONE};
use crate::graphs::meter::Meter;
use meliora_base::error::Result;
use meliora_model::Optimum;

/// The choices that may be taken, and those of them that hit in themselves, if some do.
type By<'b> = (&'b BitVec, Option<&'b BitVec>);

/// A game on some choices.
pub(crate) struct Sides<'a> {
    choices: &'a Choices,
    /// The states in which the greatest probability is looked for; in all others it is the least one.
    maximisers: &'a BitVec,
    /// The choices that may be taken; at least one in each state.
    allowed: &'a BitVec,
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

    /// Returns the same game with other choices that may be taken.
    pub(crate) fn with(self, allowed: &'a BitVec) -> Self {
        Sides { allowed, ..self }
    }

    /// Returns μX. T ∪ { s in `left`: a maximiser has a choice, a minimiser has only choices with a successor in X }:
    /// the states where the probability to reach T through `left` is positive. Cost: linear.
    pub(crate) fn positive(&self, target: &BitVec, left: &BitVec) -> BitVec {
        self.attracted(target, left, (self.allowed, None))
    }

    /// Returns νY. μX. T ∪ { s in `left`: a maximiser has a choice, a minimiser has only choices that stay in Y and
    /// have a successor in X }: the states where that probability is 1. Cost: linear for each round; states that cannot stay
    /// in Y leave it in one pass.
    ///
    /// # Errors
    /// The work is cancelled.
    pub(crate) fn almost_sure(
        &self,
        target: &BitVec,
        left: &BitVec,
        meter: &mut Meter<'_>,
    ) -> Result<BitVec> {
        self.almost_sure_within(self.positive(target, left), target, left, meter)
    }

    /// Does the same, given the states where the probability is positive.
    ///
    /// # Errors
    /// The work is cancelled.
    pub(crate) fn almost_sure_within(
        &self,
        positive: BitVec,
        target: &BitVec,
        left: &BitVec,
        meter: &mut Meter<'_>,
    ) -> Result<BitVec> {
        let mut y = positive;
        if y.all() || y == *target {
            return Ok(y);
        }
        let mut staying = Staying::new(self, self.allowed, &y);
        loop {
            meter.step()?;
            // The states of Y reach T by choices of theirs that stay, as long as these are the same.
            if !staying.close(&mut y, target) {
                return Ok(y);
            }
            let through = left.clone() & &y;
            let x = self.attracted(target, &through, (&staying.choices, None));
            if !staying.shrink(&mut y, x) {
                return Ok(y);
            }
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
            let mut staying = Staying::new(self, &allowed, &y);
            loop {
                meter.step()?;
                staying.close(&mut y, &none);
                let x = self.attracted(&none, &y, (&staying.choices, Some(gains)));
                if !staying.shrink(&mut y, x) {
                    break;
                }
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

    /// Returns the attractor of T through `left` by some choices, of which some hit in themselves.
    fn attracted(&self, target: &BitVec, left: &BitVec, by: By<'_>) -> BitVec {
        self.attracted_by(target, left, by, |_, _| {})
    }

    /// Does the same, breadth first; `each` gets each state that is attracted, and the choice that attracts it.
    fn attracted_by(
        &self,
        target: &BitVec,
        left: &BitVec,
        (by, hits): By<'_>,
        mut each: impl FnMut(usize, usize),
    ) -> BitVec {
        let mut found = target.clone();
        // Minimisers are attracted by the last of their choices.
        let (mut enters, mut open) = (BitVec::<usize>::new(), Vec::new());
        if !self.maximisers.all() {
            let count = |state: u32| self.choices.of(state).filter(|&choice| by[choice]).count() as u32;
            open.extend((0..left.len() as u32).map(count));
            enters.resize(by.len(), false);
        }
        let mut queue: Vec<u32> = target.iter_ones().map(|state| state as u32).collect();
        let mut enter = |choice: usize, found: &mut BitVec| {
            let state = self.reversed.owner[choice] as usize;
            if found[state] || !left[state] || !by[choice] {
                return None;
            }
            if !self.maximisers[state] {
                if enters.replace(choice, true) {
                    return None;
                }
                open[state] -= 1;
                if open[state] > 0 {
                    return None;
                }
            }
            found.set(state, true);
            each(state, choice);
            Some(state as u32)
        };
        for choice in hits.iter().flat_map(|hits| hits.iter_ones()) {
            queue.extend(enter(choice, &mut found));
        }
        let mut next = 0;
        while let Some(&to) = queue.get(next) {
            next += 1;
            for &choice in self.reversed.entering(to) {
                queue.extend(enter(choice as usize, &mut found));
            }
        }
        found
    }
}

impl GameGraph {
    /// Returns for each of our states outside of `target` a permitted choice that may lead nearer to it, or that is one of
    /// `leading`, in the fewest steps; [`NONE`] where there is none, and where the opponent can prevent it. Cost: linear.
    ///
    /// # Errors
    /// The memory limit is reached.
    pub fn toward(
        &self,
        permitted: &BitVec,
        target: &BitVec,
        leading: Option<&BitVec>,
        meter: &mut Meter<'_>,
    ) -> Result<Vec<u32>> {
        let everywhere = BitVec::repeat(true, self.states());
        let ours = self.maximisers(Extremes::against(Optimum::Max));
        let mut choices = vec![NONE; self.states()];
        let note = |state: usize, choice: usize| {
            if ours[state] {
                choices[state] = choice as u32;
            }
        };
        let before = meter.bytes();
        let sides = Sides::new(&self.choices, &ours, permitted, meter)?;
        sides.attracted_by(target, &everywhere, (permitted, leading), note);
        meter.release_to(before);
        Ok(choices)
    }

    /// Returns μX. T ∪ { s in `left`: a choice has a successor in X }: the states from which some of T are reached through
    /// `left`. Cost: linear.
    ///
    /// # Errors
    /// The memory limit is reached.
    pub fn reaching(&self, target: &BitVec, left: &BitVec, meter: &mut Meter<'_>) -> Result<BitVec> {
        let [states, choices] = [self.states(), self.choices_in_all()].map(|n| BitVec::repeat(true, n));
        Ok(Sides::new(&self.choices, &states, &choices, meter)?.positive(target, left))
    }
}

/// The choices that stay in a set Y of states, while it shrinks.
struct Staying<'s> {
    sides: &'s Sides<'s>,
    choices: BitVec,
    /// The number of these choices of each state.
    left: Vec<u32>,
    /// The states outside of Y that choices still enter.
    outside: Vec<u32>,
}

impl<'s> Staying<'s> {
    fn new(sides: &'s Sides<'s>, by: &BitVec, y: &BitVec) -> Self {
        let count = |state: u32| sides.choices.of(state).filter(|&choice| by[choice]).count() as u32;
        let left = (0..y.len() as u32).map(count).collect();
        let outside = y.iter_zeros().map(|state| state as u32).collect();
        Staying { sides, choices: by.clone(), left, outside }
    }

    /// Removes the choices that leave Y, and the states of Y outside of T that cannot stay in it: maximisers without a
    /// choice, and minimisers with a choice that leaves it. Returns whether states of Y have lost choices.
    fn close(&mut self, y: &mut BitVec, target: &BitVec) -> bool {
        let mut is_changed = false;
        while let Some(gone) = self.outside.pop() {
            for &choice in self.sides.reversed.entering(gone) {
                if !self.choices.replace(choice as usize, false) {
                    continue;
                }
                let state = self.sides.reversed.owner[choice as usize] as usize;
                self.left[state] -= 1;
                if !y[state] || target[state] {
                    continue;
                }
                is_changed = true;
                if self.left[state] == 0 || !self.sides.maximisers[state] {
                    y.set(state, false);
                    self.outside.push(state as u32);
                }
            }
        }
        is_changed
    }

    /// Lets Y be one of its parts; returns whether it was larger.
    fn shrink(&mut self, y: &mut BitVec, part: BitVec) -> bool {
        let lost = y.iter_ones().filter(|&state| !part[state]).map(|state| state as u32);
        self.outside.extend(lost);
        *y = part;
        !self.outside.is_empty()
    }
}
