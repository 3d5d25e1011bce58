//! The probability to reach a set, and the expected reward until then, in all states of a game.
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
use super::total::Total;
use crate::equations::choices::Reversed;
use crate::equations::game_graph::{GameGraph, Goal, Rewards, opposite};
use crate::equations::meter::Meter;
use crate::equations::number::{Interval, Number};
use crate::equations::part::Part;
use crate::equations::system::Quantity;
use meliora_base::error::Result;
use meliora_base::exact::Ratio;
use meliora_model::Optimum;

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
    pub(crate) goal: Goal,
}

/// The states whose values are known without equations.
struct Known {
    /// Reached almost surely.
    one: BitVec,
    /// Reached possibly.
    positive: BitVec,
}

/// A strategy of a side.
#[derive(Clone)]
struct Strategy {
    /// The states of the side.
    side: BitVec,
    /// The choices that may be taken: one in the states of the side that are open, all in the others.
    choices: BitVec,
}

/// The values of a game, and the strategy of the leading side that attains their bound.
pub(crate) struct Led<N> {
    pub(crate) values: Vector<N>,
    /// The choices that may be taken if the side follows its strategy.
    pub(crate) choices: BitVec,
}

impl Reaching<'_> {
    /// Computes the values: bounds, or fractions. The bounds may be wide in games whose strategies do not settle.
    ///
    /// # Errors
    /// A limit is reached before anything is known.
    pub(crate) fn values<E: Entry>(&self, meter: &mut Meter<'_>) -> Result<Vector<E::Read>> {
        if self.game.is_uniform(self.goal) {
            return self.alone(self.goal.ours, &self.all_choices(), meter);
        }
        self.led::<E>(meter).map(|led| led.values)
    }

    /// Computes the values of a game with a strategy of the leaders that attains them.
    ///
    /// # Errors
    /// A limit is reached before anything is known.
    pub(crate) fn led<E: Entry>(&self, meter: &mut Meter<'_>) -> Result<Led<E::Read>> {
        let (leader, follower) = (self.leader(), opposite(self.leader()));
        let (mut strategy, region) = self.first(meter)?;
        let (near, first) = (self.step::<f64>(meter)?, strategy.choices.clone());
        if matches!(self.collected, Collected::Target) {
            let mut x: Vec<f64> = self.target.iter().map(|inside| f64::from(u8::from(*inside))).collect();
            let finite = BitVec::repeat(true, x.len());
            near.improve(&mut strategy, (&mut x, &finite), ROUNDS, meter)?;
        }
        let step = self.step::<E>(meter)?;
        if E::EXACT {
            near.improved(&mut strategy, follower, meter)?;
            let found = step.improved(&mut strategy, follower, meter)?;
            if region.iter_ones().all(|state| found.values[state].is_some()) {
                return Ok(Led { values: found, choices: strategy.choices });
            }
            // Doubles have led to choices that do not reach the target.
            strategy.choices = first;
            let values = step.improved(&mut strategy, follower, meter)?;
            return Ok(Led { values, choices: strategy.choices });
        }
        let mut known = step.improved(&mut strategy, follower, meter)?;
        let other = step.answered(&strategy.side, &known, meter)?;
        for (own, other) in known.values.iter_mut().zip(other.values) {
            let Some(own) = own.as_mut() else { continue };
            // Each side guarantees one of the bounds.
            let bounds = match (leader, other) {
                (Optimum::Max, Some(other)) => Some(Number::between(&own.low(), &other.high())),
                (Optimum::Max, None) => Number::rounded(Interval { upper: f64::INFINITY, ..own.bounds() }),
                (Optimum::Min, other) => other.map(|other| Number::between(&other.low(), &own.high())),
            };
            if let Some(bounds) = bounds {
                *own = bounds;
            }
        }
        known.end = known.end.and(other.end);
        Ok(Led { values: known, choices: strategy.choices })
    }

    /// Returns steps backward.
    fn step<E: Entry>(&self, meter: &mut Meter<'_>) -> Result<Step<'_, E>> {
        let near = |x: &Ratio| E::of(&E::Read::of(x));
        let back = Back::with(self.game, self.goal, self.rewards(), near, meter)?;
        let choices = &self.game.choices;
        meter.take(choices.bytes())?;
        Ok(Step { of: self, back, order: self.order(meter)?, reversed: choices.reversed() })
    }

    /// Returns the states, most of them after those that they reach, so that one sweep has the values of those that are
    /// in no cycle.
    fn order(&self, meter: &mut Meter<'_>) -> Result<Vec<u32>> {
        meter.take(self.game.states() * (components::SEARCH + size_of::<u32>()))?;
        let found = self.game.choices.components(0..self.game.states() as u32, |_| true);
        Ok(found.iter().flatten().copied().collect())
    }

    fn all_choices(&self) -> BitVec {
        BitVec::repeat(true, self.game.choices.start.len() - 1)
    }

    fn rewards(&self) -> Option<&Rewards> {
        match self.collected {
            Collected::Target => None,
            Collected::Until(rewards) | Collected::Always(rewards) => Some(rewards),
        }
    }

    /// Returns what the side looks for that has to do something for it: to reach the target, or to earn.
    fn leader(&self) -> Optimum {
        match self.collected {
            Collected::Target | Collected::Always(_) => Optimum::Max,
            Collected::Until(_) => Optimum::Min,
        }
    }

    /// Returns a first strategy of the leaders, which reaches the target where they can, and the states whose values are
    /// finite, as far as they are known.
    fn first(&self, meter: &mut Meter<'_>) -> Result<(Strategy, BitVec)> {
        let mut side = self.game.maximisers(self.goal);
        if self.leader() == Optimum::Min {
            side = !side;
        }
        let all = self.all_choices();
        let sides = Sides::new(&self.game.choices, &side, &all, meter)?;
        let (choices, region) = match self.collected {
            Collected::Until(_) => {
                let region = sides.almost_sure(self.target, self.left, meter)?;
                (sides.sure_strategy(self.target, &region), region)
            }
            Collected::Target => {
                (sides.strategy(self.target, self.left), BitVec::repeat(true, self.game.states()))
            }
            Collected::Always(_) => {
                let mut first = all.clone();
                for state in side.iter_ones().filter(|&state| !self.target[state]) {
                    self.take(&mut first, state, self.game.choices.of(state as u32).start);
                }
                (first, BitVec::repeat(false, self.game.states()))
            }
        };
        Ok((Strategy { side, choices }, region))
    }

    /// Lets a state take one choice.
    fn take(&self, choices: &mut BitVec, state: usize, pick: usize) {
        self.game.choices.of(state as u32).for_each(|choice| choices.set(choice, choice == pick));
    }

    /// Computes the values if every state looks for the same extreme among some choices.
    pub(super) fn alone<N: Number>(
        &self,
        optimum: Optimum,
        allowed: &BitVec,
        meter: &mut Meter<'_>,
    ) -> Result<Vector<N>> {
        if let Collected::Always(rewards) = self.collected {
            return Total { game: self.game, rewards, target: self.target, allowed }.values(optimum, meter);
        }
        let before = meter.bytes();
        let Known { one, positive } = self.known(optimum, allowed, meter)?;
        let (end, inside, quantity) = match (self.rewards(), optimum) {
            (Some(_), Optimum::Min) => (self.target.clone(), one, Quantity::Cost(1)),
            (Some(_), Optimum::Max) => (self.target.clone(), one, Quantity::Reward),
            (None, Optimum::Max) => (one, positive, Quantity::Probability(1)),
            // 1 minus the greatest probability of the contrary: its equations have one solution.
            (None, Optimum::Min) => (!positive, !one, Quantity::Probability(1)),
        };
        let part = Part::between(self.game, (&end, &inside), allowed, self.rewards());
        let found = part.values::<N>(quantity, meter);
        meter.release_to(before);
        let is_negated = self.rewards().is_none() && optimum == Optimum::Min;
        found.map(|found| if is_negated { found.complemented() } else { found })
    }

    /// Finds the states where the target is reached almost surely, and possibly. For rewards, almost surely by those
    /// who look for the least one.
    fn known(&self, optimum: Optimum, allowed: &BitVec, meter: &mut Meter<'_>) -> Result<Known> {
        let reach = self.leader() == optimum;
        let maximisers = BitVec::repeat(reach, self.game.states());
        let sides = Sides::new(&self.game.choices, &maximisers, allowed, meter)?;
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
    /// The choices that lead to each state: a sweep visits only states before those that have changed.
    reversed: Reversed,
}

impl<E: Entry> Step<'_, E> {
    /// Returns the best value of the choices of a state, for finite values `x` of some states, and a choice with it.
    fn best(&self, state: usize, (x, finite): (&[E], &BitVec)) -> Option<(E, usize)> {
        let game = self.of.game;
        let is_finite =
            |choice: &usize| game.choices.successors(*choice).iter().all(|&to| finite[to as usize]);
        let values = game.choices.of(state as u32).filter(is_finite);
        let better = |q: &E, than: &E| if self.back.maximisers[state] { q > than } else { q < than };
        values
            .map(|choice| (self.back.mean(choice, x), choice))
            .reduce(|best, other| if better(&other.0, &best.0) { other } else { best })
    }

    /// Replaces the choices of a strategy that are worse than others, in some sweeps of value iteration from the values
    /// `x` that it has; returns whether there are any.
    fn improve(
        &self,
        strategy: &mut Strategy,
        (x, finite): (&mut [E], &BitVec),
        sweeps: usize,
        meter: &mut Meter<'_>,
    ) -> Result<bool> {
        let is_open = |state: &usize| !self.of.target[*state] && self.of.left[*state] && finite[*state];
        let mut open: Vec<usize> = self.order.iter().map(|&state| state as usize).filter(is_open).collect();
        let mut changed = false;
        // Other values are infinite only where no strategy changes that.
        if matches!(self.of.collected, Collected::Always(_)) {
            open.retain(|&state| {
                let endless = self.endless(state, finite).filter(|_| strategy.side[state]);
                if let Some(pick) = endless {
                    self.of.take(&mut strategy.choices, state, pick);
                    changed = true;
                }
                endless.is_none()
            });
        }
        let mut stale = BitVec::<usize>::repeat(true, x.len());
        for _ in 0..sweeps {
            let (mut settled, slack) = (true, E::slack(x));
            for &state in &open {
                if !stale.replace(state, false) {
                    continue;
                }
                meter.step()?;
                let Some((value, pick)) = self.renewed(state, strategy, (x, finite), &slack) else {
                    continue;
                };
                if let Some(pick) = pick {
                    self.of.take(&mut strategy.choices, state, pick);
                    changed = true;
                }
                (x[state], settled) = (value, false);
                for &choice in self.reversed.entering(state as u32) {
                    stale.set(self.reversed.owner[choice as usize] as usize, true);
                }
            }
            if settled {
                break;
            }
        }
        Ok(changed)
    }

    /// Returns the value of a state that differs from `x` by more than `slack`, and the choice that a strategy takes for
    /// it instead of its own.
    fn renewed(
        &self,
        state: usize,
        strategy: &Strategy,
        (x, finite): (&[E], &BitVec),
        slack: &E,
    ) -> Option<(E, Option<usize>)> {
        let (q, pick) = self.best(state, (x, finite))?;
        let is_max = self.back.maximisers[state];
        let more = |a: &E, b: &E| if is_max { *a > b.plus(slack) } else { *b > a.plus(slack) };
        if !strategy.side[state] {
            // The values move towards what the side gains.
            return more(&x[state], &q).then_some((q, None));
        }
        let mut choices = self.of.game.choices.of(state as u32);
        let taken = choices.find(|&choice| strategy.choices[choice])?;
        let own = if taken == pick { q.clone() } else { self.back.mean(taken, x) };
        // A choice that is merely as good never replaces another one.
        if more(&q, &own) {
            return Some((q, Some(pick)));
        }
        more(&own, &x[state]).then_some((own, None))
    }

    /// Returns a choice with which a maximiser of a finite value reaches an infinite one.
    fn endless(&self, state: usize, finite: &BitVec) -> Option<usize> {
        let choices = &self.of.game.choices;
        let is_endless = |choice: &usize| choices.successors(*choice).iter().any(|&to| !finite[to as usize]);
        choices.of(state as u32).find(is_endless).filter(|_| self.back.maximisers[state])
    }

    /// Improves a strategy of a side until no other choice is clearly better. Returns the values of the best one, which
    /// `strategy` is then, against the best answers.
    fn improved(
        &self,
        strategy: &mut Strategy,
        answer: Optimum,
        meter: &mut Meter<'_>,
    ) -> Result<Vector<E::Read>> {
        let mut best: Option<(Vec<E>, Vector<E::Read>, BitVec)> = None;
        for _ in 0..rounds::<E>() {
            let found: Vector<E::Read> = self.of.alone(answer, &strategy.choices, meter)?;
            let (mut x, finite) = found.side::<E>(answer);
            let slack = E::slack(&x);
            let is_better = |(x, old): (&E, &E)| match answer {
                Optimum::Min => *x > old.plus(&slack),
                Optimum::Max => *old > x.plus(&slack),
            };
            let gained = |old: &Vector<E::Read>| {
                let endless = |(new, old): (&Option<_>, &Option<_>)| new.is_none() && old.is_some();
                answer == Optimum::Min && found.values.iter().zip(&old.values).any(endless)
            };
            if let Some((old, best, _)) = &best
                && (best.end.is_err() || !gained(best) && !x.iter().zip(old).any(is_better))
            {
                break;
            }
            let (own, taken) = (x.clone(), strategy.choices.clone());
            let goes_on =
                found.end.is_ok() && self.improve(strategy, (&mut x, &finite), sweeps::<E>(), meter)?;
            best = Some((own, found, taken));
            if !goes_on {
                break;
            }
        }
        let Some((_, found, taken)) = best else { return self.of.alone(answer, &strategy.choices, meter) };
        strategy.choices = taken;
        Ok(found)
    }

    /// Returns the values of the best strategy that is found for the other side: it begins with the best answers to the
    /// values `known`, which the leading side guarantees.
    fn answered(
        &self,
        leaders: &BitVec,
        known: &Vector<E::Read>,
        meter: &mut Meter<'_>,
    ) -> Result<Vector<E::Read>> {
        let leader = self.of.leader();
        let mut strategy = Strategy { side: !leaders.clone(), choices: self.of.all_choices() };
        let (x, finite) = known.side::<E>(opposite(leader));
        for state in strategy.side.iter_ones().filter(|&state| finite[state]) {
            if let Some((_, pick)) = self.best(state, (&x, &finite)) {
                self.of.take(&mut strategy.choices, state, pick);
            }
        }
        self.improved(&mut strategy, leader, meter)
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
