//! Steps backward: the values before a step from those after it, in all states of a game.

use std::sync::Arc;

use bitvec::vec::BitVec;

use crate::graphs::game_graph::{Extremes, GameGraph, Rewards};
use crate::graphs::graph::NONE;
use crate::graphs::meter::Meter;
use meliora_base::error::Result;
use meliora_base::number::Number;

/// The choice of each state before a step; [`NONE`] of the opponent's.
pub type Stage = Arc<Vec<u32>>;

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
        let terms = self.game.outcomes(choice);
        let first = terms.clone().next().map(|(to, _)| &x[to as usize]);
        let sum = match first {
            // A mean of equal values is this value, without any rounding.
            Some(first) if terms.clone().all(|(to, _)| x[to as usize] == *first) => first.clone(),
            _ => terms.fold(N::zero(), |sum, (to, weight)| {
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
        for step in 0..steps {
            meter.progress_at(step as usize, &|| format!("step {} of {steps}", step + 1));
            let next = match &mut stages {
                None => self.step(&x, &fixed, meter)?,
                Some(stages) => self.stage(&x, &fixed, stages, meter)?,
            };
            let unchanged = next == x;
            x = next;
            if unchanged {
                let last = stages.as_ref().and_then(|stages| stages.last().cloned());
                stages.into_iter().zip(last).for_each(|(stages, last)| stages.resize(all, last));
                break;
            }
        }
        Ok(x)
    }

    /// Returns the values before a step.
    fn step(&self, x: &[N], fixed: impl Fn(usize) -> Option<N>, meter: &mut Meter<'_>) -> Result<Vec<N>> {
        let mut next = Vec::with_capacity(x.len());
        for state in 0..x.len() {
            meter.step()?;
            next.push(fixed(state).unwrap_or_else(|| self.best(state, x, |_, _| {})));
        }
        Ok(next)
    }

    /// Does the same, and adds the choices, which are those of the stage before where these are as good.
    fn stage(
        &self,
        x: &[N],
        fixed: impl Fn(usize) -> Option<N>,
        stages: &mut Vec<Stage>,
        meter: &mut Meter<'_>,
    ) -> Result<Vec<N>> {
        let before = stages.last().cloned();
        let (mut choices, mut next) = (Vec::with_capacity(x.len()), Vec::with_capacity(x.len()));
        for state in 0..x.len() {
            meter.step()?;
            let known = before.as_ref().map_or(NONE, |before| before[state]);
            let (choice, value) = self.pick(state, x, known);
            choices.push(if self.game.is_theirs(state as u32) { NONE } else { choice });
            next.push(fixed(state).unwrap_or(value));
        }
        stages.push(match before {
            Some(before) if *before == choices => before,
            _ => {
                meter.take(choices.len() * 4)?;
                Arc::new(choices)
            }
        });
        Ok(next)
    }
}
