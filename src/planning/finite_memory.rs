//! What is to be done when: the strategies of all levels, and the memory that leads from one to the
//! next.
//!
//! At a state of rank k a play starts with the strategy of level k (at an unbounded rank with that of
//! the fixpoint). What happens then is measured against the state before or, under `prefix`, against
//! the reference class:
//!
//! - A step that improves and enters W_{k-1}, or leaves the level behind, is an *improvement*: the
//!   play goes on with the own rank of the state it enters, which becomes the new reference. This
//!   rank is at least k-1 where the step was a goal edge, so nothing promised is lost by it, and
//!   luck is not wasted.
//! - A step that stays in the level's winning states changes nothing, an improving one included that
//!   enters no state of W_{k-1} (under `prefix` only): it is no goal of the level, and the promise
//!   still stands with the old reference.
//! - Any other step is bad luck, or a dropped branch that the real system took: the play goes on
//!   with the greatest level that still has the state, with the old reference.
//!
//! Level 0 has nothing to improve: a play ends there.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::classes::Classes;
use super::improvement::{Arena, Improvement};
use super::levels::{Game, Kind, Level, Levels, Rank};
use super::strategy::{self, Strategy};
use crate::engine::Engine;
use crate::error::Result;
use crate::held::Held;
use crate::model::Program;
use crate::model::preference::{Change, ObjectiveSet, Preferences};

/// What a play remembers besides its state.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Memory {
    /// The level that is played; at `Finite(0)` the play ends.
    pub level: Rank,
    /// In which arena, by its position in [`Improvement::arenas`]. None where nothing is safe.
    pub arena: Option<usize>,
}

/// The strategies of one kind, computed as they are asked for.
pub struct FiniteMemoryStrategy<'a, E: Engine> {
    pub(super) engine: Held<'a, E>,
    pub(super) program: Held<'a, Program>,
    pub(super) preferences: Held<'a, Preferences>,
    pub(super) classes: Arc<Classes<E>>,
    pub(super) improvement: Arc<Improvement<E>>,
    pub(super) levels: Arc<Levels<E>>,
    /// By level (see [`key`]) and arena.
    strategies: BTreeMap<(usize, usize), Strategy<E>>,
}

impl<'a, E: Engine> FiniteMemoryStrategy<'a, E> {
    /// A playbook without a strategy yet.
    pub(super) fn of(
        (engine, preferences): (Held<'a, E>, Held<'a, Preferences>),
        program: Held<'a, Program>,
        classes: Arc<Classes<E>>,
        improvement: Arc<Improvement<E>>,
        levels: Arc<Levels<E>>,
    ) -> Self {
        let strategies = BTreeMap::new();
        FiniteMemoryStrategy { engine, program, preferences, classes, improvement, levels, strategies }
    }

    /// Which kind of strategies.
    pub fn kind(&self) -> Kind {
        self.levels.kind
    }

    /// The preferences.
    pub fn preferences(&self) -> &Preferences {
        &self.preferences
    }

    /// The program.
    pub fn program(&self) -> &Program {
        &self.program
    }

    /// s ∈ S
    pub fn is_state(&self, state: &[i64]) -> bool {
        self.engine.contains(&self.engine.all_states(), state)
    }

    /// MP(s); empty outside the scope.
    pub fn most_preferred(&self, state: &[i64]) -> ObjectiveSet {
        let class = self.classes.of(&*self.engine, state);
        class.map_or_else(ObjectiveSet::new, |c| self.classes.list[c].most_preferred.clone())
    }

    /// rank(s) = max { k : s ∈ W_k }; see [`Levels::rank`].
    pub fn rank(&self, state: &[i64]) -> Rank {
        self.levels.rank(&*self.engine, state)
    }

    /// { s : rank(s) = k }, where `None` stands for the unbounded rank.
    ///
    /// # Errors
    /// A limit of the engine. Cost: no image.
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

    /// The memory with which planning starts in a state: its own rank and, under `prefix`, its own class as
    /// the reference.
    pub fn start(&self, state: &[i64]) -> Memory {
        let class = self.classes.of(&*self.engine, state);
        let starts_in = |arena: &Arena<E>| arena.reference.is_none() || arena.reference == class;
        Memory { level: self.rank(state), arena: self.improvement.arenas.iter().position(starts_in) }
    }

    /// The memory after a step, and whether the step was an improvement; see the module's text.
    pub fn after(&self, memory: Memory, from: &[i64], to: &[i64]) -> (Memory, bool) {
        let improves = self.change(memory, from, to) == Change::Improving;
        match self.game(memory) {
            Some(game) => {
                let stays = self.engine.contains(&game.states, to);
                let goal = improves && strategy::is_goal(&*self.engine, game, from, to);
                match (goal, stays, improves) {
                    (true, _, _) | (_, false, true) => (self.start(to), true),
                    (false, true, _) => (memory, false),
                    (false, false, false) => (self.resume(memory, to), false),
                }
            }
            None => (self.start(to), improves),
        }
    }

    /// The greatest level that still has a state, with the old reference.
    fn resume(&self, memory: Memory, state: &[i64]) -> Memory {
        let Some(arena) = memory.arena else { return self.start(state) };
        let holds = |level: &Level<E>| {
            level.games.get(arena).is_some_and(|game| self.engine.contains(&game.states, state))
        };
        // The fixpoint lies in every level, so it does not have what another level has lost.
        let level = Rank::Finite(self.levels.found.iter().take_while(|level| holds(level)).count());
        Memory { level, arena: Some(arena) }
    }

    /// What the steps of a play are measured against: MP of the reference class under `prefix`, else MP(s).
    pub fn reference(&self, memory: Memory, state: &[i64]) -> ObjectiveSet {
        let class = self.arena(memory).and_then(|arena| self.classes.list.get(arena.reference?));
        class.map_or_else(|| self.most_preferred(state), |class| class.most_preferred.clone())
    }

    /// What a step is, measured against [`FiniteMemoryStrategy::reference`].
    fn change(&self, memory: Memory, from: &[i64], to: &[i64]) -> Change {
        self.preferences.change(&self.reference(memory, from), &self.most_preferred(to))
    }

    /// The arena of a memory.
    pub(super) fn arena(&self, memory: Memory) -> Option<&Arena<E>> {
        self.improvement.arenas.get(memory.arena?)
    }

    /// The game of a memory; none where nothing can be improved.
    pub(super) fn game(&self, memory: Memory) -> Option<&Game<E>> {
        self.levels.level(memory.level)?.games.get(memory.arena?)
    }

    /// Whether [`FiniteMemoryStrategy::strategy`] has nothing left to compute for a memory.
    pub fn knows(&self, memory: Memory) -> bool {
        let Some(index) = memory.arena else { return true };
        self.game(memory).is_none() || self.strategies.contains_key(&(key(memory.level), index))
    }

    /// The strategies of a memory; none where nothing can be improved.
    ///
    /// # Errors
    /// A limit of the engine. Cost: that of [`strategy::strategy`] once a level and arena.
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

/// A level as a key: the fixpoint comes after all numbers.
fn key(level: Rank) -> usize {
    match level {
        Rank::Finite(k) | Rank::AtLeast(k) => k,
        Rank::Unbounded => usize::MAX,
    }
}
