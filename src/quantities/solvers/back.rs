//! Steps backward: the values before a step from those after it, in all states of a game.

use bitvec::vec::BitVec;

use crate::equations::game_graph::{Extremes, GameGraph, Rewards};
use crate::equations::graph::NONE;
use crate::equations::meter::Meter;
use meliora_base::error::Result;
use meliora_base::number::Number;

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
    pub(crate) fn pick(&self, state: usize, x: &[N], known: u32) -> (u32, N) {
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

    /// Takes some steps backward from the values `x`; `each` gets a state and its optimum before a step.
    ///
    /// # Errors
    /// The work is cancelled.
    pub(crate) fn steps(
        &self,
        mut x: Vec<N>,
        steps: u64,
        meter: &mut Meter<'_>,
        each: impl Fn(usize, &dyn Fn() -> N) -> N,
    ) -> Result<Vec<N>> {
        for step in 0..steps {
            meter.progress_at(step as usize, &|| format!("step {} of {steps}", step + 1));
            let mut next = Vec::with_capacity(x.len());
            for state in 0..x.len() {
                meter.step()?;
                next.push(each(state, &|| self.best(state, &x, |_, _| {})));
            }
            let unchanged = next.iter().zip(&x).all(|(next, x)| next == x);
            x = next;
            if unchanged {
                break;
            }
        }
        Ok(x)
    }
}
