//! The number that one operator asks for in some states: the probability of a formula, or a reward until a target.

use crate::answers::path_values::{Answer, Paths, Value, Wanted};
use crate::answers::vector::{self, Accumulation, Until};
use crate::equations::arena::{Arena, Extremes};
use crate::equations::cost::{Earned, check_rewards};
use meliora_base::error::{Limit, Result};
use meliora_engine::Engine;
use meliora_engine::regions::{Regions, Which};
use meliora_model::temporal::{Asks, Condition};
use meliora_model::{Optimum, Program, State};

/// Maximum number of states with values.
pub const MOST_STATES: usize = 1 << 20;

/// Returns the limit of [`MOST_STATES`], which no setting raises.
pub fn too_many_states() -> Limit {
    Limit::Size { what: format!("more than {MOST_STATES} states to list") }
}

/// A number that is sought.
pub enum Sought<'a, S> {
    /// The probability of the formula that the regions belong to. A formula with monitors has a condition on them.
    Probability(Option<&'a Condition>),
    /// The reward of the structure with this number until a state of the target is reached.
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
    /// and the opponent looks for the other one. `None` if such a number of a game is not supported: the formula is neither
    /// safe nor co-safe.
    ///
    /// Cost: that of [`Paths::explore`]; of a game, that of [`Arena::reached`].
    ///
    /// # Errors
    /// A limit is reached, or a reward is wrong.
    pub fn prepare<'e, E: Engine<States = S>>(
        &self,
        (engine, program): (&'e E, &'e Program),
        optimum: Optimum,
        regions: &Regions<Option<S>>,
        states: &[State],
    ) -> Result<Option<Compute<'e>>>
    where
        S: Clone + 'e,
    {
        if engine.is_game() {
            return match self.is_safe() {
                None => Ok(None),
                Some(is_safe) => {
                    self.in_game((engine, program), (optimum, is_safe), regions, states).map(Some)
                }
            };
        }
        if states.len() > MOST_STATES {
            return Err(too_many_states().into());
        }
        let wanted = match self {
            Sought::Probability(_) => Wanted::Probability,
            Sought::Reward(structure, target) => {
                let items = &program.rewards[*structure];
                check_rewards(engine, program, items, &program.wrong_rewards(*structure))?;
                Wanted::Reward(Earned { program, structure: items }, *target)
            }
        };
        let mut paths = Paths::explore(engine, program, (&wanted, optimum), regions, states)?;
        Ok(Some(Box::new(move |precision| narrow(&mut paths, precision))))
    }

    fn in_game<'e, E: Engine<States = S>>(
        &self,
        (engine, program): (&'e E, &'e Program),
        (optimum, is_safe): (Optimum, bool),
        regions: &Regions<Option<S>>,
        states: &[State],
    ) -> Result<Compute<'e>> {
        let goal = Extremes::against(optimum);
        let reached = |stops: &E::States| Arena::reached(engine, program, states, stops);
        let of = |numbers: Vec<usize>| move |found: Answer| found.selected(&numbers);
        if let Sought::Reward(structure, target) = self {
            let (arena, numbers) = reached(target)?;
            let until = Accumulation::Until(arena.members(engine, target)?);
            let (rewards, selected) = (arena.rewards(engine, *structure)?, of(numbers));
            return Ok(Box::new(move |precision| {
                vector::reward(&arena, &rewards, &until, goal, precision).map(&selected)
            }));
        }
        let needed = self.needed(optimum);
        let (positive, one) = (regions.known(needed[0])?, regions.known(needed[1])?);
        let zero = engine.difference(&engine.all_states(), positive)?;
        let (arena, numbers) = reached(&engine.union(&zero, one)?)?;
        let (zero, one) = (arena.members(engine, &zero)?, arena.members(engine, one)?);
        let selected = of(numbers);
        if !is_safe {
            // The value is the probability to reach the states in which it is 1.
            let until = Until::unbounded(!zero, one);
            return Ok(Box::new(move |precision| {
                vector::probability(&arena, &until, goal, precision).map(&selected)
            }));
        }
        // 1 minus the value of reaching the states in which it is 0: whoever stays elsewhere satisfies it.
        let until = Until::unbounded(!one, zero);
        Ok(Box::new(move |precision| {
            let mut found = vector::probability(&arena, &until, goal.opposite(), precision)?;
            found.values.iter_mut().for_each(Value::complement);
            Ok(selected(found))
        }))
    }
}

/// Computes values, with fractions where the bounds are wider than the precision. The values of several states may be far
/// apart; each has narrow bounds of its own.
fn narrow(paths: &mut Paths<'_>, precision: f64) -> Result<Answer> {
    let found = paths.values(precision <= 0.0)?;
    let width = |value: &Value| value.interval().width() / value.interval().lower.max(1.0);
    if precision <= 0.0 || found.end.is_err() || found.values.iter().all(|value| width(value) <= precision) {
        return Ok(found);
    }
    match paths.values(true).and_then(|exact| exact.end.map(|()| exact.values)) {
        Ok(values) => Ok(Answer { values, end: Ok(()) }),
        Err(e) => Ok(Answer { end: Err(e), ..found }),
    }
}
