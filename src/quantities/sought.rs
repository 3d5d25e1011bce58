//! The number that one operator asks for in some states: the probability of a formula, or a reward until a target.

use meliora_base::error::{Error, Result};
use meliora_engine::Engine;
use meliora_engine::regions::{Regions, Which};
use meliora_equations::vector::{Accumulation, Asked, MOST_STATES, Until, too_many_states};
use meliora_equations::{Answer, Arena, Extremes, Value};
use meliora_model::temporal::{Asks, Condition};
use meliora_model::{Optimum, Program, State};

/// A number that is sought.
pub enum Sought<'a, S> {
    /// The probability of the formula that the regions belong to. A formula with monitors has a condition on them.
    Probability(Option<&'a Condition>),
    /// The reward of the structure with this number until a state of the target is reached; not of games.
    Reward(usize, &'a S),
}

/// Computes a number in some states, up to a precision, or with fractions if it is 0.
pub type Compute<'a> = Box<dyn FnMut(f64) -> Result<Answer> + 'a>;

/// Returns the regions from which the extreme probability of a formula, or the extreme reward until a target, is computed.
pub fn needed(is_reward: bool, optimum: Optimum) -> &'static [Which] {
    match (is_reward, optimum) {
        (false, Optimum::Max) => &[Which::PmaxPositive, Which::PmaxOne],
        (false, Optimum::Min) => &[Which::PminPositive, Which::PminOne],
        (true, Optimum::Min) => &[Which::PmaxOne],
        (true, Optimum::Max) => &[Which::PminOne],
    }
}

impl<S> Sought<'_, S> {
    /// Returns the regions of the formula, or of reaching the target, from which the number is computed.
    pub fn needed(&self, optimum: Optimum) -> &'static [Which] {
        needed(matches!(self, Sought::Reward(..)), optimum)
    }

    /// Returns whether a finite part of a path violates the formula, or satisfies it; `None` if no part decides it.
    fn is_safe(&self) -> Option<bool> {
        match self {
            Sought::Probability(Some(condition)) if !condition.only_asks(Asks::Accept) => {
                condition.only_asks(Asks::Avoid).then_some(true)
            }
            _ => Some(false),
        }
    }

    /// Prepares the number in some states, from the regions that [`Sought::needed`] names. In a game the optimum is ours,
    /// and the opponent looks for the other one. With `settles`, the other ways of a race end once the states are listed;
    /// see [`Arena::settle`]. `None` if such a number of a game is not supported: the formula is neither safe nor co-safe.
    ///
    /// The value of a co-safe formula is the probability to reach the states in which it is 1. That of a safe one is 1 minus
    /// the probability to reach those in which it is 0; so is the least value of any formula for one player. So only the
    /// states between the regions, as far as the given ones reach them, have equations.
    ///
    /// Cost: that of [`Arena::reached`].
    ///
    /// # Errors
    /// A limit is reached, a region is missing, or a reward is wrong or one of a game.
    pub fn prepare<'e, E: Engine<States = S>>(
        &self,
        (engine, program): (&'e E, &'e Program),
        optimum: Optimum,
        regions: &Regions<Option<S>>,
        states: &[State],
        settles: bool,
    ) -> Result<Option<Compute<'e>>>
    where
        S: Clone + 'e,
    {
        if states.len() > MOST_STATES {
            return Err(too_many_states().into());
        }
        let all = engine.all_states();
        let outside = |which: Which| engine.difference(&all, regions.known(which)?);
        let reached = |stops: &S| {
            let found = Arena::reached(engine, program, states, stops)?;
            if settles {
                found.0.settle();
            }
            Ok::<_, Error>(found)
        };
        if let &Sought::Reward(structure, target) = self {
            program.of_one_player("a reward until a target")?;
            let (goal, infinite) = (Extremes::all(optimum), outside(self.needed(optimum)[0])?);
            let (arena, numbers) = reached(&engine.union(target, &infinite)?)?;
            let until = Accumulation::Until(arena.members(engine, target)?);
            let rewards = arena.rewards(engine, structure)?;
            return Ok(Some(Box::new(move |precision| {
                let asked = Asked::all(&arena, goal, precision);
                Asked { states: Some(&numbers), ..asked }.reward(&rewards, &until)
            })));
        }
        let (goal, is_negated) = match (engine.is_game(), self.is_safe()) {
            (true, None) => return Ok(None),
            (true, Some(true)) => (Extremes::against(optimum).opposite(), true),
            (true, Some(false)) => (Extremes::against(optimum), false),
            (false, _) => (Extremes::all(Optimum::Max), optimum == Optimum::Min),
        };
        let [positive, one] = self.needed(optimum) else { return Ok(None) };
        let (zero, one) = (outside(*positive)?, regions.known(*one)?);
        let (arena, numbers) = reached(&engine.union(&zero, one)?)?;
        let (zero, one) = (arena.members(engine, &zero)?, arena.members(engine, one)?);
        let (end, lost) = if is_negated { (zero, one) } else { (one, zero) };
        let until = Until::unbounded(!lost, end);
        Ok(Some(Box::new(move |precision| {
            let asked = Asked::all(&arena, goal, precision);
            let mut found = Asked { states: Some(&numbers), ..asked }.probability(&until)?;
            if is_negated {
                found.values.iter_mut().for_each(Value::complement);
            }
            Ok(found)
        })))
    }
}
