//! Finite-memory strategies: the strategies of all levels, and the memory that selects one of them.
//!
//! A run that starts in a state of rank k follows the strategy of level k (for an unbounded rank,
//! the strategy of the fixpoint). Each step is compared with the state before it or, under
//! `prefix`, with the reference class:
//!
//! - An improving step that enters W_{k-1} or leaves the level's winning states is an
//!   *improvement*: the run continues with the rank of the entered state, which becomes the new
//!   reference. After a goal edge this rank is at least k-1, so no guaranteed improvement is lost,
//!   and a higher rank reached by chance is used.
//! - A step that stays in the level's winning states changes nothing. This includes an improving
//!   step that does not enter W_{k-1}, which occurs under `prefix` only: it is not a goal edge of
//!   the level, and the guarantee continues with the old reference.
//! - Any other step is an unfavourable branch, or a dropped branch that the real system took: the
//!   run continues with the greatest level that still contains the state, with the old reference.
//!
//! Level 0 has nothing to improve: a run ends there.
//!
//! With a [`DecisionRule`], the rule takes the choices. The level is the number of improvements that
//! it still aims at. After the last of them, planning starts again. A lost step ends the run.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::classes::Classes;
use super::decision_rule::DecisionRule;
use super::improvement::{Arena, Improvement};
use super::levels::{Game, Kind, Level, Levels, Rank};
use super::strategy::{self, Strategy};
use crate::engine::{AnyEngine, Engine, position};
use crate::error::{Error, Result};
use crate::model::Program;
use crate::model::preference::{Change, ObjectiveSet, Preferences};

/// The memory of a strategy: the information that a run carries in addition to its state.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Memory {
    /// The current level; at `Finite(0)` the run ends.
    pub level: Rank,
    /// The current arena, by its position in [`Improvement::arenas`]; `None` if the class has no
    /// safe state.
    pub arena: Option<usize>,
}

/// The strategies of one kind, computed on demand.
pub struct FiniteMemoryStrategy<E: Engine = AnyEngine> {
    /// The engine of the model as it is written.
    pub(super) whole: Arc<E>,
    pub(super) engine: Arc<E>,
    pub(super) program: Arc<Program>,
    pub(super) preferences: Arc<Preferences>,
    pub(super) classes: Arc<Classes<E>>,
    pub(super) improvement: Arc<Improvement<E>>,
    pub(super) levels: Arc<Levels<E>>,
    /// The strategies by level (see [`key`]) and arena.
    pub(super) strategies: BTreeMap<(usize, usize), Strategy<E>>,
    /// The rule that takes the choices; without one, the first that makes progress is taken.
    pub(super) rule: Option<Arc<dyn DecisionRule>>,
}

impl<E: Engine> FiniteMemoryStrategy<E> {
    /// Lets a rule take the choices.
    pub fn choose_by(&mut self, rule: Arc<dyn DecisionRule>) {
        self.rule = Some(rule);
    }

    /// Returns the kind of strategies.
    pub fn kind(&self) -> Kind {
        self.levels.kind
    }

    /// Returns the preferences.
    pub fn preferences(&self) -> &Preferences {
        &self.preferences
    }

    /// Returns the program.
    pub fn program(&self) -> &Program {
        &self.program
    }

    /// Returns whether s ∈ S, unsafe states included.
    ///
    /// # Errors
    /// The errors of [`Engine::contains`].
    pub fn is_state(&self, state: &[i64]) -> Result<bool> {
        self.whole.contains(&self.whole.all_states(), state)
    }

    /// Returns MP(s); empty outside the scope.
    ///
    /// # Errors
    /// The errors of [`Engine::contains`].
    pub fn most_preferred(&self, state: &[i64]) -> Result<ObjectiveSet> {
        self.classes.most_preferred(&*self.engine, state)
    }

    /// Returns whether no strategy keeps the requirements from a state of the scope: the state
    /// belongs to no class.
    ///
    /// # Errors
    /// The errors of [`Engine::contains`].
    pub fn is_unsafe(&self, state: &[i64]) -> Result<bool> {
        Ok(self.classes.of(&*self.engine, state)?.is_none())
    }

    /// Returns rank(s) = max { k : s ∈ W_k }; see [`Levels::rank`].
    ///
    /// # Errors
    /// The errors of [`Engine::contains`].
    pub fn rank(&self, state: &[i64]) -> Result<Rank> {
        self.levels.rank(&*self.engine, state)
    }

    /// Returns { s : rank(s) = k }, where `None` stands for the unbounded rank. Cost: no image.
    ///
    /// # Errors
    /// A limit of the engine is reached.
    pub fn states_of_rank(&self, rank: Option<usize>) -> Result<E::States> {
        let none = self.engine.no_states();
        let fixpoint = self.levels.unbounded().map_or(&none, |level| &level.states);
        let Some(k) = rank else { return Ok(fixpoint.clone()) };
        let all = self.engine.all_states();
        let at_least = match k.checked_sub(1) {
            None => &all,
            Some(index) => self.levels.found.get(index).map_or(&none, |level| &level.states),
        };
        let above = self.levels.found.get(k).map_or(fixpoint, |level| &level.states);
        self.engine.difference(at_least, above)
    }

    /// Returns the memory with which planning starts in a state: its own rank and, under `prefix`,
    /// its own class as the reference. With a decision rule, the level is that of the rule.
    ///
    /// # Errors
    /// The errors of [`Engine::contains`]; [`Error::Usage`] if the rule does not know the state.
    pub fn start(&self, state: &[i64]) -> Result<Memory> {
        let class = self.classes.of(&*self.engine, state)?;
        let starts_in = |arena: &Arena<E>| arena.reference.is_none() || arena.reference == class;
        let arena = self.improvement.arenas.iter().position(starts_in);
        let level = match &self.rule {
            None => self.rank(state)?,
            Some(rule) => Rank::Finite(rule.level(arena, state).ok_or_else(|| self.unknown(state))?),
        };
        Ok(Memory { level, arena })
    }

    fn unknown(&self, state: &[i64]) -> Error {
        let state = self.program.show_state(state);
        Error::Usage(format!("the values of the state {state} were not computed"))
    }

    /// Returns the memory after a step, and whether the step was an improvement; see the module
    /// documentation.
    ///
    /// # Errors
    /// The errors of [`Engine::contains`].
    pub fn after(&self, memory: Memory, from: &[i64], to: &[i64]) -> Result<(Memory, bool)> {
        let improves = self.change(memory, from, to)? == Change::Improving;
        if let Some(rule) = &self.rule {
            return self.after_by(&**rule, memory, (from, to), improves);
        }
        let Some(game) = self.game(memory) else { return Ok((self.start(to)?, improves)) };
        let stays = self.engine.contains(&game.states, to)?;
        let goal = improves && strategy::is_goal(&*self.engine, game, from, to)?;
        Ok(match (goal, stays, improves) {
            (true, _, _) | (_, false, true) => (self.start(to)?, true),
            (false, true, _) => (memory, false),
            (false, false, false) => (self.resume(memory, to)?, false),
        })
    }

    /// Returns what [`FiniteMemoryStrategy::after`] returns under a decision rule.
    fn after_by(
        &self,
        rule: &dyn DecisionRule,
        memory: Memory,
        (from, to): (&[i64], &[i64]),
        improves: bool,
    ) -> Result<(Memory, bool)> {
        Ok(match rule.after(memory, from, to) {
            None => (Memory { level: Rank::Finite(0), ..memory }, improves),
            Some((0, true)) => (self.start(to)?, true),
            Some((level, true)) => (Memory { level: Rank::Finite(level), ..self.start(to)? }, true),
            Some((level, false)) => (Memory { level: Rank::Finite(level), ..memory }, false),
        })
    }

    /// Returns the memory with the greatest level that still contains a state, with the old
    /// reference.
    fn resume(&self, memory: Memory, state: &[i64]) -> Result<Memory> {
        let Some(arena) = memory.arena else { return self.start(state) };
        let lacks = |level: &Level<E>| match level.games.get(arena) {
            Some(game) => Ok(!self.engine.contains(&game.states, state)?),
            None => Ok(true),
        };
        // The fixpoint is a subset of every level, so it does not contain a state that is not in
        // some level.
        let found = &self.levels.found;
        let level = Rank::Finite(position(found, lacks)?.unwrap_or(found.len()));
        Ok(Memory { level, arena: Some(arena) })
    }

    /// Returns the objectives that steps are compared with: MP of the reference class under
    /// `prefix`, else MP(s).
    ///
    /// # Errors
    /// The errors of [`Engine::contains`].
    pub fn reference(&self, memory: Memory, state: &[i64]) -> Result<ObjectiveSet> {
        let class = self.arena(memory).and_then(|arena| self.classes.list.get(arena.reference?));
        class.map_or_else(|| self.most_preferred(state), |class| Ok(class.most_preferred.clone()))
    }

    /// Returns the effect of a step, compared with [`FiniteMemoryStrategy::reference`].
    fn change(&self, memory: Memory, from: &[i64], to: &[i64]) -> Result<Change> {
        Ok(self.preferences.change(&self.reference(memory, from)?, &self.most_preferred(to)?))
    }

    /// Returns the arena of a memory.
    pub(super) fn arena(&self, memory: Memory) -> Option<&Arena<E>> {
        self.improvement.arenas.get(memory.arena?)
    }

    /// Returns the game of a memory; `None` if nothing can be improved.
    pub(super) fn game(&self, memory: Memory) -> Option<&Game<E>> {
        self.levels.level(memory.level)?.games.get(memory.arena?)
    }

    /// Returns whether [`FiniteMemoryStrategy::strategy`] needs no computation for a memory.
    pub fn knows(&self, memory: Memory) -> bool {
        let Some(index) = memory.arena else { return true };
        self.game(memory).is_none() || self.strategies.contains_key(&(key(memory.level), index))
    }

    /// Returns the names of the permitted actions of a start state.
    ///
    /// # Errors
    /// The errors of [`FiniteMemoryStrategy::explain`].
    pub fn permitted(&mut self, state: &[i64]) -> Result<Vec<String>> {
        let memory = self.start(state)?;
        let actions = self.explain(state, memory)?.actions;
        Ok(actions.into_iter().filter(|action| action.permitted).map(|action| action.name).collect())
    }

    /// Returns the strategies of a memory; `None` if nothing can be improved. Cost: that of
    /// [`strategy::strategy`], once per level and arena.
    ///
    /// # Errors
    /// A limit of the engine is reached.
    pub fn strategy(&mut self, memory: Memory) -> Result<Option<&Strategy<E>>> {
        let (Some(arena), Some(game), Some(index)) = (self.arena(memory), self.game(memory), memory.arena)
        else {
            return Ok(None);
        };
        let key = (key(memory.level), index);
        if !self.strategies.contains_key(&key) {
            let found = strategy::strategy(&*self.engine, self.levels.kind, arena, game)?;
            self.strategies.insert(key, found);
        }
        Ok(self.strategies.get(&key))
    }
}

/// Returns a level as a key: the fixpoint comes after all numbers.
fn key(level: Rank) -> usize {
    match level {
        Rank::Finite(k) | Rank::AtLeast(k) => k,
        Rank::Unbounded => usize::MAX,
    }
}
