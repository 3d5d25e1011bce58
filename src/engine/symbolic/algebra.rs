//! The Boolean algebra of both sorts: one diagram for a set of states, one per group for a set of
//! choices.

use std::sync::Arc;

use super::diagram::Bdd;
use super::{ChoiceSet, StateSet, SymbolicEngine};
use crate::engine::{Algebra, Count};
use crate::error::Result;

impl Algebra<StateSet> for SymbolicEngine {
    fn union(&self, x: &StateSet, y: &StateSet) -> Result<StateSet> {
        Ok(StateSet(self.store.or(&x.0, &y.0)?))
    }

    fn intersection(&self, x: &StateSet, y: &StateSet) -> Result<StateSet> {
        Ok(StateSet(self.store.and(&x.0, &y.0)?))
    }

    fn difference(&self, x: &StateSet, y: &StateSet) -> Result<StateSet> {
        Ok(StateSet(self.store.minus(&x.0, &y.0)?))
    }

    fn is_empty(&self, x: &StateSet) -> bool {
        self.store.is_zero(&x.0)
    }

    fn same(&self, x: &StateSet, y: &StateSet) -> bool {
        x.0 == y.0
    }

    fn count(&self, x: &StateSet) -> Result<Count> {
        self.store.count(&x.0, self.encoding.width() as u32)
    }
}

impl Algebra<ChoiceSet> for SymbolicEngine {
    fn union(&self, c: &ChoiceSet, d: &ChoiceSet) -> Result<ChoiceSet> {
        zip(c, d, |f, g| self.store.or(f, g))
    }

    fn intersection(&self, c: &ChoiceSet, d: &ChoiceSet) -> Result<ChoiceSet> {
        zip(c, d, |f, g| self.store.and(f, g))
    }

    fn difference(&self, c: &ChoiceSet, d: &ChoiceSet) -> Result<ChoiceSet> {
        zip(c, d, |f, g| self.store.minus(f, g))
    }

    fn is_empty(&self, c: &ChoiceSet) -> bool {
        c.0.iter().all(|f| self.store.is_zero(f))
    }

    fn same(&self, c: &ChoiceSet, d: &ChoiceSet) -> bool {
        c.0 == d.0
    }

    fn count(&self, c: &ChoiceSet) -> Result<Count> {
        c.0.iter().map(|f| self.store.count(f, self.encoding.width() as u32)).sum()
    }
}

/// Computes `op(C, D)` for each group.
fn zip(c: &ChoiceSet, d: &ChoiceSet, op: impl Fn(&Bdd, &Bdd) -> Result<Bdd>) -> Result<ChoiceSet> {
    let both = c.0.iter().zip(d.0.iter()).map(|(f, g)| op(f, g));
    Ok(ChoiceSet(Arc::new(both.collect::<Result<_>>()?)))
}
