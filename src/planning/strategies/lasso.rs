//! Steps that improve again and again: why the number of improvements has no bound.
//!
//! From a state of unbounded rank, the progress strategy of the unbounded level comes closer to an
//! improvement with each step that chance favours, and an improvement enters the level anew. So a path
//! on which chance always favours the strategy comes back to a state and memory that it had before, and
//! has improved in between.

use std::sync::Arc;

use ahash::AHashMap;

use super::explain::{Explanation, Successor};
use super::finite_memory::{FiniteMemoryStrategy, Memory};
use crate::analysis::Analysis;
use crate::analysis::levels::{Kind, Rank};
use meliora_base::error::Result;
use meliora_engine::{Engine, position};
use meliora_model::preference::ObjectiveSet;
use meliora_model::{Program, State};

/// A path under the progress strategy that comes back to one of its states, with the same memory.
#[derive(Debug, Clone, PartialEq)]
pub struct Lasso {
    /// The steps of the path.
    pub steps: Vec<LassoStep>,
    /// The position of the step before which the path is again after the last one. One of the steps
    /// from there on is an improvement.
    pub repeats_from: usize,
}

/// A step of a lasso.
#[derive(Debug, Clone, PartialEq)]
pub struct LassoStep {
    /// The state before the step.
    pub state: State,
    /// The name of the action.
    pub action: String,
    /// True if the opponent of a game chose the action.
    pub is_theirs: bool,
    /// The state entered.
    pub to: State,
    /// The probability of this branch of the action.
    pub probability: f64,
    /// True if the step is an improvement.
    pub improves: bool,
    /// The objectives gained, compared with the reference.
    pub gained: ObjectiveSet,
}

impl<E: Engine> Analysis<E> {
    /// Returns a lasso from a state whose rank of this kind is unbounded. Returns `None` for other
    /// states, before the levels are known, and if the lasso has more than `most` steps. Cost: that of
    /// [`FiniteMemoryStrategy::strategy`] for the unbounded level, and of
    /// [`FiniteMemoryStrategy::explain`] per step.
    ///
    /// # Errors
    /// The errors of [`FiniteMemoryStrategy::explain`].
    pub fn lasso(
        &self,
        program: &Arc<Program>,
        kind: Kind,
        state: &[i64],
        most: usize,
    ) -> Result<Option<Lasso>> {
        match FiniteMemoryStrategy::new(self, program, kind) {
            Some(mut strategy) if self.rank(kind, state)? == Rank::Unbounded => strategy.lasso(state, most),
            _ => Ok(None),
        }
    }
}

impl<E: Engine> FiniteMemoryStrategy<E> {
    fn lasso(&mut self, start: &[i64], most: usize) -> Result<Option<Lasso>> {
        let mut seen: AHashMap<(State, Memory), usize> = AHashMap::new();
        let mut here = (start.to_vec(), self.start(start)?);
        let mut steps = Vec::new();
        loop {
            if let Some(&repeats_from) = seen.get(&here) {
                return Ok(Some(Lasso { steps, repeats_from }));
            }
            if steps.len() >= most {
                return Ok(None);
            }
            let at = self.explain(&here.0, here.1)?;
            let Some((action, successor)) = self.favoured(&at)? else { return Ok(None) };
            seen.insert(here, steps.len());
            steps.push(LassoStep {
                state: at.state.clone(),
                action: at.actions[action].name.clone(),
                is_theirs: at.is_theirs(),
                to: successor.state.clone(),
                probability: successor.probability,
                improves: successor.improves,
                gained: successor.gained.clone(),
            });
            here = (successor.state.clone(), successor.next);
        }
    }

    /// Returns the action of the progress strategy, or one of the opponent that comes as close to an
    /// improvement as others, and its successor that comes closest.
    fn favoured<'a>(&mut self, at: &'a Explanation) -> Result<Option<(usize, &'a Successor)>> {
        let nearest = || {
            let distances = at.actions.iter().map(|action| action.distance).enumerate();
            distances.filter_map(|(position, distance)| Some((distance?, position))).min()
        };
        let action = if at.is_theirs() { nearest().map(|(_, position)| position) } else { at.pick };
        let Some(action) = action else { return Ok(None) };
        let successors: Vec<&Successor> =
            at.actions[action].successors.iter().filter(|s| !s.dropped).collect();
        if let Some(goal) = successors.iter().find(|successor| successor.goal) {
            return Ok(Some((action, goal)));
        }
        let engine = self.engine.clone();
        let Some(strategy) = self.strategy(at.memory)? else { return Ok(None) };
        for layer in &strategy.layers {
            if let Some(found) = position(&successors, |s| engine.contains(layer, &s.state))? {
                return Ok(Some((action, successors[found])));
            }
        }
        Ok(None)
    }
}
