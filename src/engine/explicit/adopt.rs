//! Sets of the symbolic engine as sets of the explicit one, for the same model.

use super::explore::by_words;
use super::meter::Array;
use super::set::{BitSet, set};
use super::stepper::Stepper;
use super::{ChoiceSet, ExplicitEngine, StateSet};
use crate::membership::Membership;
use meliora_base::error::Result;
use meliora_model::CommandId;
use meliora_model::step::Choice;

/// The group of each pair of a state and a choice: a number that the choice alone determines.
pub(crate) struct Groups(Array<u32>);

/// The pairs of some groups that a set has, by their states.
pub(crate) struct PartOfGroups<'e> {
    /// The groups.
    pub(crate) groups: Vec<usize>,
    /// The states in which the set has each of them.
    pub(crate) test: Box<dyn Membership + 'e>,
}

impl ExplicitEngine {
    /// Numbers the choices of all states by a function of the choice. Cost: that of listing the choices of each state.
    ///
    /// # Errors
    /// A limit.
    pub(crate) fn group(&self, of: &mut dyn FnMut(&Choice) -> u32) -> Result<Groups> {
        by_words!(self, group_by_words(of))
    }

    fn words(&self) -> usize {
        self.layout.words()
    }

    fn group_by_words<const W: usize>(&self, of: &mut dyn FnMut(&Choice) -> u32) -> Result<Groups> {
        let mut groups = Array::filled(&self.meter, self.graph.choices(), 0)?;
        let mut stepper = Stepper::<W>::new(&self.prepared);
        for state in 0..self.graph.states() {
            self.tick()?;
            let own = &mut groups[self.graph.choices_of(state)];
            // With monitors, the self-loop of a deadlock is a command of theirs.
            if self.deadlocks.has(state) && self.prepared.alone.is_none() {
                own.fill(of(&Choice::Deadlock));
                continue;
            }
            if self.prepared.uniform {
                own.fill(of(&Choice::Uniform));
                continue;
            }
            self.with_code(state, |code| stepper.enter(&self.layout, code));
            stepper.expand().map_err(|broken| broken.error(&self.program, &self.values(state)))?;
            let mut own = own.iter_mut();
            for &synchronisation in &stepper.active {
                for number in 0..stepper.combinations(synchronisation) {
                    let commands = stepper.combination(synchronisation, number);
                    let commands = commands.into_iter().map(CommandId).collect();
                    let choice = Choice::Combination { synchronisation, commands };
                    own.next().into_iter().for_each(|group| *group = of(&choice));
                }
            }
        }
        Ok(Groups(groups))
    }

    /// Returns the states of the model that pass a test.
    ///
    /// # Errors
    /// A limit.
    pub(crate) fn adopt_states(&self, test: &dyn Membership) -> Result<StateSet> {
        let mut found = BitSet::empty(&self.meter, self.graph.states());
        let words = found.words_mut();
        self.each_state(&mut |state, values| {
            if test.of(values)? != 0 {
                set(words, state);
            }
            Ok(())
        })?;
        Ok(StateSet(found))
    }

    /// Returns the pairs of some whole groups, and of parts of others.
    ///
    /// # Errors
    /// A limit.
    pub(crate) fn adopt_choices(
        &self,
        groups: &Groups,
        whole: &[bool],
        parts: &[PartOfGroups<'_>],
    ) -> Result<ChoiceSet> {
        let mut found = BitSet::empty(&self.meter, self.graph.choices());
        let words = found.words_mut();
        for (choice, &group) in groups.0.iter().enumerate() {
            if whole[group as usize] {
                set(words, choice);
            }
        }
        for part in parts {
            let mut mark = vec![0_u64; whole.len()];
            part.groups.iter().enumerate().for_each(|(place, &group)| mark[group] = 1 << place);
            self.each_state(&mut |state, values| {
                let own = self.graph.choices_of(state);
                if groups.0[own.clone()].iter().all(|&group| mark[group as usize] == 0) {
                    return Ok(());
                }
                let marks = part.test.of(values)?;
                for choice in own.filter(|&choice| marks & mark[groups.0[choice] as usize] != 0) {
                    set(words, choice);
                }
                Ok(())
            })?;
        }
        Ok(ChoiceSet(found))
    }

    fn each_state(&self, each: &mut dyn FnMut(usize, &[i64]) -> Result<()>) -> Result<()> {
        let mut values = vec![0; self.program.variables.len()];
        for state in 0..self.graph.states() {
            self.tick()?;
            self.with_code(state, |code| self.layout.decode(code, &mut values));
            each(state, &values)?;
        }
        Ok(())
    }
}
