//! The rewards of the choices of an arena.

use std::iter::repeat_n;

use meliora_base::error::Result;
use meliora_model::rewards::{Earner, RewardStructure};
use meliora_model::{ModelKind, Program, State};
use meliora_space::weighted::{Walk, Walker};

use super::arena::{Arena, Rewards};

/// The rewards of the choices of an arena, one state after the other.
pub(super) struct Earnings<'a> {
    arena: &'a Arena<'a>,
    structure: &'a RewardStructure,
    /// Lists the choices by the guards that hold; `None` if the engine keeps them, and rewards depend on actions alone.
    walk: Option<Box<dyn Walk + 'a>>,
    /// The synchronisation of each choice of the state.
    synchronisations: Vec<usize>,
    /// The numbers of the rewards of the actions in the state.
    known: Vec<(Option<usize>, u32)>,
}

impl<'a> Earnings<'a> {
    /// Returns the walker that [`Earnings::new`] needs.
    ///
    /// # Errors
    /// The work is cancelled.
    pub(super) fn walker(arena: &Arena<'a>, structure: &RewardStructure) -> Result<Option<Walker<'a>>> {
        let of_command = |earner: Earner| matches!(earner, Earner::Command(_));
        let is_known = arena.kept_choices().is_some()
            && arena.program.kind != ModelKind::Dtmc
            && !structure.items.iter().any(|item| of_command(item.earner));
        (!is_known).then(|| Walker::new(arena.program, &*arena.sink)).transpose()
    }

    /// Prepares the states of an arena.
    pub(super) fn new(
        arena: &'a Arena<'a>,
        structure: &'a RewardStructure,
        walker: Option<&'a Walker<'a>>,
    ) -> Self {
        let walk = walker.map(Walker::walk);
        Earnings { arena, structure, walk, synchronisations: Vec::new(), known: Vec::new() }
    }

    /// Adds the rewards of the choices of the next state.
    ///
    /// # Errors
    /// A reward, a guard or a probability has no value in the state.
    pub(super) fn add(&mut self, number: usize, state: &State, rewards: &mut Rewards) -> Result<()> {
        let (arena, program) = (self.arena, self.arena.program);
        let mut choices = arena.choices.of(number as u32);
        let Some(walk) = &mut self.walk else {
            self.enter(number);
            return choices.try_for_each(|choice| self.by_action(arena.position(choice), state, rewards));
        };
        walk.enable(arena.code(number))?;
        for choice in choices {
            let taken = walk.taken(arena.position(choice));
            let reward = program.signed_reward_of(self.structure, state, &taken.combinations)?;
            rewards.of_choice.push(rewards.fractions.number(reward));
        }
        Ok(())
    }

    /// Moves to a state whose choices the engine keeps.
    fn enter(&mut self, state: usize) {
        self.known.clear();
        self.synchronisations.clear();
        if let (Some(kept), Some(list)) = (self.arena.kept_choices(), self.arena.list(state)) {
            let all = kept.synchronisations(self.arena.program, list);
            self.synchronisations.extend(all.flat_map(|(index, count)| repeat_n(index, count)));
        }
    }

    fn by_action(&mut self, position: usize, state: &State, rewards: &mut Rewards) -> Result<()> {
        let program: &Program = self.arena.program;
        // A deadlock has no synchronisation.
        let own = self.synchronisations.get(position).map(|&index| (index, Vec::new()));
        let action = own.as_ref().and_then(|(index, _)| program.synchronisations[*index].action);
        let known = self.known.iter().find(|(known, _)| own.is_some() && *known == action);
        let reward = match known {
            Some((_, reward)) => *reward,
            None => {
                let reward = program.signed_reward_of(self.structure, state, own.as_slice())?;
                let reward = rewards.fractions.number(reward);
                self.known.push((action, reward));
                reward
            }
        };
        rewards.of_choice.push(reward);
        Ok(())
    }
}
