//! The probability to reach a set, and the expected reward until then, in all states of a game.
//!
//! Regions come first: where a probability is 0 or 1, and where a reward is 0 or infinite. The states between them have
//! equations; see [`super::solve`].

use bitvec::vec::BitVec;

use super::sides::Sides;
use crate::graphs::game_graph::{Extremes, GameGraph, Rewards};
use crate::graphs::meter::Meter;
use crate::solvers::solution::Solution;
use crate::solvers::system::{Quantity, Sets, System};
use crate::values::value::{Answer, Value};
use meliora_base::error::Result;
use meliora_base::interval::{Bounds, Interval};
use meliora_base::number::Number;

/// The sum that a path collects.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Collected<'a> {
    /// 1 if it reaches the target.
    Target,
    /// The rewards until the target; infinite where that is not reached almost surely.
    Until(&'a Rewards),
    /// The rewards of all steps before the target, reached or not.
    Always(&'a Rewards),
}

/// A set to be reached.
#[derive(Clone, Copy)]
pub(crate) struct Reaching<'a> {
    pub(crate) game: &'a GameGraph,
    pub(crate) target: &'a BitVec,
    /// The states through which the target is to be reached; all others count as failure.
    pub(crate) left: &'a BitVec,
    pub(crate) collected: Collected<'a>,
    pub(crate) goal: Extremes,
}

/// The values of all states; infinite ones have none.
pub(crate) struct Vector<N> {
    pub(crate) values: Vec<Option<N>>,
    /// An error if a limit was reached, after which bounds may be wide.
    pub(crate) end: Result<()>,
}

impl<N: Number> Vector<N> {
    /// Creates a vector of finite values.
    pub(crate) fn of(values: Vec<N>) -> Self {
        Vector { values: values.into_iter().map(Some).collect(), end: Ok(()) }
    }

    /// Returns the values as an answer; none exceeds `most`.
    pub(crate) fn answer(self, most: f64) -> Answer {
        let value = |x: Option<N>| match x {
            None => Value::Infinite,
            Some(x) => Value::Finite(Bounds::of(&x).at_most(most)),
        };
        Answer { values: self.values.into_iter().map(value).collect(), end: self.end }
    }
}

/// Returns the value of a node in a solution; bounds of which nothing is known if it has none.
pub(crate) fn value_at<N: Number>(solution: &Solution<N>, node: u32, most: f64) -> Option<N> {
    solution.get(node).cloned().or_else(|| N::rounded(Interval { lower: 0.0, upper: most }))
}

impl Reaching<'_> {
    /// Computes the values: bounds, or fractions. Cost: some searches backward, and the equations between the regions.
    ///
    /// # Errors
    /// A limit is reached before anything is known.
    pub(crate) fn values<N: Number>(&self, meter: &mut Meter<'_>) -> Result<Vector<N>> {
        let (game, before) = (self.game, meter.bytes());
        let (sets, infinite) = self.regions(meter)?;
        meter.take(game.fractions().len() * N::BYTES + game.states() / 2 + game.choices_in_all() / 8)?;
        let numbers = |fractions: &[_]| fractions.iter().map(N::of).collect::<Vec<N>>();
        let fractions = numbers(game.fractions());
        let (quantity, rewards) = match self.collected {
            Collected::Target => (Quantity::Probability(1), None),
            Collected::Until(rewards) => (Quantity::Cost(1), Some(rewards)),
            Collected::Always(rewards) => (Quantity::Reward, Some(rewards)),
        };
        let gains = rewards.map_or_else(Vec::new, |own| numbers(own.fractions.list()));
        let rewards = rewards.map(|own| (own, &*gains));
        let system = System::of_sets((game, &sets), (quantity, self.goal), rewards, &fractions);
        let mut solution = system.start(meter)?;
        let end = system.solve(&mut solution, meter);
        let end = if N::EXACT { Ok(end?) } else { end };
        let value = |state: usize| match infinite[state] {
            true => None,
            false => value_at(&solution, state as u32, system.most()),
        };
        let values = (0..game.states()).map(value).collect();
        meter.release_to(before);
        Ok(Vector { values, end })
    }

    /// Finds the states that have equations, and those whose values are infinite.
    fn regions(&self, meter: &mut Meter<'_>) -> Result<(Sets, BitVec)> {
        let (game, before) = (self.game, meter.bytes());
        let [all, nowhere] = [true, false].map(|inside| BitVec::repeat(inside, game.choices_in_all()));
        let maximisers = game.maximisers(self.goal);
        let minimisers = !maximisers.clone();
        let nothing = BitVec::repeat(false, game.states());
        let (open, ones, infinite) = match self.collected {
            Collected::Target => {
                let sides = Sides::new(&game.choices, &maximisers, &all, meter)?;
                let positive = sides.positive(self.target, self.left);
                let one = sides.almost_sure_within(positive.clone(), self.target, self.left, meter)?;
                (positive & !one.clone(), one, nothing)
            }
            Collected::Until(rewards) => {
                let sides = Sides::new(&game.choices, &minimisers, &all, meter)?;
                let finite = sides.almost_sure(self.target, self.left, meter)?;
                // The value is 0 where minimisers need no choice that earns, and others have none.
                let free: BitVec = (0..all.len()).map(|choice| rewards.is_free(choice)).collect();
                let is_free = |state: usize| {
                    minimisers[state] || game.choices.of(state as u32).all(|choice| free[choice])
                };
                let left = (0..game.states()).map(|state| finite[state] && is_free(state)).collect();
                let zero = sides.with(&free).almost_sure(self.target, &left, meter)?;
                (finite.clone() & !zero, nothing, !finite)
            }
            Collected::Always(rewards) => {
                let gains = (0..nowhere.len()).map(|choice| !rewards.is_free(choice)).collect();
                let sides = Sides::new(&game.choices, &maximisers, &all, meter)?;
                let left = !self.target.clone();
                let infinite = sides.recurring(&gains, &left, meter)?;
                let positive = sides.earning(&gains, &left);
                (positive & !infinite.clone(), nothing, infinite)
            }
        };
        let is_finite =
            |choice: usize| game.choices.successors(choice).iter().all(|&to| !infinite[to as usize]);
        let permitted = if infinite.any() { (0..all.len()).map(is_finite).collect() } else { all };
        meter.release_to(before);
        Ok((Sets { open, ones, permitted }, infinite))
    }
}
