//! Strategies that achieve an objective almost surely, and the stages that they go through.
//!
//! From ASWin(F_i), a strategy that takes only choices that stay in ASWin(F_i), and again and again
//! comes closer to F_i, reaches F_i almost surely. For a temporal objective, F_i is the set of
//! states where a disjunct of its formula can be kept. From there on the strategy takes only choices
//! that keep this disjunct, and approaches its recurring marks one after the other. Each of these
//! parts is a *stage*.

use std::collections::BTreeMap;
use std::ops::Range;

use super::analysis::Analysis;
use super::strategy::{Strategy, approach};
use super::temporal::AcceptingRegion;
use crate::engine::{Engine, Region, position};
use crate::error::Result;
use crate::model::preference::{Goal, ObjectiveSet};

/// The objective that a run is to achieve, and the stage of its strategy.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Pursuit {
    /// The objective, by its position.
    pub objective: usize,
    /// The stage; 0 approaches the target.
    pub stage: usize,
}

/// One stage: the states and choices in which it stays, and the states that it approaches.
struct Stage<E: Engine> {
    region: Region<E::States, E::Choices>,
    goal: E::States,
    /// True if the strategy goes on from the goal, with the next stage.
    recurs: bool,
}

/// What is needed to achieve one objective.
struct Achievable<E: Engine> {
    /// The states where the objective is achieved: F_i, or the states where the path so far satisfies
    /// the formula, whatever follows.
    achieved: E::States,
    stages: Vec<Stage<E>>,
    /// The stages of each disjunct.
    disjuncts: Vec<Range<usize>>,
}

/// The strategies that achieve the objectives of an analysis, computed on demand.
pub(super) struct Achieving<E: Engine> {
    objectives: Vec<Achievable<E>>,
    strategies: BTreeMap<Pursuit, Strategy<E>>,
}

impl<E: Engine> Achieving<E> {
    /// Prepares the stages of all objectives; `None` before the winning regions are known. Cost: one
    /// pre-image per objective.
    ///
    /// # Errors
    /// A limit of the engine is reached.
    pub(super) fn new(analysis: &Analysis<E>) -> Result<Option<Self>> {
        let Some(outcomes) = analysis.outcomes() else { return Ok(None) };
        let mut objectives = Vec::new();
        for (index, objective) in analysis.preferences().objectives.iter().enumerate() {
            let Some(regions) = outcomes.get(index) else { return Ok(None) };
            let (engine, sure) = (analysis.engine(), &regions.almost_sure);
            let approaching = Stage {
                region: Region {
                    choices: engine.choices_in(&engine.every_successor_in(sure)?, sure)?,
                    states: sure.clone(),
                },
                goal: regions.target.clone(),
                recurs: false,
            };
            objectives.push(match &objective.goal {
                Goal::Reach(_) => Achievable {
                    achieved: regions.target.clone(),
                    stages: vec![approaching],
                    disjuncts: Vec::new(),
                },
                Goal::Satisfy { decided, .. } => {
                    let achieved = engine.states_where(*decided)?;
                    Achievable::temporal(achieved, approaching, analysis.accepting_regions(index))
                }
            });
        }
        Ok(Some(Achieving { objectives, strategies: BTreeMap::new() }))
    }

    /// Returns the pursuit of an objective from a state; `None` outside of ASWin(F_i).
    ///
    /// # Errors
    /// The errors of [`Engine::contains`].
    pub(super) fn enter(&self, engine: &E, objective: usize, state: &[i64]) -> Result<Option<Pursuit>> {
        let Some(Achievable { stages, disjuncts, .. }) = self.objectives.get(objective) else {
            return Ok(None);
        };
        let within = |stage: usize| engine.contains(&stages[stage].region.states, state);
        if !within(0)? {
            return Ok(None);
        }
        let kept = position(disjuncts, |stages| within(stages.start))?;
        Ok(Some(Pursuit { objective, stage: kept.map_or(0, |kept| disjuncts[kept].start) }))
    }

    /// Returns the pursuit after a step: the next stage of a disjunct after a marked state.
    ///
    /// # Errors
    /// The errors of [`Engine::contains`].
    pub(super) fn after(
        &self,
        engine: &E,
        pursuit: Pursuit,
        (from, to): (&[i64], &[i64]),
    ) -> Result<Option<Pursuit>> {
        let Pursuit { objective, stage } = pursuit;
        let Achievable { stages, disjuncts, .. } = &self.objectives[objective];
        let stays = engine.contains(&stages[stage].region.states, to)?;
        let kept = disjuncts.iter().find(|range| range.contains(&stage));
        let Some(range) = kept.filter(|_| stays) else { return self.enter(engine, objective, to) };
        let next = if stage + 1 == range.end { range.start } else { stage + 1 };
        let marked = engine.contains(&stages[stage].goal, from)?;
        Ok(Some(Pursuit { objective, stage: if marked { next } else { stage } }))
    }

    /// Returns the objectives that are achieved in a state.
    ///
    /// # Errors
    /// The errors of [`Engine::contains`].
    pub(super) fn achieved(&self, engine: &E, state: &[i64]) -> Result<ObjectiveSet> {
        let mut achieved = ObjectiveSet::new();
        for (index, objective) in self.objectives.iter().enumerate() {
            if engine.contains(&objective.achieved, state)? {
                achieved.insert(index);
            }
        }
        Ok(achieved)
    }

    /// Returns whether a state is one from which the objective is achieved almost surely.
    ///
    /// # Errors
    /// The errors of [`Engine::contains`].
    pub(super) fn is_sure(&self, engine: &E, pursuit: Pursuit, state: &[i64]) -> Result<bool> {
        let stage = &self.objectives[pursuit.objective].stages[pursuit.stage];
        engine.contains(&stage.region.states, state)
    }

    /// Returns whether [`Achieving::strategy`] needs no computation.
    pub(super) fn knows(&self, pursuit: Pursuit) -> bool {
        self.strategies.contains_key(&pursuit)
    }

    /// Returns the strategy of a stage. Cost: one pre-image per layer, once per stage.
    ///
    /// # Errors
    /// A limit of the engine is reached.
    pub(super) fn strategy(&mut self, engine: &E, pursuit: Pursuit) -> Result<Option<&Strategy<E>>> {
        if !self.strategies.contains_key(&pursuit) {
            let Stage { region, goal, recurs } = &self.objectives[pursuit.objective].stages[pursuit.stage];
            let first = if *recurs { engine.choices_in(&region.choices, goal)? } else { engine.no_choices() };
            self.strategies.insert(pursuit, approach(engine, region, goal, first)?);
        }
        Ok(self.strategies.get(&pursuit))
    }
}

impl<E: Engine> Achievable<E> {
    /// Adds a stage for each recurring mark of each disjunct, and one for a disjunct without marks.
    fn temporal(achieved: E::States, approaching: Stage<E>, regions: &[AcceptingRegion<E>]) -> Self {
        let (mut stages, mut disjuncts) = (vec![approaching], Vec::new());
        for kept in regions {
            let start = stages.len();
            let marks = if kept.again.is_empty() { std::slice::from_ref(&kept.states) } else { &kept.again };
            stages.extend(marks.iter().map(|mark| Stage {
                region: Region { states: kept.states.clone(), choices: kept.choices.clone() },
                goal: mark.clone(),
                recurs: true,
            }));
            disjuncts.push(start..stages.len());
        }
        Achievable { achieved, stages, disjuncts }
    }
}
