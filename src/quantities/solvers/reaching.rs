//! The probability to reach a set, and the expected reward until then, in all states of an arena.
//!
//! These are equations of one player if all states look for the same extreme. In a game, one side wants to reach
//! the set: the maximisers of a probability, the minimisers of a reward. It *leads*: a strategy of this side
//! leaves equations of one player, whose solution bounds the value of the game from one side. The strategy is changed
//! only where another choice is clearly better, so it always keeps reaching the set, and if nothing is better, its
//! values are those of the game: they solve the equations of both players and are attained. A strategy of the other
//! side that is best against these values bounds the value from the other side. A. Hoffman and R. Karp, "On
//! nonterminating stochastic games" (1966); end components belong to equations of one player, which are solved by
//! [`super::groups`].

use bitvec::vec::BitVec;

use super::back::Back;
use super::components;
use super::doubles::ROUNDS;
use super::sides::Sides;
use super::sparse::BETTER;
use crate::equations::arena::{Arena, Goal, Rewards};
use crate::equations::graph::LOST;
use crate::equations::meter::Meter;
use crate::equations::number::{Interval, Number, Weight};
use crate::equations::part::Part;
use crate::equations::system::Quantity;
use crate::path_values::solved;
use meliora_base::error::Result;
use meliora_base::exact::Ratio;
use meliora_model::Optimum;

/// The values of all states; infinite ones have none.
pub(crate) struct Vector<N> {
    pub(crate) values: Vec<Option<N>>,
    /// An error if a limit was reached, after which bounds may be wide.
    pub(crate) end: Result<()>,
}

/// A set to be reached.
pub(crate) struct Reaching<'a> {
    pub(crate) arena: &'a Arena<'a>,
    pub(crate) target: &'a BitVec,
    /// The states through which the target is to be reached; all others count as failure.
    pub(crate) left: &'a BitVec,
    /// The rewards until then; `None` for probabilities.
    pub(crate) rewards: Option<&'a Rewards>,
    pub(crate) goal: Goal,
}

/// The states whose values are known without equations.
struct Known {
    /// Reached almost surely.
    one: BitVec,
    /// Reached possibly.
    positive: BitVec,
}

impl Reaching<'_> {
    /// Computes the values with fractions.
    ///
    /// # Errors
    /// A limit is reached before anything is known.
    pub(crate) fn exact(&self, meter: &mut Meter<'_>) -> Result<Vector<Ratio>> {
        if self.arena.is_uniform(self.goal) {
            return self.alone(self.goal.ours, &self.all_choices(), meter);
        }
        let led = self.led(&self.nearly(meter)?, meter)?;
        let (mut strategy, first) = (led.strategy, led.first);
        let back = Back::new(self.arena, self.goal, self.rewards, meter)?;
        let step = Step { of: self, back, order: self.order(meter)? };
        loop {
            let found: Vector<Ratio> = self.alone(self.follower(), &strategy, meter)?;
            found.end?;
            let finite: BitVec = found.values.iter().map(Option::is_some).collect();
            if led.region.iter_ones().any(|state| !finite[state]) {
                // Doubles have led to choices that do not reach the target.
                strategy.clone_from(&first);
                continue;
            }
            let mut x = found.values.iter().map(|x| x.clone().unwrap_or_default()).collect::<Vec<_>>();
            let better = |q: &Ratio, than: &Ratio, greatest: bool| if greatest { q > than } else { q < than };
            if !step.improve((&mut strategy, &led.leaders), (&mut x, &finite), 1, better, meter)? {
                return Ok(Vector { values: found.values, end: Ok(()) });
            }
        }
    }

    /// Computes bounds of the values. They may be wide in games whose strategies do not settle.
    ///
    /// # Errors
    /// A limit is reached before anything is known.
    pub(crate) fn bounds(&self, meter: &mut Meter<'_>) -> Result<Vector<Interval>> {
        if self.arena.is_uniform(self.goal) {
            return self.alone(self.goal.ours, &self.all_choices(), meter);
        }
        let step = self.nearly(meter)?;
        let Led { leaders, mut known, .. } = self.led(&step, meter)?;
        let (mut follow, followers) = (self.all_choices(), !leaders);
        let finite: BitVec = known.values.iter().map(Option::is_some).collect();
        let middle = |x: &Option<Interval>| x.map_or(0.0, |x| f64::midpoint(x.lower, x.upper));
        let x: Vec<f64> = known.values.iter().map(middle).collect();
        for state in followers.iter_ones().filter(|&state| finite[state]) {
            if let Some((_, pick)) = step.best(state, (&x, &finite)) {
                step.take(&mut follow, state, pick);
            }
        }
        let other = step.improved((&mut follow, &followers), self.leader(), meter)?;
        for (own, other) in known.values.iter_mut().zip(other.values) {
            if let (Some(own), Some(other)) = (own.as_mut(), other) {
                // Each side guarantees one of the bounds.
                *own = match self.leader() {
                    Optimum::Max => Interval { lower: own.lower, upper: other.upper.max(own.lower) },
                    Optimum::Min => Interval { lower: other.lower.min(own.upper), upper: own.upper },
                };
            }
        }
        known.end = known.end.and(other.end);
        Ok(known)
    }

    /// Improves a strategy of the leaders by doubles.
    fn led(&self, step: &Step<'_, f64>, meter: &mut Meter<'_>) -> Result<Led> {
        let (first, leaders, region) = self.first(meter)?;
        let mut strategy = first.clone();
        if self.rewards.is_none() {
            let mut x: Vec<f64> = self.target.iter().map(|inside| f64::from(u8::from(*inside))).collect();
            let finite = BitVec::repeat(true, x.len());
            step.improve((&mut strategy, &leaders), (&mut x, &finite), ROUNDS, clearly, meter)?;
        }
        let known = step.improved((&mut strategy, &leaders), self.follower(), meter)?;
        Ok(Led { strategy, first, leaders, region, known })
    }

    /// Returns the steps backward with doubles.
    fn nearly(&self, meter: &mut Meter<'_>) -> Result<Step<'_, f64>> {
        let near = |x: &Ratio| Interval::around(x).lower;
        let back = Back::with(self.arena, self.goal, self.rewards, near, meter)?;
        Ok(Step { of: self, back, order: self.order(meter)? })
    }

    /// Returns the states, most of them after those that they reach, so that one sweep has the values of those that are
    /// in no cycle.
    fn order(&self, meter: &mut Meter<'_>) -> Result<Vec<u32>> {
        meter.take(self.arena.states() * (components::SEARCH + size_of::<u32>()))?;
        let found = components::components(&self.arena.choices, 0..self.arena.states() as u32);
        Ok(found.iter().flatten().copied().collect())
    }

    fn all_choices(&self) -> BitVec {
        BitVec::repeat(true, self.arena.choices.start.len() - 1)
    }

    /// Returns what the side that wants to reach the target looks for.
    fn leader(&self) -> Optimum {
        if self.rewards.is_some() { Optimum::Min } else { Optimum::Max }
    }

    fn follower(&self) -> Optimum {
        if self.rewards.is_some() { Optimum::Max } else { Optimum::Min }
    }

    /// Returns a strategy with which the leaders reach the target, as choices that may be taken, the leaders, and the
    /// states whose values are finite.
    fn first(&self, meter: &mut Meter<'_>) -> Result<(BitVec, BitVec, BitVec)> {
        let mut leaders = self.arena.maximisers(self.goal);
        if self.rewards.is_some() {
            leaders = !leaders;
        }
        let all = self.all_choices();
        let sides = Sides::new(&self.arena.choices, &leaders, &all, meter)?;
        let (strategy, region) = match self.rewards {
            Some(_) => {
                let region = sides.almost_sure(self.target, self.left, meter)?;
                (sides.sure_strategy(self.target, &region), region)
            }
            None => (sides.strategy(self.target, self.left), BitVec::repeat(true, self.arena.states())),
        };
        Ok((strategy, leaders, region))
    }

    /// Computes the values if every state looks for the same extreme among some choices.
    pub(crate) fn alone<N: Number>(
        &self,
        optimum: Optimum,
        allowed: &BitVec,
        meter: &mut Meter<'_>,
    ) -> Result<Vector<N>> {
        let before = meter.bytes();
        let Known { one, positive } = self.known(optimum, allowed, meter)?;
        let (end, inside, quantity) = match (self.rewards, optimum) {
            (Some(_), Optimum::Min) => (self.target.clone(), one, Quantity::Cost(1)),
            (Some(_), Optimum::Max) => (self.target.clone(), one, Quantity::Reward),
            (None, Optimum::Max) => (one, positive, Quantity::Probability(1)),
            // 1 minus the greatest probability of the contrary: its equations have one solution.
            (None, Optimum::Min) => (!positive, !one, Quantity::Probability(1)),
        };
        let part = Part::between(self.arena, (&end, &inside), allowed, self.rewards);
        let found = values::<N>(&part, quantity, meter);
        meter.release_to(before);
        let mut found = found?;
        if self.rewards.is_none() && optimum == Optimum::Min {
            found.values.iter_mut().for_each(|x| *x = x.take().map(|x| x.complement()));
        }
        Ok(found)
    }

    /// Finds the states where the target is reached almost surely, and possibly. For rewards, almost surely by those
    /// who look for the least one.
    fn known(&self, optimum: Optimum, allowed: &BitVec, meter: &mut Meter<'_>) -> Result<Known> {
        let reach = self.leader() == optimum;
        let maximisers = BitVec::repeat(reach, self.arena.states());
        let sides = Sides::new(&self.arena.choices, &maximisers, allowed, meter)?;
        let one = sides.almost_sure(self.target, self.left, meter)?;
        Ok(Known { one, positive: sides.positive(self.target, self.left) })
    }
}

/// A strategy of the leaders.
struct Led {
    strategy: BitVec,
    /// The strategy that was improved.
    first: BitVec,
    leaders: BitVec,
    /// The states whose values are finite.
    region: BitVec,
    /// Bounds of the values of the strategy.
    known: Vector<Interval>,
}

/// Steps backward by which strategies are improved.
struct Step<'a, N> {
    of: &'a Reaching<'a>,
    back: Back<'a, N>,
    /// The states in the order of a sweep.
    order: Vec<u32>,
}

/// A strategy of a side, as choices that may be taken, and the states of the side.
type Played<'p> = (&'p mut BitVec, &'p BitVec);

impl<N: Weight + PartialEq + PartialOrd> Step<'_, N> {
    /// Returns the best value of the choices of a state, for finite values `x` of some states, and a choice with it.
    fn best(&self, state: usize, (x, finite): (&[N], &BitVec)) -> Option<(N, usize)> {
        let arena = self.of.arena;
        let is_finite =
            |choice: &usize| arena.choices.successors(*choice).iter().all(|&to| finite[to as usize]);
        let values = arena.choices.of(state as u32).filter(is_finite);
        let better = |q: &N, than: &N| if self.back.maximisers[state] { q > than } else { q < than };
        values
            .map(|choice| (self.back.mean(choice, x), choice))
            .reduce(|best, other| if better(&other.0, &best.0) { other } else { best })
    }

    /// Lets a state take one choice.
    fn take(&self, strategy: &mut BitVec, state: usize, pick: usize) {
        self.of.arena.choices.of(state as u32).for_each(|choice| strategy.set(choice, choice == pick));
    }

    /// Replaces the choices of a side that are worse than others, in some sweeps of value iteration from the values `x`
    /// of its strategy; returns whether there are any.
    fn improve(
        &self,
        (strategy, side): Played<'_>,
        (x, finite): (&mut [N], &BitVec),
        sweeps: usize,
        better: impl Fn(&N, &N, bool) -> bool,
        meter: &mut Meter<'_>,
    ) -> Result<bool> {
        let is_open = |state: &usize| !self.of.target[*state] && self.of.left[*state] && finite[*state];
        let order = || self.order.iter().map(|&state| state as usize);
        let mut changed = false;
        for _ in 0..sweeps {
            let mut settled = true;
            for state in order().filter(is_open) {
                meter.step()?;
                let Some((q, pick)) = self.best(state, (x, finite)) else { continue };
                let greatest = self.back.maximisers[state];
                if side[state] && better(&q, &x[state], greatest) {
                    self.take(strategy, state, pick);
                    (x[state], changed, settled) = (q, true, false);
                } else if !side[state] && if greatest { q < x[state] } else { q > x[state] } {
                    // The values move towards what the side gains.
                    x[state] = q;
                }
            }
            if settled {
                break;
            }
        }
        Ok(changed)
    }
}

impl Step<'_, f64> {
    /// Improves a strategy of a side until no other choice is clearly better, and returns the bounds of its values
    /// against the best answers.
    fn improved(
        &self,
        (strategy, side): Played<'_>,
        answer: Optimum,
        meter: &mut Meter<'_>,
    ) -> Result<Vector<Interval>> {
        let mut best: Vector<Interval> = self.of.alone(answer, strategy, meter)?;
        let mut x: Vec<f64> = best.values.iter().map(|x| near(x.as_ref(), answer)).collect();
        for _ in 0..ROUNDS {
            let finite: BitVec = x.iter().map(|x| x.is_finite()).collect();
            let goes_on = best.end.is_ok()
                && self.improve((strategy, side), (&mut x, &finite), ROUNDS, clearly, meter)?;
            if !goes_on {
                break;
            }
            let found: Vector<Interval> = self.of.alone(answer, strategy, meter)?;
            x = found.values.iter().map(|x| near(x.as_ref(), answer)).collect();
            if !best.narrow(found, answer) {
                break;
            }
        }
        Ok(best)
    }
}

/// Returns whether a value is clearly better than another one.
fn clearly(q: &f64, than: &f64, greatest: bool) -> bool {
    if greatest { *q > than * (1.0 + BETTER) } else { *q < than * (1.0 - BETTER) }
}

/// Returns the bound of a value that a strategy guarantees against the best answers.
fn near(x: Option<&Interval>, answer: Optimum) -> f64 {
    x.map_or(f64::INFINITY, |x| if answer == Optimum::Min { x.lower } else { x.upper })
}

impl Vector<Interval> {
    /// Narrows bounds by those of a better strategy; returns whether some became clearly better.
    fn narrow(&mut self, other: Self, answer: Optimum) -> bool {
        let mut better = false;
        for (own, other) in self.values.iter_mut().zip(other.values) {
            let Some(other) = other else { continue };
            let Some(own) = own.as_mut() else {
                *own = Some(other);
                better = true;
                continue;
            };
            match answer {
                Optimum::Min => {
                    better |= other.lower > own.lower * (1.0 + BETTER);
                    own.lower = own.lower.max(other.lower);
                }
                Optimum::Max => {
                    better |= other.upper < own.upper * (1.0 - BETTER);
                    own.upper = own.upper.min(other.upper);
                }
            }
        }
        self.end = std::mem::replace(&mut self.end, Ok(())).and(other.end);
        better
    }
}

/// Returns the values of all states of an arena from the solution of a part with one exit.
pub(crate) fn values<N: Number>(
    part: &Part<'_>,
    quantity: Quantity,
    meter: &mut Meter<'_>,
) -> Result<Vector<N>> {
    let graph = part.graph(meter)?;
    let (solution, end) = solved::<N>(&graph, quantity, None, meter)?;
    let end = if N::EXACT { Ok(end?) } else { end };
    let is_reward = part.rewards.is_some();
    let most = if is_reward { f64::INFINITY } else { 1.0 };
    let value = |&node: &u32| match node {
        0 => Some(if is_reward { N::zero() } else { N::one() }),
        LOST if is_reward => None,
        LOST => Some(N::zero()),
        node => solution.get(node).cloned().or_else(|| N::rounded(Interval { lower: 0.0, upper: most })),
    };
    Ok(Vector { values: part.nodes.iter().map(value).collect(), end })
}
