//! The probability to reach a set, and the expected reward until then, in all states of an arena.
//!
//! Where all states look for the same extreme, these are equations of one player. In a game, one side wants to reach
//! the set: the maximisers of a probability, the minimisers of a reward. It *leads*: a strategy of this side
//! leaves equations of one player, whose solution bounds the value of the game from one side. The strategy is changed
//! only where another choice is clearly better, so it always keeps reaching the set, and if nothing is better, its
//! values are those of the game: they solve the equations of both players and are attained. A strategy of the other
//! side that is best against these values bounds the value from the other side. A. Hoffman and R. Karp, "On
//! nonterminating stochastic games" (1966); end components belong to equations of one player, which are solved by
//! [`super::groups`].

use bitvec::vec::BitVec;

use super::doubles::ROUNDS;
use super::sides::Sides;
use super::sparse::BETTER;
use crate::equations::arena::{Arena, Goal, Rewards};
use crate::equations::graph::LOST;
use crate::equations::meter::Meter;
use crate::equations::number::{Interval, Number};
use crate::equations::part::Part;
use crate::equations::system::Quantity;
use crate::path_values::solved;
use meliora_base::error::{Error, Result};
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
    /// What is earned until then; `None` for probabilities.
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
        let all = self.all_choices();
        if self.arena.is_uniform(self.goal) {
            return self.alone(self.goal.ours, &all, meter);
        }
        let (mut strategy, _) = self.first(meter)?;
        loop {
            let found = self.alone(self.follower(), &strategy, meter)?;
            found.end?;
            let x: Vec<Option<Ratio>> = found.values;
            if !self.improve_exactly(&mut strategy, &x) {
                return Ok(Vector { values: x, end: Ok(()) });
            }
        }
    }

    /// Computes bounds of the values. They may be wide in games whose strategies do not settle.
    ///
    /// # Errors
    /// A limit is reached before anything is known.
    pub(crate) fn bounds(&self, meter: &mut Meter<'_>) -> Result<Vector<Interval>> {
        let all = self.all_choices();
        if self.arena.is_uniform(self.goal) {
            return self.alone(self.goal.ours, &all, meter);
        }
        let (mut lead, leaders) = self.first(meter)?;
        if self.rewards.is_none() {
            let x = self.target.iter().map(|inside| f64::from(u8::from(*inside))).collect();
            self.improve(&mut lead, &leaders, x, meter)?;
        }
        let mut known = self.improved(&mut lead, &leaders, self.follower(), meter)?;
        let mut follow = all;
        let followers = !leaders;
        self.best_against(&mut follow, &followers, &known);
        let other = self.improved(&mut follow, &followers, self.leader(), meter)?;
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

    /// Returns a strategy with which the leaders reach the target, as choices that may be taken, and the leaders.
    fn first(&self, meter: &mut Meter<'_>) -> Result<(BitVec, BitVec)> {
        let mut leaders = self.arena.maximisers(self.goal);
        if self.rewards.is_some() {
            leaders = !leaders;
        }
        let all = self.all_choices();
        let sides = Sides::new(&self.arena.choices, &leaders, &all, meter)?;
        let strategy = match self.rewards {
            Some(_) => sides.sure_strategy(self.target, &sides.almost_sure(self.target, self.left, meter)?),
            None => sides.strategy(self.target, self.left),
        };
        Ok((strategy, leaders))
    }

    /// Improves a strategy of a side until no other choice is clearly better, and returns the bounds of its values
    /// against the best answers.
    fn improved(
        &self,
        strategy: &mut BitVec,
        side: &BitVec,
        answer: Optimum,
        meter: &mut Meter<'_>,
    ) -> Result<Vector<Interval>> {
        let mut best: Option<Vector<Interval>> = None;
        for _ in 0..ROUNDS {
            let found: Vector<Interval> = self.alone(answer, strategy, meter)?;
            let x: Vec<f64> = found.values.iter().map(|x| near(x.as_ref(), answer)).collect();
            let goes_on = found.end.is_ok()
                && match &mut best {
                    None => {
                        best = Some(found);
                        true
                    }
                    Some(best) => best.narrow(found, answer),
                };
            if !goes_on || !self.improve(strategy, side, x, meter)? {
                break;
            }
        }
        best.ok_or_else(|| Error::Usage("a strategy has no values".to_owned()))
    }

    /// Replaces the choices of a side that are clearly worse than others after some sweeps of value iteration from
    /// its values `x`; returns whether there are any.
    fn improve(
        &self,
        strategy: &mut BitVec,
        side: &BitVec,
        mut x: Vec<f64>,
        meter: &mut Meter<'_>,
    ) -> Result<bool> {
        let fractions: Vec<f64> =
            self.arena.fractions.list().iter().map(|p| Interval::around(p).lower).collect();
        let gains: Vec<f64> = self.rewards.map_or_else(Vec::new, |rewards| {
            rewards.fractions.list().iter().map(|gain| Interval::around(gain).lower).collect()
        });
        let greatest = self.arena.maximisers(self.goal);
        let mut changed = false;
        for _ in 0..ROUNDS {
            let mut settled = true;
            for state in (0..x.len()).rev() {
                meter.step()?;
                if self.target[state] || !self.left[state] || !x[state].is_finite() {
                    continue;
                }
                let value = |choice: usize| {
                    let gain = self.rewards.map_or(0.0, |own| gains[own.of_choice.get(choice) as usize]);
                    self.arena
                        .edges(choice)
                        .fold(gain, |sum, (to, weight)| sum + fractions[weight as usize] * x[to as usize])
                };
                let better = |q: f64, than: f64| match greatest[state] {
                    true => q > than * (1.0 + BETTER),
                    false => q < than * (1.0 - BETTER),
                };
                let choices = self.arena.choices.of(state as u32);
                if side[state] {
                    let (mut best, mut pick) = (x[state], None);
                    for choice in choices.clone() {
                        let q = value(choice);
                        if better(q, best) {
                            (best, pick) = (q, Some(choice));
                        }
                    }
                    if let Some(pick) = pick {
                        choices.for_each(|choice| strategy.set(choice, choice == pick));
                        (x[state], changed, settled) = (best, true, false);
                    }
                } else {
                    let worst = choices.map(value).reduce(if greatest[state] { f64::max } else { f64::min });
                    let worst = worst.unwrap_or(x[state]);
                    // Values move towards what the side gains.
                    let gains = if greatest[state] { worst < x[state] } else { worst > x[state] };
                    if gains {
                        x[state] = worst;
                    }
                }
            }
            if settled {
                break;
            }
        }
        Ok(changed)
    }

    /// Restricts a side to the choices that are best for known values.
    fn best_against(&self, strategy: &mut BitVec, side: &BitVec, known: &Vector<Interval>) {
        let greatest = self.arena.maximisers(self.goal);
        let middle = |x: &Option<Interval>| x.map_or(f64::INFINITY, |x| f64::midpoint(x.lower, x.upper));
        let x: Vec<f64> = known.values.iter().map(middle).collect();
        let fractions: Vec<f64> =
            self.arena.fractions.list().iter().map(|p| Interval::around(p).lower).collect();
        for state in side.iter_ones() {
            let value = |choice: usize| {
                let gain = self.rewards.map_or(0.0, |own| Interval::around(own.choice(choice)).lower);
                self.arena
                    .edges(choice)
                    .fold(gain, |sum, (to, weight)| sum + fractions[weight as usize] * x[to as usize])
            };
            let choices = self.arena.choices.of(state as u32);
            let order = |a: &(f64, usize), b: &(f64, usize)| match greatest[state] {
                true => b.0.total_cmp(&a.0),
                false => a.0.total_cmp(&b.0),
            };
            let best = choices.clone().map(|choice| (value(choice), choice)).min_by(order);
            choices.for_each(|choice| strategy.set(choice, best.is_some_and(|(_, own)| own == choice)));
        }
    }

    /// Replaces the choices of the leaders by better ones for their exact values; returns whether there are any.
    fn improve_exactly(&self, strategy: &mut BitVec, x: &[Option<Ratio>]) -> bool {
        let greatest = self.arena.maximisers(self.goal);
        let mut changed = false;
        for state in 0..x.len() {
            let Some(own) = &x[state] else { continue };
            let leads = greatest[state] == (self.leader() == Optimum::Max);
            if !leads || self.target[state] || !self.left[state] {
                continue;
            }
            let choices = self.arena.choices.of(state as u32);
            let (mut best, mut pick) = (own.clone(), None);
            for choice in choices.clone() {
                let Some(q) = self.value(choice, x) else { continue };
                if if greatest[state] { q > best } else { q < best } {
                    (best, pick) = (q, Some(choice));
                }
            }
            if let Some(pick) = pick {
                choices.for_each(|choice| strategy.set(choice, choice == pick));
                changed = true;
            }
        }
        changed
    }

    /// Returns the value of a choice; `None` if it is infinite.
    fn value(&self, choice: usize, x: &[Option<Ratio>]) -> Option<Ratio> {
        let mut sum = self.rewards.map_or_else(Ratio::default, |own| own.choice(choice).clone());
        for (to, weight) in self.arena.edges(choice) {
            sum += &self.arena.fractions.list()[weight as usize] * x[to as usize].as_ref()?;
        }
        Some(sum)
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
