//! Threats: how a path of a game can weaken after an action that is therefore not kept.

use std::collections::VecDeque;

use ahash::AHashSet;

use super::explain::lost;
use super::finite_memory::{FiniteMemoryStrategy, Memory};
use crate::analysis::improvement::Arena;
use meliora_base::error::Result;
use meliora_engine::{Engine, position};
use meliora_model::preference::{Change, ObjectiveSet};
use meliora_model::step::Step;
use meliora_model::{State, fault};

/// Maximum number of states in which a shortest threat is searched for.
const MOST_STATES: usize = 1000;

/// The shortest way to weaken from a state from which the opponent of a game, or chance, cannot be kept from it.
#[derive(Debug, Clone, PartialEq)]
pub struct Threat {
    /// The players, by their positions, with their actions, of which the last one may weaken.
    pub actions: Vec<(usize, String)>,
    /// The state that the last step enters.
    pub state: State,
    /// The most preferred objectives that it loses, compared with the state before it or, under `prefix`, the reference.
    pub lost: ObjectiveSet,
}

impl<E: Engine> FiniteMemoryStrategy<E> {
    /// Returns whether the opponent chooses in a state and can weaken from it, under `action`: one of its
    /// choices is not kept.
    fn is_bad(&self, arena: &Arena<E>, state: &[i64]) -> Result<bool> {
        let choices = self.program.choices(state).map_err(|f| fault::error(&self.program, &f, state))?;
        let owner = choices.first().and_then(|(choice, _)| self.owner_of(choice));
        if owner.is_none_or(|owner| owner.ours) {
            return Ok(false);
        }
        let kept = |(choice, _): &_| self.engine.contains_choice(&arena.choices, state, choice);
        Ok(position(&choices, |choice| Ok(!kept(choice)?))?.is_some())
    }

    /// Returns the arena of all states, unsafe ones among them, which have none of their own; `None` under
    /// `prefix`, where steps are compared with a reference.
    fn arena_of_all(&self) -> Option<&Arena<E>> {
        self.improvement.arenas.first().filter(|arena| arena.reference.is_none())
    }

    /// Returns the first successor from which the opponent can weaken, for an action that is not kept;
    /// `None` under `prefix`.
    pub(crate) fn exposed<'s>(
        &self,
        successors: impl IntoIterator<Item = &'s State>,
    ) -> Result<Option<usize>> {
        let Some(arena) = self.arena_of_all() else { return Ok(None) };
        let successors: Vec<&State> = successors.into_iter().collect();
        position(&successors, |state| self.is_bad(arena, state))
    }

    /// Returns the shortest way in which a path can weaken from a state from which this cannot be avoided: under
    /// `action` one in which the opponent can weaken, under `prefix` one outside of `safe`, where the reference of the
    /// memory may be lost. `None` if no way is found among a number of states.
    pub(crate) fn threat(
        &self,
        memory: Memory,
        safe: Option<&E::States>,
        state: &State,
    ) -> Result<Option<Threat>> {
        let reference = self.arena(memory).and_then(|arena| arena.reference);
        let is_threatened = |state: &State| match (self.arena_of_all(), safe) {
            (Some(arena), _) => self.is_bad(arena, state),
            (None, Some(safe)) => Ok(!self.engine.contains(safe, state)?),
            (None, None) => Ok(false),
        };
        let (mut seen, mut queue) = (AHashSet::from([state.clone()]), VecDeque::new());
        queue.push_back((state.clone(), Vec::new()));
        while let Some((from, actions)) = queue.pop_front() {
            let steps = self.program.steps(&from).map_err(|f| fault::error(&self.program, &f, &from))?;
            let player = |step: &Step| self.program.player_of_choice(&step.choice).unwrap_or_default();
            let with = |step: &Step| [&actions[..], &[(player(step), step.name.clone())]].concat();
            let own = reference.map_or_else(|| self.class_of(&from), |class| Ok(Some(class)))?;
            if let Some((step, to)) = self.weakening(own, &steps)? {
                let before = own
                    .map_or_else(ObjectiveSet::new, |class| self.classes.list[class].most_preferred.clone());
                let lost = lost(&self.preferences, &before, &self.most_preferred(to)?);
                return Ok(Some(Threat { actions: with(step), state: to.clone(), lost }));
            }
            for step in &steps {
                for (to, _) in &step.successors {
                    if seen.len() < MOST_STATES && !seen.contains(to) && is_threatened(to)? {
                        seen.insert(to.clone());
                        queue.push_back((to.clone(), with(step)));
                    }
                }
            }
        }
        Ok(None)
    }

    /// Returns the first step that may weaken a class, with the successor.
    fn weakening<'s>(&self, own: Option<usize>, steps: &'s [Step]) -> Result<Option<(&'s Step, &'s State)>> {
        for step in steps {
            for (to, _) in &step.successors {
                if self.classes.change(own, self.class_of(to)?) == Change::Weakening {
                    return Ok(Some((step, to)));
                }
            }
        }
        Ok(None)
    }
}
