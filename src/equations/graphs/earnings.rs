//! The rewards of the choices of an arena.

use ahash::AHashMap;
use meliora_base::error::Result;
use meliora_engine::Engine;
use meliora_model::predicate::Predicate;
use meliora_model::rewards::{Earner, RewardStructure};
use meliora_model::step::Combination;
use meliora_model::{ModelKind, Program, State, VarId, fault};
use meliora_space::enabled::MOST;
use meliora_space::weighted::{Fractions, Walk, Walker};
use smallvec::SmallVec;

use super::arena::Arena;
use super::game_graph::Rewards;
use super::source::drawn;

/// Checks the rewards of a structure in all states of the scope; the error names one of the wrong
/// ones. `wrong` is `Program::wrong_rewards` of the program.
///
/// # Errors
/// A reward is negative or has no value in some state; a limit is reached.
pub fn check_rewards<E: Engine>(
    engine: &E,
    program: &Program,
    structure: &RewardStructure,
    wrong: &Predicate,
) -> Result<()> {
    let examples = engine.list_states(&engine.states_where(wrong)?, 1)?;
    let Some(state) = examples.first() else { return Ok(()) };
    let choices = program.choices(state).map_err(|f| fault::error(program, &f, state))?;
    choices.iter().try_for_each(|(choice, _)| program.reward(structure, state, choice).map(|_| ()))
}

/// The commands of a state, and the values of the variables that rewards depend on.
type Key = (u32, SmallVec<[i64; 4]>);

/// The numbers of the rewards of a state, and of its choices; none if all choices earn as much as the state.
struct Earned {
    of_state: u32,
    of_choices: Vec<u32>,
}

/// The rewards of the choices of an arena, one state after the other. States with the same commands in which the variables that
/// rewards depend on have the same values have the same rewards.
pub(super) struct Earnings<'a> {
    arena: &'a Arena<'a>,
    structure: &'a RewardStructure,
    by_state: bool,
    /// Lists the choices by the guards that hold, if that is needed.
    walk: Option<Box<dyn Walk + 'a>>,
    /// The variables that rewards depend on, besides the commands.
    variables: Vec<VarId>,
    /// The rewards found so far, up to [`MOST`].
    known: AHashMap<Key, Earned>,
}

impl<'a> Earnings<'a> {
    /// Returns the walker that [`Earnings::new`] needs, unless the engine keeps the choices by their commands.
    ///
    /// # Errors
    /// The work is cancelled.
    pub(super) fn walker(arena: &Arena<'a>, structure: &RewardStructure) -> Result<Option<Walker<'a>>> {
        let is_known = is_by_state(structure) || arena.kept_choices().is_some();
        (!is_known).then(|| Walker::new(arena.program, &*arena.sink)).transpose()
    }

    /// Prepares the states of an arena.
    pub(super) fn new(
        arena: &'a Arena<'a>,
        structure: &'a RewardStructure,
        walker: Option<&'a Walker<'a>>,
    ) -> Self {
        let pool = &arena.program.pool;
        let read = structure.items.iter().flat_map(|item| [item.guard, item.value]);
        let mut variables: Vec<VarId> = read.flat_map(|id| pool.support(id)).collect();
        variables.sort_unstable();
        variables.dedup();
        let (by_state, walk) = (is_by_state(structure), walker.map(Walker::walk));
        Earnings { arena, structure, by_state, walk, variables, known: AHashMap::new() }
    }

    /// Adds the rewards of the next state and of its choices.
    ///
    /// # Errors
    /// A reward, a guard or a probability has no value in the state.
    pub(super) fn add(&mut self, number: usize, state: &State, rewards: &mut Rewards) -> Result<()> {
        let positions = self.arena.choices.of(number as u32).map(|choice| self.arena.position(choice));
        let push = |earned: &Earned| {
            rewards.of_state.push(earned.of_state);
            let of_choice = |at| earned.of_choices.get(at).copied().unwrap_or(earned.of_state);
            positions.for_each(|at| rewards.of_choice.push(of_choice(at)));
        };
        let list = match &mut self.walk {
            _ if self.by_state => Some(0),
            Some(walk) => {
                walk.enable(self.arena.code(number))?;
                walk.list()
            }
            None => self.arena.list(number),
        };
        let values = || self.variables.iter().map(|variable| state[variable.index()]).collect();
        let key = list.map(|list| (list, values()));
        if let Some(known) = key.as_ref().and_then(|key| self.known.get(key)) {
            push(known);
            return Ok(());
        }
        let earned = self.computed(list, state, &mut rewards.fractions)?;
        push(&earned);
        if let Some(key) = key.filter(|_| self.known.len() < MOST) {
            self.known.insert(key, earned);
        }
        Ok(())
    }

    /// Returns the rewards of a state and its choices, which have this list if the engine keeps them.
    fn computed(&self, list: Option<u32>, state: &State, fractions: &mut Fractions) -> Result<Earned> {
        let (arena, program) = (self.arena, self.arena.program);
        let mut reward = |combinations: &[Combination]| {
            let reward = program.signed_reward_of(self.structure, state, combinations)?;
            Ok(fractions.number(reward))
        };
        let of_state = reward(&[])?;
        let all = match &self.walk {
            _ if self.by_state => return Ok(Earned { of_state, of_choices: Vec::new() }),
            Some(walk) => walk.combinations(),
            None => {
                let kept = arena.kept_choices().zip(list);
                kept.map_or_else(Vec::new, |(kept, list)| kept.combinations(program, list))
            }
        };
        let count = if program.kind == ModelKind::Dtmc { 1 } else { all.len() };
        let of_choices = (0..count).map(|at| reward(drawn(program, &all, at))).collect::<Result<_>>()?;
        Ok(Earned { of_state, of_choices })
    }
}

/// Returns whether all choices of a state earn the same.
fn is_by_state(structure: &RewardStructure) -> bool {
    structure.items.iter().all(|item| item.earner == Earner::State)
}
