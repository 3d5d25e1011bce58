//! The successors of several states, whose numbers are looked up together.

use super::explore::PATIENCE;
use super::graph::Graph;
use super::lookup::Lookup;
use super::states::Space;
use super::stepper::{Stepper, sum};
use meliora_base::error::Result;

/// Maximum number of states of a batch.
const STATES: usize = 16;

/// The successors of some states that follow each other.
pub(crate) struct Batch<const W: usize> {
    codes: Vec<[u64; W]>,
    /// The end of each choice in `codes`.
    choices: Vec<u32>,
    /// The end of each state in `choices`.
    states: Vec<u32>,
    numbers: Vec<u32>,
    lookup: Lookup<W>,
}

impl<const W: usize> Batch<W> {
    /// Begins without states.
    pub(crate) fn new() -> Self {
        let (codes, choices, states, numbers) = Default::default();
        Batch { codes, choices, states, numbers, lookup: Lookup::new() }
    }

    /// Returns whether no state should be added.
    #[inline]
    pub(crate) fn is_full(&self) -> bool {
        self.states.len() >= STATES || self.codes.len() >= PATIENCE
    }

    /// Adds the successors of the current state of the stepper, given its code. A deadlock stays.
    #[inline]
    pub(crate) fn add(&mut self, stepper: &Stepper<'_, W>, code: &[u64; W]) {
        let before = self.codes.len() as u32;
        self.codes.extend(stepper.steps.iter().map(|step| sum(code, step)));
        self.choices.extend(stepper.ends.iter().map(|end| before + end));
        if stepper.ends.is_empty() {
            self.codes.push(*code);
            self.choices.push(before + 1);
        }
        self.states.push(self.choices.len() as u32);
    }

    /// Returns the numbers of the successors, new ones for those that are new, and the end of each choice among them.
    ///
    /// # Errors
    /// The memory limit or the maximum number of states is reached.
    pub(crate) fn look_up(&mut self, space: &mut Space) -> Result<(&[u32], &[u32])> {
        match space {
            Space::Indexed(index) => self.lookup.numbers(index, &self.codes, &mut self.numbers)?,
            Space::Every(_) => {
                self.numbers.clear();
                self.numbers.extend(self.codes.iter().map(|code| code[0] as u32));
            }
        }
        Ok((&self.numbers, &self.choices))
    }

    /// Moves the states to the graph.
    ///
    /// # Errors
    /// The memory limit or the maximum number of states is reached.
    pub(crate) fn finish(&mut self, space: &mut Space, graph: &mut Graph) -> Result<()> {
        self.look_up(space)?;
        let (mut at, mut choice) = (0, 0);
        for &end in &self.states {
            for &until in &self.choices[choice..end as usize] {
                graph.extend(&self.numbers[at..until as usize])?;
                graph.end_choice()?;
                at = until as usize;
            }
            choice = end as usize;
            graph.end_state()?;
        }
        self.clear();
        Ok(())
    }

    /// Removes the states.
    pub(crate) fn clear(&mut self) {
        self.codes.clear();
        self.choices.clear();
        self.states.clear();
    }
}
