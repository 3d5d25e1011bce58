//! Strategies that achieve an objective almost surely, and the stages that they go through.
//!
//! From ASWin(F_i), a strategy that takes only choices that stay in ASWin(F_i), and again and again
//! comes closer to F_i, reaches F_i almost surely. For a temporal objective, F_i is the set of
//! states where a disjunct of its formula can be kept. From there on the strategy takes only choices
//! that keep this disjunct, and approaches its recurring marks one after the other. Each of these
//! parts is a *stage*.
//!
//! Objectives that are named together are one more objective, their conjunction; see `together`.
//!
//! A plan takes only choices that the safety mode keeps, if these suffice to achieve the objective.
//! Its stages are then those of the model that has only these choices.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::{Arc, OnceLock};

use super::finite_memory::{FiniteMemoryStrategy, Step};
use super::strategy::{ArenaStrategy, approach};
use crate::analysis::Analysis;
use crate::analysis::improvement::Improvement;
use crate::analysis::temporal::{self, AcceptingRegion};
use meliora_base::error::Result;
use meliora_engine::edge_labels::{dropped, pairs_into};
use meliora_engine::{Engine, Region, position};
use meliora_model::preference::{Goal, ObjectiveSet, Preferences};

/// The choices with which an objective is pursued.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Manner {
    /// All choices with which the objective stays sure: strategies of the kind `achieve`.
    Free,
    /// The choices among these that the safety mode keeps: no step weakens.
    Kept,
    /// All choices with which the objective stays sure, because the kept ones do not suffice: the
    /// plan has committed to the objective, and may give up others.
    Committed,
}

/// The objective that a run is to achieve, and the stage of its strategy.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Pursuit {
    /// The objective, by its position; after the last one, all named objectives together.
    pub objective: usize,
    /// The choices with which it is pursued.
    pub manner: Manner,
    /// The stage; 0 approaches the target. For targets that are to be reached together, bit i says
    /// that the path has reached the i-th of them.
    pub stage: usize,
}

/// One stage: the states and choices in which it stays, and the states that it approaches.
pub(crate) struct Stage<E: Engine> {
    pub(crate) region: Region<E::States, E::Choices>,
    pub(crate) goal: E::States,
    /// True if the strategy continues from the goal, with the next stage.
    pub(crate) recurs: bool,
}

/// The stages of one objective, with some choices.
pub(crate) struct Stages<E: Engine> {
    pub(crate) all: Vec<Stage<E>>,
    /// The stages of each disjunct.
    pub(crate) disjuncts: Vec<Range<usize>>,
    /// The objectives that are to be reached together, if there are several.
    pub(crate) together: Vec<usize>,
}

/// The strategies that achieve the objectives of an analysis, computed on demand.
pub(crate) struct Achieving<E: Engine> {
    engine: Arc<E>,
    preferences: Arc<Preferences>,
    improvement: Arc<Improvement<E>>,
    /// The states in which each objective is achieved, whatever follows.
    achieved: Vec<E::States>,
    /// The target of each objective.
    targets: Vec<E::States>,
    /// The stages of each objective, and then of the named ones together, with all choices.
    free: Vec<Stages<E>>,
    /// The objectives that are named together.
    named: ObjectiveSet,
    /// For each arena, and then for no arena, the stages of each objective with kept choices.
    kept: Vec<Vec<OnceLock<Stages<E>>>>,
    strategies: BTreeMap<(Pursuit, Option<usize>), ArenaStrategy<E>>,
}

impl<E: Engine> Achieving<E> {
    /// Prepares the stages of all objectives for a strategy of the analysis; `None` before the winning
    /// regions are known. Cost: one pre-image per objective.
    ///
    /// # Errors
    /// A limit of the engine is reached, or a state formula has no value.
    pub(crate) fn new(analysis: &Analysis<E>, strategy: &FiniteMemoryStrategy<E>) -> Result<Option<Self>> {
        let Some(outcomes) = analysis.outcomes() else { return Ok(None) };
        let FiniteMemoryStrategy { engine, preferences, improvement, .. } = strategy;
        let (mut achieved, mut targets, mut free) = (Vec::new(), Vec::new(), Vec::new());
        for (index, objective) in preferences.objectives.iter().enumerate() {
            let Some(regions) = outcomes.get(index) else { return Ok(None) };
            achieved.push(match &objective.goal {
                Goal::Reach(_) => regions.target.clone(),
                Goal::Satisfy { decided, .. } => engine.states_where(decided)?,
            });
            targets.push(regions.target.clone());
            let accepting = analysis.accepting_regions(index);
            let (sure, all) = (&regions.almost_sure, engine.all_choices());
            free.push(Stages::new(&**engine, &regions.target, sure, &all, accepting)?);
        }
        let row = || free.iter().map(|_| OnceLock::new()).collect();
        let kept = (0..=improvement.arenas.len()).map(|_| row()).collect();
        let (engine, preferences) = (Arc::clone(engine), Arc::clone(preferences));
        let improvement = Arc::clone(improvement);
        let (strategies, named) = (BTreeMap::new(), ObjectiveSet::new());
        Ok(Some(Achieving {
            engine,
            preferences,
            improvement,
            achieved,
            targets,
            free,
            named,
            kept,
            strategies,
        }))
    }

    /// Prepares to achieve several objectives together. Cost: one almost-sure fixpoint per subset.
    ///
    /// # Errors
    /// [`Error::Usage`](meliora_base::error::Error) for too many objectives; a limit of the engine is
    /// reached.
    pub(crate) fn join(&mut self, analysis: &Analysis<E>, objectives: ObjectiveSet) -> Result<()> {
        self.free.push(Stages::together(analysis, &objectives)?);
        self.named = objectives;
        Ok(())
    }

    /// Returns the position of the objectives in pursuits: that of the only one, or of all together.
    pub(crate) fn position(&self, objectives: &ObjectiveSet) -> Option<usize> {
        match objectives.len() {
            0 | 1 => objectives.iter().next(),
            _ => Some(self.preferences.objectives.len()),
        }
    }

    /// Returns the objectives of a pursuit.
    pub(crate) fn pursued(&self, pursuit: Pursuit) -> ObjectiveSet {
        match pursuit.objective < self.preferences.objectives.len() {
            true => std::iter::once(pursuit.objective).collect(),
            false => self.named.clone(),
        }
    }

    /// Returns the objectives of a pursuit that the path has not achieved when it is in a state.
    ///
    /// # Errors
    /// The errors of [`Engine::contains`].
    pub(crate) fn left(&self, pursuit: Pursuit, state: &[i64]) -> Result<ObjectiveSet> {
        let here = self.achieved(state)?;
        let together = self.free.get(pursuit.objective).map_or(&[][..], |stages| &stages.together);
        let bits = together.iter().enumerate().filter(|(i, _)| pursuit.stage >> i & 1 == 1);
        let reached: ObjectiveSet = bits.map(|(_, &objective)| objective).collect();
        let is_left = |&objective: &usize| !here.contains(objective) && !reached.contains(objective);
        Ok(self.pursued(pursuit).iter().filter(is_left).collect())
    }

    /// Returns whether a pursuit keeps its objective: it has gone on from the target.
    pub(crate) fn keeps(&self, pursuit: Pursuit) -> bool {
        pursuit.stage > 0 && self.free.get(pursuit.objective).is_some_and(|stages| stages.together.is_empty())
    }

    /// Returns the stage after a path has come to a state, if targets are to be reached together.
    fn reached(&self, together: &[usize], stage: usize, state: &[i64]) -> Result<usize> {
        let here = self.achieved(state)?;
        let bits = together.iter().enumerate().filter(|(_, objective)| here.contains(**objective));
        Ok(bits.fold(stage, |stage, (i, _)| stage | 1 << i))
    }

    /// Returns the stages of a pursuit that takes place in an arena. Cost: with kept choices, that of
    /// one `almost_surely_reach`, once per arena and objective; for a temporal objective, also one
    /// `accepting_region` per disjunct.
    fn stages(&self, objective: usize, manner: Manner, arena: Option<usize>) -> Result<&Stages<E>> {
        if manner != Manner::Kept {
            return Ok(&self.free[objective]);
        }
        let cell = &self.kept[arena.unwrap_or(self.improvement.arenas.len())][objective];
        if let Some(known) = cell.get() {
            return Ok(known);
        }
        let stages = self.with_kept_choices(objective, arena)?;
        Ok(cell.get_or_init(|| stages))
    }

    fn with_kept_choices(&self, objective: usize, arena: Option<usize>) -> Result<Stages<E>> {
        let engine = &*self.engine;
        let within = self.kept_choices(arena)?;
        let (target, accepting) = match &self.preferences.objectives[objective].goal {
            Goal::Reach(_) => (self.targets[objective].clone(), Vec::new()),
            Goal::Satisfy { condition, .. } => {
                let accepting = temporal::accepting_regions(engine, condition, &within)?;
                (temporal::secured(engine, &accepting)?, accepting)
            }
        };
        let sure = engine.almost_surely_reach(&target, &within)?.states;
        Stages::new(engine, &target, &sure, &within, &accepting)
    }

    /// Returns the kept choices of an arena without those that have a dropped branch: the system may
    /// take it.
    fn kept_choices(&self, arena: Option<usize>) -> Result<E::Choices> {
        let engine = &*self.engine;
        let Some(arena) = arena.and_then(|arena| self.improvement.arenas.get(arena)) else {
            return Ok(engine.no_choices());
        };
        let weakening = pairs_into(engine, &arena.choices, dropped(engine, &arena.edge_labels)?)?;
        engine.difference(&arena.choices, &weakening)
    }

    /// Returns the pursuit of an objective from a state; `None` if the choices do not suffice to
    /// achieve it almost surely. Cost: see `Achieving::stages`.
    pub(crate) fn enter(
        &self,
        objective: usize,
        manner: Manner,
        arena: Option<usize>,
        state: &[i64],
    ) -> Result<Option<Pursuit>> {
        let Stages { all, disjuncts, together } = self.stages(objective, manner, arena)?;
        let within = |stage: usize| self.engine.contains(&all[stage].region.states, state);
        if !within(0)? {
            return Ok(None);
        }
        if !together.is_empty() {
            let stage = self.reached(together, 0, state)?;
            return Ok(Some(Pursuit { objective, manner, stage }));
        }
        let kept = position(disjuncts, |stages| within(stages.start))?;
        Ok(Some(Pursuit { objective, manner, stage: kept.map_or(0, |kept| disjuncts[kept].start) }))
    }

    /// Returns the pursuit of the first candidate that kept choices of the arena achieve almost
    /// surely. If there is none, commits to the first candidate. Cost: see `Achieving::stages`.
    pub(crate) fn begin(
        &self,
        candidates: &[usize],
        arena: Option<usize>,
        state: &[i64],
    ) -> Result<Option<Pursuit>> {
        for &objective in candidates {
            if let Some(kept) = self.enter(objective, Manner::Kept, arena, state)? {
                return Ok(Some(kept));
            }
        }
        let commit = |&objective| self.enter(objective, Manner::Committed, arena, state);
        Ok(candidates.first().map(commit).transpose()?.flatten())
    }

    /// Returns the pursuit after a step: the next stage of a disjunct after a marked state, or of
    /// targets that are to be reached together.
    ///
    /// # Errors
    /// The errors of [`Engine::contains`].
    pub(crate) fn after(
        &self,
        pursuit: Pursuit,
        arena: Option<usize>,
        Step { from, to, .. }: Step<'_>,
    ) -> Result<Option<Pursuit>> {
        let Pursuit { objective, manner, stage } = pursuit;
        let Stages { all, disjuncts, together } = self.stages(objective, manner, arena)?;
        let stays = self.engine.contains(&all[stage].region.states, to)?;
        if stays && !together.is_empty() {
            return Ok(Some(Pursuit { stage: self.reached(together, stage, to)?, ..pursuit }));
        }
        let kept = disjuncts.iter().find(|range| range.contains(&stage));
        let Some(range) = kept.filter(|_| stays) else { return self.enter(objective, manner, arena, to) };
        let next = if stage + 1 == range.end { range.start } else { stage + 1 };
        let marked = self.engine.contains(&all[stage].goal, from)?;
        Ok(Some(Pursuit { stage: if marked { next } else { stage }, ..pursuit }))
    }

    /// Returns the objectives that are achieved in a state.
    ///
    /// # Errors
    /// The errors of [`Engine::contains`].
    pub(crate) fn achieved(&self, state: &[i64]) -> Result<ObjectiveSet> {
        let mut achieved = ObjectiveSet::new();
        for (objective, states) in self.achieved.iter().enumerate() {
            if self.engine.contains(states, state)? {
                achieved.insert(objective);
            }
        }
        Ok(achieved)
    }

    /// Returns the objectives that a step achieves of those that are left or, if none is, of all pursued
    /// ones.
    pub(crate) fn achieves(&self, pursuit: Pursuit, from: &[i64], to: &[i64]) -> Result<ObjectiveSet> {
        let (left, achieved) = (self.left(pursuit, from)?, self.achieved(to)?);
        let asked = if left.is_empty() { self.pursued(pursuit) } else { left };
        Ok(asked.iter().filter(|&objective| achieved.contains(objective)).collect())
    }

    /// Returns whether a pursuit can go on in a state: its choices suffice there.
    pub(crate) fn is_sure(&self, pursuit: Pursuit, arena: Option<usize>, state: &[i64]) -> Result<bool> {
        let stages = self.stages(pursuit.objective, pursuit.manner, arena)?;
        self.engine.contains(&stages.all[pursuit.stage].region.states, state)
    }

    /// Returns whether [`Achieving::strategy`] needs no computation.
    pub(crate) fn knows(&self, pursuit: Pursuit, arena: Option<usize>) -> bool {
        self.strategies.contains_key(&key(pursuit, arena))
    }

    /// Returns the strategy of a stage. Cost: one pre-image per layer, once per stage.
    pub(crate) fn strategy(
        &mut self,
        pursuit: Pursuit,
        arena: Option<usize>,
    ) -> Result<Option<&ArenaStrategy<E>>> {
        let key = key(pursuit, arena);
        if !self.strategies.contains_key(&key) {
            let engine = &*self.engine;
            let stages = self.stages(pursuit.objective, pursuit.manner, arena)?;
            let Stage { region, goal, recurs } = &stages.all[pursuit.stage];
            let first = if *recurs { engine.choices_in(&region.choices, goal)? } else { engine.no_choices() };
            let found = approach(engine, region, goal, first)?;
            self.strategies.insert(key, found);
        }
        Ok(self.strategies.get(&key))
    }
}

/// Returns what selects a strategy: the arena matters for kept choices only.
fn key(pursuit: Pursuit, arena: Option<usize>) -> (Pursuit, Option<usize>) {
    (pursuit, arena.filter(|_| pursuit.manner == Manner::Kept))
}

impl<E: Engine> Stages<E> {
    /// Returns the stage that approaches the target within `sure`, then a stage for each recurring
    /// mark of each disjunct, and one for a disjunct without marks. Cost: one pre-image.
    pub(crate) fn new(
        engine: &E,
        target: &E::States,
        sure: &E::States,
        within: &E::Choices,
        accepting: &[AcceptingRegion<E>],
    ) -> Result<Self> {
        let staying = engine.pre_within(within, sure)?;
        let region = Region { choices: engine.choices_in(&staying, sure)?, states: sure.clone() };
        let mut all = vec![Stage { region, goal: target.clone(), recurs: false }];
        let mut disjuncts = Vec::new();
        for kept in accepting {
            let start = all.len();
            let marks = if kept.again.is_empty() { std::slice::from_ref(&kept.states) } else { &kept.again };
            all.extend(marks.iter().map(|mark| Stage {
                region: Region { states: kept.states.clone(), choices: kept.choices.clone() },
                goal: mark.clone(),
                recurs: true,
            }));
            disjuncts.push(start..all.len());
        }
        Ok(Stages { all, disjuncts, together: Vec::new() })
    }
}
