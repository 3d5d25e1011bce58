//! The strategies of an analysis, by their kinds.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::achieve::Achieving;
use super::finite_memory::{FiniteMemoryStrategy, StrategyKind};
use crate::analysis::Analysis;
use crate::analysis::level_search::LevelSearch;
use crate::analysis::levels::Kind;
use crate::analysis::temporal_game;
use meliora_base::error::Result;
use meliora_engine::Engine;
use meliora_model::Program;
use meliora_model::preference::ObjectiveSet;

impl<E: Engine> FiniteMemoryStrategy<E> {
    /// Creates the finite-memory strategy of an analysis; `None` before the search for levels of
    /// this kind has ended.
    pub fn new(analysis: &Analysis<E>, program: &Arc<Program>, kind: Kind) -> Option<Self> {
        let LevelSearch::Ended(levels) = analysis.search(kind) else { return None };
        Some(FiniteMemoryStrategy {
            whole: analysis.whole.clone(),
            engine: analysis.engine.clone(),
            program: Arc::clone(program),
            preferences: analysis.preferences.clone(),
            classes: analysis.classes.clone()?,
            improvement: analysis.improvement.clone()?,
            levels: Arc::clone(levels),
            strategies: BTreeMap::new(),
            rule: None,
            kind: kind.into(),
            achieving: None,
            objectives: ObjectiveSet::new(),
            standings: None,
        })
    }

    /// Checks that a strategy can achieve the objectives that it may pursue: a plan all of them. Cost: no
    /// image.
    ///
    /// # Errors
    /// [`Usage`](meliora_base::error::Error::Usage) if the opponent of a game may choose how the formula of one is satisfied.
    pub fn check_achieved(
        analysis: &Analysis<E>,
        kind: StrategyKind,
        objectives: &ObjectiveSet,
    ) -> Result<()> {
        let pursued = |index: usize| kind == StrategyKind::Plan || objectives.contains(index);
        let all = analysis.preferences.objectives.iter().enumerate();
        let pursued = all.filter(|(index, _)| pursued(*index)).map(|(_, objective)| objective);
        temporal_game::check_achieved(&*analysis.engine, pursued)
    }

    /// Creates the strategy of a kind that makes improvements of the kind `levels`, with the objectives
    /// that it achieves: one, or several together, for [`StrategyKind::Achieve`], at most one for
    /// [`StrategyKind::Plan`]. Returns `None` before the results that it needs are known. Cost: one
    /// pre-image per objective if the kind achieves one; for several, one almost-sure fixpoint per
    /// subset.
    ///
    /// # Errors
    /// [`Usage`](meliora_base::error::Error::Usage) if the kind does not achieve several; a limit is reached.
    pub fn of_kind(
        analysis: &Analysis<E>,
        program: &Arc<Program>,
        kind: StrategyKind,
        levels: Kind,
        objectives: impl IntoIterator<Item = usize>,
    ) -> Result<Option<Self>> {
        let objectives: ObjectiveSet = objectives.into_iter().collect();
        kind.check(&objectives)?;
        Self::check_achieved(analysis, kind, &objectives)?;
        let Some(strategy) = Self::new(analysis, program, levels) else { return Ok(None) };
        let mut achieving = if kind.achieves() { Achieving::new(analysis, &strategy)? } else { None };
        if let Some(achieving) = achieving.as_mut().filter(|_| objectives.len() > 1) {
            achieving.join(analysis, objectives.clone())?;
        }
        Ok(Some(FiniteMemoryStrategy { kind, achieving, objectives, ..strategy }))
    }
}
