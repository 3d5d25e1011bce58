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
//! Level 0 has nothing to improve: a run ends there. An episode under a shield can continue; it
//! keeps its reference until an improvement.
//!
//! A *plan* continues at level 0: it achieves a most preferred objective of the state, with the
//! strategies of `achieve`. It takes the first one that kept choices achieve almost surely, and then
//! takes only kept choices: no step weakens. If there is none, it *commits* to the first one: it
//! takes all choices with which this objective stays sure, and gives up the others where they are
//! lost. It stays with its objective, even where more improvements become possible, because it could
//! otherwise alternate between objectives forever. When an objective that is preferred to it becomes
//! certain, the plan pursues that one. A strategy of the kind `achieve` does nothing else from the
//! beginning.
//!
//! While kept choices are taken, the reference is that of the improvements: under `prefix`, the last
//! improvement or the start. After a commitment, each step is compared with the state before it.
//!
//! With a decision rule, the rule takes the choices. The level is the number of improvements that
//! it still aims at. After the last of them, planning starts again. A lost step ends the run.

use std::collections::BTreeMap;
use std::fmt;
use std::sync::Arc;

use super::achieve::Achieving;
pub use super::achieve::{Manner, Pursuit};
use super::decision_rule::DecisionRule;
use super::standing::Standings;
use super::strategy::{self, ArenaStrategy};
use crate::analysis::classes::Classes;
use crate::analysis::improvement::{Arena, Improvement};
use crate::analysis::levels::{Game, Kind, Level, Levels, Rank};
use meliora_base::error::{Error, Result};
use meliora_base::slip;
use meliora_engine::{AnyEngine, Engine};
use meliora_model::Program;
use meliora_model::preference::{Change, ObjectiveSet, Preferences};

/// The memory of a strategy: the information that a run carries in addition to its state.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Memory {
    /// The current level; at `Finite(0)` the run ends.
    pub level: Rank,
    /// The current arena, by its position in [`Improvement::arenas`]; `None` if the class has no
    /// safe state, and in unsafe states.
    pub arena: Option<usize>,
    /// The objective that is pursued at level 0, if the strategy achieves objectives.
    pub pursuit: Option<Pursuit>,
}

/// A step of a run from a state to another one.
#[derive(Clone, Copy)]
pub(crate) struct Step<'s> {
    pub(crate) from: &'s [i64],
    pub(crate) to: &'s [i64],
    /// True if it improves the reference.
    pub(crate) improves: bool,
}

meliora_base::named! {
    /// The kind of a strategy.
    pub enum StrategyKind {
        /// Make improvements that are almost sure.
        Sasi,
        /// Make improvements that are possible.
        Spi,
        /// Make the improvements that are almost sure (with `--choose likely`: possible), then achieve a
        /// most preferred objective.
        Plan,
        /// Achieve one objective almost surely, or several together.
        Achieve,
    }
}

impl StrategyKind {
    /// Returns the kind of the improvements that ranks count, unless a plan chooses by value.
    pub fn levels(self) -> Kind {
        match self {
            StrategyKind::Spi => Kind::Spi,
            StrategyKind::Sasi | StrategyKind::Plan | StrategyKind::Achieve => Kind::Sasi,
        }
    }

    /// Returns whether strategies of this kind achieve objectives.
    pub fn achieves(self) -> bool {
        matches!(self, StrategyKind::Plan | StrategyKind::Achieve)
    }

    /// Returns the objectives that a strategy of this kind is to achieve, by their names: `C`, or `C,D`
    /// for objectives that are to be achieved together.
    ///
    /// # Errors
    /// [`Error::Usage`] if the objective does not exist, if the kind needs one, or if it does not achieve
    /// any or several.
    pub fn objectives(self, preferences: &Preferences, names: Option<&str>) -> Result<ObjectiveSet> {
        let objectives = &preferences.objectives;
        let known = || objectives.iter().map(|o| o.name.as_str()).collect::<Vec<_>>().join(", ");
        let Some(names) = names else {
            return match self {
                StrategyKind::Achieve => {
                    Err(Error::Usage(format!("the kind `achieve` needs an objective; there are {}", known())))
                }
                _ => Ok(ObjectiveSet::new()),
            };
        };
        if !self.achieves() {
            let name = self.name();
            return Err(Error::Usage(format!(
                "the kind `{name}` takes no objective; `plan` and `achieve` do"
            )));
        }
        let position = |name: &str| {
            let found = objectives.iter().position(|o| o.name == name);
            found.ok_or_else(|| {
                let advice = match slip::meant(objectives.iter().map(|o| o.name.as_str()), name) {
                    Some(meant) => format!("did you mean `{meant}`?"),
                    None => format!("there are {}", known()),
                };
                Error::Usage(format!("no objective is called `{name}`; {advice}"))
            })
        };
        let found = names.split(',').map(|name| position(name.trim())).collect::<Result<ObjectiveSet>>()?;
        self.check(&found)?;
        Ok(found)
    }

    /// Refuses several objectives unless they are achieved together.
    pub(crate) fn check(self, objectives: &ObjectiveSet) -> Result<()> {
        if objectives.len() < 2 || self == StrategyKind::Achieve {
            return Ok(());
        }
        let name = self.name();
        Err(Error::Usage(format!(
            "the kind `{name}` takes one objective; `achieve` achieves several together"
        )))
    }
}

impl From<Kind> for StrategyKind {
    fn from(kind: Kind) -> Self {
        match kind {
            Kind::Sasi => StrategyKind::Sasi,
            Kind::Spi => StrategyKind::Spi,
        }
    }
}

impl fmt::Display for StrategyKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            StrategyKind::Sasi | StrategyKind::Spi => self.levels().fmt(f),
            StrategyKind::Plan | StrategyKind::Achieve => f.write_str(self.name()),
        }
    }
}

/// The strategies of one kind, computed on demand.
pub struct FiniteMemoryStrategy<E: Engine = AnyEngine> {
    /// The engine of the model as it is written.
    pub(crate) whole: Arc<E>,
    pub(crate) engine: Arc<E>,
    pub(crate) program: Arc<Program>,
    pub(crate) preferences: Arc<Preferences>,
    pub(crate) classes: Arc<Classes<E>>,
    pub(crate) improvement: Arc<Improvement<E>>,
    pub(crate) levels: Arc<Levels<E>>,
    /// The strategies by level (see [`key`]) and arena.
    pub(crate) strategies: BTreeMap<(usize, usize), ArenaStrategy<E>>,
    /// The rule that takes the choices; without one, the first that makes progress is taken.
    pub(crate) rule: Option<Arc<dyn DecisionRule>>,
    pub(crate) kind: StrategyKind,
    /// The strategies that achieve objectives, if this one does.
    pub(crate) achieving: Option<Achieving<E>>,
    /// The objectives to achieve together; a plan pursues one where it is a most preferred one.
    pub(crate) objectives: ObjectiveSet,
    /// The class and the rank of states, while they are remembered.
    pub(crate) standings: Option<Standings>,
}

impl<E: Engine> FiniteMemoryStrategy<E> {
    /// Lets a rule take the choices.
    pub fn choose_by(&mut self, rule: Arc<dyn DecisionRule>) {
        self.rule = Some(rule);
    }

    /// Returns the kind of the strategy.
    pub fn kind(&self) -> StrategyKind {
        self.kind
    }

    /// Returns the kind of improvements that the strategy makes.
    pub fn levels(&self) -> Kind {
        self.levels.kind
    }

    /// Returns the objectives that were named.
    pub fn objectives(&self) -> &ObjectiveSet {
        &self.objectives
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

    /// Returns { s : rank(s) = k }, where `None` stands for the unbounded rank. Cost: no image.
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
    /// its own class as the reference. With a decision rule, the level is that of the rule. At level 0,
    /// a strategy that achieves objectives begins to pursue one.
    ///
    /// # Errors
    /// The errors of [`Engine::contains`]; [`Error::Usage`] if the rule does not know the state.
    pub fn start(&self, state: &[i64]) -> Result<Memory> {
        let memory = match self.kind {
            StrategyKind::Achieve => {
                let memory = self.at_rest(state)?;
                // An unsafe state has no values.
                let unknown = |rule: &dyn DecisionRule| rule.level(memory.arena, state).is_none();
                if self.rule.as_deref().is_some_and(unknown) && !self.is_unsafe(state)? {
                    return Err(self.unknown(state));
                }
                memory
            }
            StrategyKind::Sasi | StrategyKind::Spi | StrategyKind::Plan => self.improving(state)?,
        };
        self.pursuing(memory, state)
    }

    /// Returns the memory at level 0 with a state as the reference.
    pub(crate) fn at_rest(&self, state: &[i64]) -> Result<Memory> {
        let arena = self.improvement.arena_of(self.class_of(state)?);
        Ok(Memory { level: Rank::Finite(0), arena, pursuit: None })
    }

    /// Returns the memory with which improving starts in a state.
    fn improving(&self, state: &[i64]) -> Result<Memory> {
        let Memory { arena, .. } = self.at_rest(state)?;
        let level = match &self.rule {
            None => self.rank(state)?,
            // Nothing can be improved, and an unsafe state has no values.
            Some(_) if arena.is_none() => Rank::Finite(0),
            Some(rule) => Rank::Finite(rule.level(arena, state).ok_or_else(|| self.unknown(state))?),
        };
        Ok(Memory { level, arena, pursuit: None })
    }

    fn unknown(&self, state: &[i64]) -> Error {
        let state = self.program.show_state(state);
        Error::Usage(format!("the values of the state {state} were not computed"))
    }

    /// Returns the memory after a step, and whether the step was an improvement; see the module
    /// documentation. Planning ends in unsafe states.
    ///
    /// # Errors
    /// The errors of [`Engine::contains`].
    pub fn after(&self, memory: Memory, from: &[i64], to: &[i64]) -> Result<(Memory, bool)> {
        let change = self.change(memory, from, to)?;
        self.after_change(memory, from, to, change)
    }

    /// Returns what [`FiniteMemoryStrategy::after`] returns, given the effect of the step.
    pub(crate) fn after_change(
        &self,
        memory: Memory,
        from: &[i64],
        to: &[i64],
        change: Change,
    ) -> Result<(Memory, bool)> {
        if self.is_unsafe(to)? {
            return Ok((self.at_rest(to)?, false));
        }
        let improves = change == Change::Improving;
        let step = Step { from, to, improves };
        if let Some(pursuit) = memory.pursuit {
            return self.after_pursuing(memory, pursuit, step);
        }
        // The objective was not almost sure.
        if self.kind == StrategyKind::Achieve {
            return Ok((self.pursuing(self.at_rest(to)?, to)?, improves));
        }
        let (memory, counted) = self.after_improving(memory, step)?;
        Ok((self.pursuing(memory, to)?, counted))
    }

    /// Returns what [`FiniteMemoryStrategy::after`] returns while improvements are left.
    fn after_improving(&self, memory: Memory, step: Step<'_>) -> Result<(Memory, bool)> {
        let Step { from, to, improves } = step;
        if let Some(rule) = &self.rule {
            return self.after_by(&**rule, memory, step);
        }
        let Some(game) = self.game(memory) else {
            return Ok((self.after_resting(memory, to, improves)?, improves));
        };
        let stays = self.engine.contains(&game.states, to)?;
        let goal = improves && strategy::is_goal(&*self.engine, game, from, to)?;
        Ok(match (goal, stays, improves) {
            (true, _, _) | (_, false, true) => (self.improving(to)?, true),
            (false, true, _) => (memory, false),
            (false, false, false) => (self.resume(memory, to)?, false),
        })
    }

    /// Returns what [`FiniteMemoryStrategy::after`] returns under a decision rule.
    fn after_by(
        &self,
        rule: &dyn DecisionRule,
        memory: Memory,
        Step { from, to, improves }: Step<'_>,
    ) -> Result<(Memory, bool)> {
        Ok(match rule.after(memory, from, to) {
            None => (Memory { level: Rank::Finite(0), ..memory }, improves),
            // A plan for possible improvements ends with those that it aimed at: there may be more forever.
            Some((0, true)) if self.kind == StrategyKind::Plan && self.levels.kind == Kind::Spi => {
                (self.at_rest(to)?, true)
            }
            Some((0, true)) => (self.improving(to)?, true),
            Some((level, true)) => (Memory { level: Rank::Finite(level), ..self.at_rest(to)? }, true),
            Some((level, false)) => (Memory { level: Rank::Finite(level), ..memory }, false),
        })
    }

    /// Returns the memory after a step at level 0. Under `prefix` the reference is kept until an
    /// improvement, or until a step that was not permitted leaves the states where it can be kept.
    fn after_resting(&self, memory: Memory, to: &[i64], improves: bool) -> Result<Memory> {
        let own = |arena: &&Arena<E>| arena.reference.is_some() && !improves;
        match self.arena(memory).filter(own) {
            Some(arena) if self.engine.contains(&arena.states, to)? => self.resume(memory, to),
            _ => self.improving(to),
        }
    }

    /// Returns the memory with the greatest level that still contains a state, with the old
    /// reference.
    fn resume(&self, memory: Memory, state: &[i64]) -> Result<Memory> {
        let Some(arena) = memory.arena else { return self.improving(state) };
        let wins = |level: &Level<E>| match level.games.get(arena) {
            Some(game) => self.engine.contains(&game.states, state),
            None => Ok(false),
        };
        Ok(Memory { level: self.levels.greatest(wins)?, arena: Some(arena), pursuit: None })
    }

    /// Returns the objectives that steps are compared with: MP of the reference class under
    /// `prefix`, else MP(s).
    ///
    /// # Errors
    /// The errors of [`Engine::contains`].
    pub(crate) fn reference(&self, memory: Memory, state: &[i64]) -> Result<ObjectiveSet> {
        let class = self.arena(memory).and_then(|arena| self.classes.list.get(arena.reference?));
        class.map_or_else(|| self.most_preferred(state), |class| Ok(class.most_preferred.clone()))
    }

    /// Returns the effect of a step, compared with [`FiniteMemoryStrategy::reference`]. A step from or
    /// to an unsafe state has none.
    pub(crate) fn change(&self, memory: Memory, from: &[i64], to: &[i64]) -> Result<Change> {
        let own = self.class_of(from)?;
        let reference = self.arena(memory).and_then(|arena| arena.reference);
        let from = own.map(|own| reference.unwrap_or(own));
        Ok(self.classes.change(from, self.class_of(to)?))
    }

    /// Returns the arena of a memory.
    pub(crate) fn arena(&self, memory: Memory) -> Option<&Arena<E>> {
        self.improvement.arenas.get(memory.arena?)
    }

    /// Returns the game of a memory; `None` if nothing can be improved.
    pub(crate) fn game(&self, memory: Memory) -> Option<&Game<E>> {
        self.levels.level(memory.level)?.games.get(memory.arena?)
    }

    /// Returns whether [`FiniteMemoryStrategy::strategy`] needs no computation for a memory.
    pub fn knows(&self, memory: Memory) -> bool {
        if let (Some(pursuit), Some(achieving)) = (memory.pursuit, &self.achieving) {
            return achieving.knows(pursuit, memory.arena);
        }
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

    /// Returns the strategies of a memory; `None` if nothing can be improved and no objective is
    /// pursued. Cost: that of `strategy::strategy`, once per level and arena or per stage.
    pub fn strategy(&mut self, memory: Memory) -> Result<Option<&ArenaStrategy<E>>> {
        if let Some(pursuit) = memory.pursuit {
            return match &mut self.achieving {
                Some(achieving) => achieving.strategy(pursuit, memory.arena),
                None => Ok(None),
            };
        }
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
