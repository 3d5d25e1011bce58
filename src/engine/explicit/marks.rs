//! The sets that contain a state, and the steps of a state, by its number.

use std::ops::Range;
use std::sync::Arc;

use super::{ExplicitEngine, Space};
use crate::membership::{Membership, Numbers};
use meliora_base::error::Result;
use meliora_space::enabled::Enabled;
use meliora_space::probabilities::Probabilities;
use meliora_space::set::BitSet;

/// The bits of several sets.
pub(super) struct Marks<'e> {
    pub(super) engine: &'e ExplicitEngine,
    pub(super) sets: Vec<BitSet>,
}

impl Membership for Marks<'_> {
    fn of(&self, state: &[i64]) -> Result<u64> {
        let Some(state) = self.engine.number(state) else { return Ok(0) };
        Ok(self.marks(state as u32))
    }

    /// The numbers of the scope `all` have codes of their own.
    fn numbers(&self) -> Option<&dyn Numbers> {
        matches!(*self.engine.space, Space::Indexed(_)).then_some(self as _)
    }
}

impl Numbers for Marks<'_> {
    fn states(&self) -> usize {
        self.engine.graph.states()
    }

    fn number(&self, code: &[u64]) -> Option<u32> {
        self.engine.space.find(code).map(|state| state as u32)
    }

    fn code(&self, number: u32) -> &[u64] {
        match &*self.engine.space {
            Space::Indexed(index) => index.code(number as usize),
            Space::Every(_) => &[],
        }
    }

    fn choices(&self, number: u32) -> Range<usize> {
        self.engine.graph.choices_of(number as usize)
    }

    fn kept_choices(&self) -> Option<&Arc<Enabled>> {
        self.engine.choices.as_ref()
    }

    fn probabilities(&self) -> Option<&Arc<Probabilities>> {
        self.engine.probabilities.as_ref()
    }

    fn marks(&self, number: u32) -> u64 {
        let marks = self.sets.iter().enumerate().map(|(set, x)| u64::from(x.has(number as usize)) << set);
        marks.sum()
    }

    fn successors(&self, choice: usize) -> &[u32] {
        self.engine.graph.successors_of(choice)
    }
}
