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

use super::at_nodes::Vector;
use super::back::Back;
use super::components;
use super::groups::Entry;
use super::policies::{ROUNDS, rounds, sweeps};
use super::sides::Sides;
use crate::equations::arena::{Arena, Goal, Rewards, opposite};
use crate::equations::meter::Meter;
use crate::equations::number::Number;
use crate::equations::part::Part;
use crate::equations::system::Quantity;
use meliora_base::error::Result;
use meliora_base::exact::Ratio;
use meliora_model::Optimum;

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
    /// Computes the values: bounds, or fractions. The bounds may be wide in games whose strategies do not settle.
    ///
    /// # Errors
    /// A limit is reached before anything is known.
    pub(crate) fn values<E: Entry>(&self, meter: &mut Meter<'_>) -> Result<Vector<E::Read>> {
        if self.arena.is_uniform(self.goal) {
            return self.alone(self.goal.ours, &self.all_choices(), meter);
        }
        let (leader, follower) = (self.leader(), opposite(self.leader()));
        let (first, leaders, region) = self.first(meter)?;
        let (near, mut strategy) = (self.step::<f64>(meter)?, first.clone());
        if self.rewards.is_none() {
            let mut x: Vec<f64> = self.target.iter().map(|inside| f64::from(u8::from(*inside))).collect();
            let finite = BitVec::repeat(true, x.len());
            near.improve((&mut strategy, &leaders), (&mut x, &finite), ROUNDS, meter)?;
        }
        let step = self.step::<E>(meter)?;
        if E::EXACT {
            near.improved((&mut strategy, &leaders), follower, meter)?;
            let found = step.improved((&mut strategy, &leaders), follower, meter)?;
            if region.iter_ones().all(|state| found.values[state].is_some()) {
                return Ok(found);
            }
            // Doubles have led to choices that do not reach the target.
            strategy = first;
            return step.improved((&mut strategy, &leaders), follower, meter);
        }
        let mut known = step.improved((&mut strategy, &leaders), follower, meter)?;
        let (mut follow, followers) = (self.all_choices(), !leaders);
        let (x, finite) = known.side::<E>(follower);
        for state in followers.iter_ones().filter(|&state| finite[state]) {
            if let Some((_, pick)) = step.best(state, (&x, &finite)) {
                step.take(&mut follow, state, pick);
            }
        }
        let other = step.improved((&mut follow, &followers), leader, meter)?;
        for (own, other) in known.values.iter_mut().zip(other.values) {
            if let (Some(own), Some(other)) = (own.as_mut(), other) {
                // Each side guarantees one of the bounds.
                *own = match leader {
                    Optimum::Max => Number::between(&own.low(), &other.high()),
                    Optimum::Min => Number::between(&other.low(), &own.high()),
                };
            }
        }
        known.end = known.end.and(other.end);
        Ok(known)
    }

    /// Returns steps backward.
    fn step<E: Entry>(&self, meter: &mut Meter<'_>) -> Result<Step<'_, E>> {
        let near = |x: &Ratio| E::of(&E::Read::of(x));
        let back = Back::with(self.arena, self.goal, self.rewards, near, meter)?;
        Ok(Step { of: self, back, order: self.order(meter)? })
    }

    /// Returns the states, most of them after those that they reach, so that one sweep has the values of those that are
    /// in no cycle.
    fn order(&self, meter: &mut Meter<'_>) -> Result<Vec<u32>> {
        meter.take(self.arena.states() * (components::SEARCH + size_of::<u32>()))?;
        let found = self.arena.choices.components(0..self.arena.states() as u32, |_| true);
        Ok(found.iter().flatten().copied().collect())
    }

    fn all_choices(&self) -> BitVec {
        BitVec::repeat(true, self.arena.choices.start.len() - 1)
    }

    /// Returns what the side that wants to reach the target looks for.
    fn leader(&self) -> Optimum {
        if self.rewards.is_some() { Optimum::Min } else { Optimum::Max }
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
        let found = part.values::<N>(quantity, meter);
        meter.release_to(before);
        let is_negated = self.rewards.is_none() && optimum == Optimum::Min;
        found.map(|found| if is_negated { found.complemented() } else { found })
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

/// Steps backward by which strategies are improved.
struct Step<'a, E> {
    of: &'a Reaching<'a>,
    back: Back<'a, E>,
    /// The states in the order of a sweep.
    order: Vec<u32>,
}

/// A strategy of a side, as choices that may be taken, and the states of the side.
type Played<'p> = (&'p mut BitVec, &'p BitVec);

impl<E: Entry> Step<'_, E> {
    /// Returns the best value of the choices of a state, for finite values `x` of some states, and a choice with it.
    fn best(&self, state: usize, (x, finite): (&[E], &BitVec)) -> Option<(E, usize)> {
        let arena = self.of.arena;
        let is_finite =
            |choice: &usize| arena.choices.successors(*choice).iter().all(|&to| finite[to as usize]);
        let values = arena.choices.of(state as u32).filter(is_finite);
        let better = |q: &E, than: &E| if self.back.maximisers[state] { q > than } else { q < than };
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
        (x, finite): (&mut [E], &BitVec),
        sweeps: usize,
        meter: &mut Meter<'_>,
    ) -> Result<bool> {
        let is_open = |state: &usize| !self.of.target[*state] && self.of.left[*state] && finite[*state];
        let order = || self.order.iter().map(|&state| state as usize);
        let mut changed = false;
        for _ in 0..sweeps {
            let (mut settled, slack) = (true, E::slack(x));
            for state in order().filter(is_open) {
                meter.step()?;
                let Some((q, pick)) = self.best(state, (x, finite)) else { continue };
                let is_max = self.back.maximisers[state];
                let more = |a: &E, b: &E| if is_max { *a > b.plus(&slack) } else { *b > a.plus(&slack) };
                // A choice that is merely as good never replaces another one.
                let choices = self.of.arena.choices.of(state as u32);
                let taken = choices.clone().find(|&choice| strategy[choice]).filter(|_| side[state]);
                let own = taken.map(|taken| self.back.mean(taken, x));
                let value = match own {
                    Some(own) if more(&q, &own) => {
                        choices.for_each(|choice| strategy.set(choice, choice == pick));
                        changed = true;
                        q
                    }
                    Some(own) if more(&own, &x[state]) => own,
                    // The values move towards what the side gains.
                    None if more(&x[state], &q) => q,
                    _ => continue,
                };
                (x[state], settled) = (value, false);
            }
            if settled {
                break;
            }
        }
        Ok(changed)
    }

    /// Improves a strategy of a side until no other choice is clearly better, and returns the values of the best one
    /// against the best answers.
    fn improved(
        &self,
        (strategy, side): Played<'_>,
        answer: Optimum,
        meter: &mut Meter<'_>,
    ) -> Result<Vector<E::Read>> {
        let mut best: Option<(Vec<E>, Vector<E::Read>)> = None;
        for _ in 0..rounds::<E>() {
            let found: Vector<E::Read> = self.of.alone(answer, strategy, meter)?;
            let (mut x, finite) = found.side::<E>(answer);
            let slack = E::slack(&x);
            let is_better = |(x, old): (&E, &E)| match answer {
                Optimum::Min => *x > old.plus(&slack),
                Optimum::Max => *old > x.plus(&slack),
            };
            if let Some((old, best)) = &best
                && (best.end.is_err() || !x.iter().zip(old).any(is_better))
            {
                break;
            }
            let own = x.clone();
            let goes_on = found.end.is_ok()
                && self.improve((strategy, side), (&mut x, &finite), sweeps::<E>(), meter)?;
            best = Some((own, found));
            if !goes_on {
                break;
            }
        }
        best.map_or_else(|| self.of.alone(answer, strategy, meter), |(_, found)| Ok(found))
    }
}

impl<N: Number> Vector<N> {
    /// Returns 1 minus each probability.
    pub(crate) fn complemented(self) -> Self {
        Vector { values: self.values.iter().map(|x| x.as_ref().map(N::complement)).collect(), end: self.end }
    }

    /// Returns the bounds that a strategy guarantees against the best answers, and the states where they are finite.
    fn side<E: Entry<Read = N>>(&self, answer: Optimum) -> (Vec<E>, BitVec) {
        let side = |x: &N| E::of(&if answer == Optimum::Min { x.low() } else { x.high() });
        let x: Vec<Option<E>> = self.values.iter().map(|x| x.as_ref().map(side)).collect();
        let finite = x.iter().map(|x| x.as_ref().is_some_and(E::is_finite)).collect();
        (x.into_iter().map(|x| x.filter(E::is_finite).unwrap_or_else(E::zero)).collect(), finite)
    }
}
