//! The gains of a strategy's improvements: a search over the paths under it.

use std::collections::VecDeque;
use std::sync::Arc;

use ahash::AHashSet;

use super::finite_memory::FiniteMemoryStrategy;
use crate::analysis::Analysis;
use crate::analysis::levels::{Kind, Rank};
use crate::result::Prospects;
use meliora_base::error::Result;
use meliora_engine::Engine;
use meliora_model::preference::ObjectiveSet;
use meliora_model::{Program, State};

impl<E: Engine> FiniteMemoryStrategy<E> {
    /// Returns for each of the first improvements from a state the objectives that it gains, over all
    /// branches of the picked actions and all actions of an opponent; `None` if the paths until then have
    /// more than `most` states. Cost: that of [`FiniteMemoryStrategy::explain`] per state and memory.
    ///
    /// # Errors
    /// The errors of [`FiniteMemoryStrategy::explain`].
    pub fn gains(
        &mut self,
        start: &[i64],
        improvements: usize,
        most: usize,
    ) -> Result<Option<Vec<ObjectiveSet>>> {
        let first: (State, _, usize) = (start.to_vec(), self.start(start)?, 0);
        let (mut seen, mut queue) = (AHashSet::from([first.clone()]), VecDeque::from([first]));
        let mut gains = vec![ObjectiveSet::new(); improvements];
        while let Some((state, memory, made)) = queue.pop_front() {
            if made == improvements {
                continue;
            }
            if seen.len() > most {
                return Ok(None);
            }
            let at = self.explain(&state, memory)?;
            let taken = |number: usize| at.is_theirs() || at.pick == Some(number);
            let actions = at.actions.iter().enumerate().filter(|(number, _)| taken(*number));
            for successor in actions.flat_map(|(_, action)| &action.successors) {
                if successor.improves {
                    gains[made].extend_with(&successor.gained);
                }
                let next = (successor.state.clone(), successor.next, made + usize::from(successor.improves));
                if seen.insert(next.clone()) {
                    queue.push_back(next);
                }
            }
        }
        Ok(Some(gains))
    }
}

impl<E: Engine> Analysis<E> {
    /// Returns for each improvement that the progress strategy of a kind makes from a state, as its rank
    /// says, the names of the objectives that it gains; for an unbounded rank, those of the first one.
    /// Empty at rank 0, before the levels are known, and if the paths have more than `most` states. Cost:
    /// that of [`FiniteMemoryStrategy::gains`], and of the strategies of the levels.
    ///
    /// # Errors
    /// The errors of [`FiniteMemoryStrategy::gains`].
    pub fn gains(
        &self,
        program: &Arc<Program>,
        kind: Kind,
        state: &[i64],
        most: usize,
    ) -> Result<Vec<Vec<String>>> {
        let improvements = match self.rank(kind, state)? {
            Rank::Finite(k) | Rank::AtLeast(k) => k,
            Rank::Unbounded => 1,
        };
        match FiniteMemoryStrategy::new(self, program, kind) {
            Some(mut strategy) if improvements > 0 => {
                let gains = strategy.gains(state, improvements, most)?;
                self.names_of_gains(state, &gains.unwrap_or_default())
            }
            _ => Ok(Vec::new()),
        }
    }

    /// Adds to the prospects of a state the gains of the improvements that both kinds make. Cost: that of
    /// [`Analysis::gains`] for each kind.
    ///
    /// # Errors
    /// The errors of [`Analysis::gains`].
    pub fn add_gains(&self, program: &Arc<Program>, own: &mut Prospects, most: usize) -> Result<()> {
        for (kind, plan) in [(Kind::Sasi, &mut own.sasi), (Kind::Spi, &mut own.spi)] {
            if let Some(plan) = plan {
                plan.gains = self.gains(program, kind, &own.state, most)?;
            }
        }
        Ok(())
    }

    /// Returns the names of gains, without the objectives that are sure in the state where paths start.
    ///
    /// # Errors
    /// The errors of [`Engine::contains`].
    pub fn names_of_gains(&self, start: &[i64], gains: &[ObjectiveSet]) -> Result<Vec<Vec<String>>> {
        let sure = self.sure(start)?.unwrap_or_default();
        let new = |set| {
            let mut names = self.preferences().owned_names(set);
            names.retain(|name| !sure.contains(name));
            names
        };
        Ok(gains.iter().map(new).collect())
    }
}
