//! Steps backward: the values before a step from those after it, in all states of a game.

use std::sync::Arc;

use bitvec::vec::BitVec;

use crate::graphs::choices::Reversed;
use crate::graphs::game_graph::{Extremes, GameGraph, Rewards};
use crate::graphs::graph::NONE;
use crate::graphs::meter::Meter;
use meliora_base::error::Result;
use meliora_base::number::Number;

/// The choice of each state before a step; [`NONE`] of the opponent's.
pub type Stage = Arc<Vec<u32>>;

/// If fewer than one in this many values change in a step, only the values that depend on them are computed for the next one.
const FEW: usize = 8;

/// The equations of one step as numbers.
pub(crate) struct Back<'a, N> {
    game: &'a GameGraph,
    maximisers: BitVec,
    probabilities: Vec<N>,
    /// The rewards, and their values as numbers.
    gains: Option<(&'a Rewards, Vec<N>)>,
}

impl<'a, N: Number> Back<'a, N> {
    /// Reads the probabilities of a game, and rewards that choices earn.
    ///
    /// # Errors
    /// The memory limit is reached.
    pub(crate) fn new(
        game: &'a GameGraph,
        goal: Extremes,
        rewards: Option<&'a Rewards>,
        meter: &mut Meter<'_>,
    ) -> Result<Self> {
        let fractions = game.fractions();
        meter.take(fractions.len() * N::BYTES + game.states() / 8)?;
        let gains = rewards.map(|own| (own, own.fractions.list().iter().map(N::of).collect()));
        let probabilities = fractions.iter().map(N::of).collect();
        Ok(Back { game, maximisers: game.maximisers(goal), probabilities, gains })
    }

    /// Returns what a choice earns, and the mean of `x` after it.
    fn mean(&self, choice: usize, x: &[N]) -> N {
        let sum = match self.game.choices.successors(choice) {
            // A mean of equal values is this value, without any rounding.
            [first, others @ ..] if others.iter().all(|&to| x[to as usize] == x[*first as usize]) => {
                x[*first as usize].clone()
            }
            _ => self.game.outcomes(choice).fold(N::zero(), |sum, (to, weight)| {
                sum.plus(&self.probabilities[weight as usize].times(&x[to as usize]))
            }),
        };
        match &self.gains {
            Some((own, gains)) => sum.plus(&gains[own.of_choice.get(choice) as usize]),
            None => sum,
        }
    }

    /// Returns the optimum of the choices of a state for the values `x` after them; `each` gets the value of each choice.
    fn best(&self, state: usize, x: &[N], mut each: impl FnMut(usize, &N)) -> N {
        let greatest = self.maximisers[state];
        let mut best: Option<N> = None;
        for choice in self.game.choices.of(state as u32) {
            let q = self.mean(choice, x);
            each(choice, &q);
            best = Some(match best {
                None => q,
                Some(best) => best.extreme(q, greatest),
            });
        }
        best.unwrap_or_else(N::zero)
    }

    /// Returns a choice that is best in a state for the values `x` after it, and the optimum: `known` unless another one is
    /// certainly better, else the first one. [`NONE`] without choices.
    fn pick(&self, state: usize, x: &[N], known: u32) -> (u32, N) {
        let greatest = self.maximisers[state];
        let is_better = |a: &N, b: &N| a.beats(b, greatest);
        let (mut picked, mut of_known): (Option<(u32, N)>, Option<N>) = (None, None);
        let value = self.best(state, x, |choice, q| {
            if choice as u32 == known {
                of_known = Some(q.clone());
            }
            if picked.as_ref().is_none_or(|(_, old)| is_better(q, old)) {
                picked = Some((choice as u32, q.clone()));
            }
        });
        let choice = match (picked, of_known) {
            (Some((_, best)), Some(own)) if !is_better(&best, &own) => known,
            (picked, _) => picked.map_or(NONE, |(choice, _)| choice),
        };
        (choice, value)
    }

    /// Takes some steps backward from the values `x`. `fixed` returns the value of a state that does not depend on choices.
    /// Adds the choices of our states to `stages`, those of the last step first.
    ///
    /// # Errors
    /// A limit is reached.
    pub(crate) fn steps(
        &self,
        (mut x, steps): (Vec<N>, u64),
        fixed: impl Fn(usize) -> Option<N>,
        mut stages: Option<&mut Vec<Stage>>,
        meter: &mut Meter<'_>,
    ) -> Result<Vec<N>> {
        let all = stages.as_ref().map_or(0, |stages| stages.len()) + steps as usize;
        let (mut changed, mut affected, mut reversed) = (Vec::new(), None, None);
        for step in 0..steps {
            meter.progress_at(step as usize, &|| format!("step {} of {steps}", step + 1));
            match &mut stages {
                None => self.step(&x, affected.as_ref(), &fixed, &mut changed, meter)?,
                Some(stages) => self.stage(&x, &fixed, stages, &mut changed, meter)?,
            }
            if changed.is_empty() {
                let last = stages.as_ref().and_then(|stages| stages.last().cloned());
                stages.into_iter().zip(last).for_each(|(stages, last)| stages.resize(all, last));
                break;
            }
            if stages.is_none() {
                affected = self.affected(&changed, &mut reversed, meter)?;
            }
            changed.drain(..).for_each(|(state, value)| x[state as usize] = value);
        }
        meter.release(reversed.map_or(0, |_| self.bytes_of_reversed()));
        Ok(x)
    }

    /// Returns the states whose values depend on some that change, if those are few.
    fn affected(
        &self,
        changed: &[(u32, N)],
        reversed: &mut Option<Reversed>,
        meter: &mut Meter<'_>,
    ) -> Result<Option<BitVec>> {
        let (states, bytes) = (self.game.states(), self.bytes_of_reversed());
        if changed.len() >= states / FEW {
            return Ok(None);
        }
        let reversed = match reversed {
            Some(known) => known,
            None if meter.left() < bytes as u64 => return Ok(None),
            None => {
                meter.take(bytes)?;
                reversed.insert(self.game.choices.reversed())
            }
        };
        let mut affected = BitVec::repeat(false, states);
        for &choice in changed.iter().flat_map(|(state, _)| reversed.entering(*state)) {
            affected.set(reversed.owner[choice as usize] as usize, true);
        }
        Ok(Some(affected))
    }

    /// Returns the bytes of the choices that enter each state, and of a set of states.
    fn bytes_of_reversed(&self) -> usize {
        self.game.choices.bytes() + self.game.states() / 8
    }

    /// Adds the values before a step that differ from those after it, in all states or in some.
    fn step(
        &self,
        x: &[N],
        among: Option<&BitVec>,
        fixed: impl Fn(usize) -> Option<N>,
        changed: &mut Vec<(u32, N)>,
        meter: &mut Meter<'_>,
    ) -> Result<()> {
        let mut visit = |state: usize| -> Result<()> {
            meter.step()?;
            let value = fixed(state).unwrap_or_else(|| self.best(state, x, |_, _| {}));
            if value != x[state] {
                changed.push((state as u32, value));
            }
            Ok(())
        };
        match among {
            Some(among) => among.iter_ones().try_for_each(&mut visit),
            None => (0..x.len()).try_for_each(&mut visit),
        }
    }

    /// Does the same in all states, and adds the choices, which are those of the stage before where these are as good.
    fn stage(
        &self,
        x: &[N],
        fixed: impl Fn(usize) -> Option<N>,
        stages: &mut Vec<Stage>,
        changed: &mut Vec<(u32, N)>,
        meter: &mut Meter<'_>,
    ) -> Result<()> {
        let before = stages.last().cloned();
        let mut choices = Vec::with_capacity(x.len());
        for state in 0..x.len() {
            meter.step()?;
            let known = before.as_ref().map_or(NONE, |before| before[state]);
            let (choice, value) = self.pick(state, x, known);
            choices.push(if self.game.is_theirs(state as u32) { NONE } else { choice });
            let value = fixed(state).unwrap_or(value);
            if value != x[state] {
                changed.push((state as u32, value));
            }
        }
        stages.push(match before {
            Some(before) if *before == choices => before,
            _ => {
                meter.take(choices.len() * 4)?;
                Arc::new(choices)
            }
        });
        Ok(())
    }
}
