//! Plans and strategies of the kind `achieve` once nothing can be improved: the objective that they
//! pursue, and the commitments of plans. See the documentation of [`super::finite_memory`].

use super::achieve::{Achieving, Manner, Pursuit};
use super::finite_memory::{FiniteMemoryStrategy, Memory, Step, StrategyKind};
use crate::analysis::levels::Rank;
use meliora_base::error::Result;
use meliora_engine::Engine;
use meliora_model::preference::ObjectiveSet;

impl<E: Engine> FiniteMemoryStrategy<E> {
    /// Lets the memory of a strategy that achieves objectives pursue one, once nothing can be improved.
    pub(crate) fn pursuing(&self, memory: Memory, state: &[i64]) -> Result<Memory> {
        let Some(achieving) = self.achieving.as_ref().filter(|_| memory.level == Rank::Finite(0)) else {
            return Ok(memory);
        };
        let pursuit = match self.kind {
            StrategyKind::Achieve => {
                let enter = |objective| achieving.enter(objective, Manner::Free, None, state);
                achieving.position(&self.objectives).map(enter).transpose()?.flatten()
            }
            _ => self.planned(memory.arena, state, |_| true)?,
        };
        self.with_pursuit(memory, pursuit, state)
    }

    /// Returns the memory with a pursuit; after a commitment, the state is the reference.
    fn with_pursuit(&self, memory: Memory, pursuit: Option<Pursuit>, state: &[i64]) -> Result<Memory> {
        let kept = pursuit.is_none_or(|pursuit| pursuit.manner == Manner::Kept);
        Ok(Memory { pursuit, ..if kept { memory } else { self.at_rest(state)? } })
    }

    /// Returns the pursuit of a plan that then achieves an acceptable member of MP(s): the named
    /// objective if it is one, else the first one that kept choices achieve, else the first one.
    fn planned(
        &self,
        arena: Option<usize>,
        state: &[i64],
        accept: impl Fn(usize) -> bool,
    ) -> Result<Option<Pursuit>> {
        let Some(achieving) = &self.achieving else { return Ok(None) };
        let most_preferred = self.most_preferred(state)?;
        let candidates: Vec<usize> = most_preferred.iter().filter(|&objective| accept(objective)).collect();
        match self.objectives.iter().find(|named| candidates.contains(named)) {
            Some(named) => achieving.begin(&[named], arena, state),
            None => achieving.begin(&candidates, arena, state),
        }
    }

    /// Returns the memory after a step while an objective is pursued, and whether the step was an
    /// improvement: it is one only if the entered state becomes the reference.
    pub(crate) fn after_pursuing(
        &self,
        memory: Memory,
        pursuit: Pursuit,
        step: Step<'_>,
    ) -> Result<(Memory, bool)> {
        let fresh = self.at_rest(step.to)?;
        let next = self.pursuing_on(memory, pursuit, fresh, step)?;
        Ok((next, step.improves && next.arena == fresh.arena))
    }

    /// Returns the memory after a step while an objective is pursued; `fresh` has the entered state as
    /// the reference.
    ///
    /// A plan goes over to an objective that is preferred to the present one, once the present one is
    /// no longer most preferred. Else an improved state becomes the reference if its kept choices
    /// achieve the present objective. Else the pursuit continues.
    fn pursuing_on(&self, memory: Memory, pursuit: Pursuit, fresh: Memory, step: Step<'_>) -> Result<Memory> {
        let Step { to, improves, .. } = step;
        let Some(achieving) = &self.achieving else { return Ok(memory) };
        let (is_plan, kept) = (self.kind == StrategyKind::Plan, pursuit.manner == Manner::Kept);
        if is_plan && !self.most_preferred(to)?.contains(pursuit.objective) {
            let better = |other| self.preferences.order.strictly(other, pursuit.objective);
            let moved = if kept && !improves { memory } else { fresh };
            if let Some(pursuit) = self.planned(moved.arena, to, better)? {
                return self.with_pursuit(moved, Some(pursuit), to);
            }
        }
        if kept
            && improves
            && fresh.arena != memory.arena
            && let Some(renewed) = achieving.enter(pursuit.objective, Manner::Kept, fresh.arena, to)?
        {
            return Ok(Memory { pursuit: Some(renewed), ..fresh });
        }
        match achieving.after(pursuit, memory.arena, step)? {
            // The step left the states of the pursuit, so it was not one of the plan.
            None if is_plan => self.pursuing(fresh, to),
            next => Ok(Memory { pursuit: next, ..if kept { memory } else { fresh } }),
        }
    }

    /// Returns the objectives that are pursued; empty while the strategy improves, and where the
    /// objective is not almost sure unless a rule makes it as likely as possible.
    pub fn pursued(&self, memory: Memory) -> ObjectiveSet {
        match memory.pursuit.zip(self.achieving.as_ref()) {
            Some((pursuit, achieving)) => achieving.pursued(pursuit),
            None if self.is_likely(memory) => self.objectives.clone(),
            None => ObjectiveSet::new(),
        }
    }

    /// Returns whether a rule takes the choices to achieve an objective that is not almost sure.
    pub(crate) fn is_likely(&self, memory: Memory) -> bool {
        self.kind == StrategyKind::Achieve && self.rule.is_some() && memory.pursuit.is_none()
    }

    /// Returns the pursued objectives that a path has not achieved when it is in a state.
    ///
    /// # Errors
    /// The errors of [`Engine::contains`].
    pub fn left(&self, memory: Memory, state: &[i64]) -> Result<ObjectiveSet> {
        match memory.pursuit.zip(self.achieving.as_ref()) {
            Some((pursuit, achieving)) => achieving.left(pursuit, state),
            None => Ok(self.pursued(memory)),
        }
    }

    /// Returns whether a pursuit keeps its objective: no step achieves it, but the steps that follow can
    /// satisfy it almost surely without a further condition.
    pub(crate) fn keeps(&self, pursuit: Pursuit) -> bool {
        self.achieving.as_ref().is_some_and(|achieving| achieving.keeps(pursuit))
    }

    /// Returns the objectives that are achieved in a state; empty if the strategy achieves none.
    ///
    /// # Errors
    /// The errors of [`Engine::contains`].
    pub fn achieved(&self, state: &[i64]) -> Result<ObjectiveSet> {
        let achieved = |achieving: &Achieving<E>| achieving.achieved(state);
        self.achieving.as_ref().map_or_else(|| Ok(ObjectiveSet::new()), achieved)
    }
}
