//! The Boolean algebra of both sorts: one diagram for a set of states, one per group for a set of
//! choices. Every operation checks that its sets are diagrams of the engine's own store.

use std::sync::Arc;

use super::store::Store;
use super::store::diagram::Bdd;
use super::{ChoiceSet, StateSet, SymbolicEngine};
use crate::edge_labels::EdgeLabels;
use crate::engine::Algebra;
use crate::settings::Count;
use meliora_base::error::{Error, Result, ensure};

impl SymbolicEngine {
    /// Returns the diagram of a set of this engine.
    ///
    /// # Errors
    /// The set belongs to another engine.
    pub(super) fn diagram_of<'s>(&self, x: &'s StateSet) -> Result<&'s Bdd> {
        if self.store.owns(&x.0) { Ok(&x.0) } else { Err(Error::ForeignSet) }
    }

    /// Returns the diagrams of a set of this engine, one per group.
    ///
    /// # Errors
    /// The set belongs to another engine.
    pub(super) fn diagrams_of<'s>(&self, c: &'s ChoiceSet) -> Result<&'s [Bdd]> {
        // One engine made all diagrams of a set.
        let own = c.0.first().is_none_or(|f| self.store.owns(f));
        if own { Ok(&c.0) } else { Err(Error::ForeignSet) }
    }

    /// Returns the diagrams of a set of this engine that has one diagram per group. A set that was
    /// read from a dump may have another number.
    ///
    /// # Errors
    /// The set belongs to another engine, or has another number of diagrams.
    pub(super) fn groups_of<'s>(&self, c: &'s ChoiceSet) -> Result<&'s [Bdd]> {
        let diagrams = self.diagrams_of(c)?;
        check_numbers(diagrams.len(), self.enabled.len())?;
        Ok(diagrams)
    }

    /// Checks that edge labels have sets of this engine only.
    ///
    /// # Errors
    /// A set belongs to another engine.
    pub(super) fn check_owned(&self, edge_labels: &[EdgeLabels<StateSet>]) -> Result<()> {
        let mut sets = edge_labels.iter().flat_map(EdgeLabels::sets);
        sets.try_for_each(|x| self.diagram_of(x).map(drop))
    }

    /// Computes `op(C, D)` for each group.
    fn zip(
        &self,
        c: &ChoiceSet,
        d: &ChoiceSet,
        op: impl Fn(&Store, &Bdd, &Bdd) -> Result<Bdd>,
    ) -> Result<ChoiceSet> {
        let (c, d) = (self.diagrams_of(c)?, self.diagrams_of(d)?);
        check_numbers(c.len(), d.len())?;
        let found = c.iter().zip(d).map(|(f, g)| op(&self.store, f, g));
        Ok(ChoiceSet(Arc::new(found.collect::<Result<_>>()?)))
    }
}

/// Checks that a set of choices has as many numbers as the one that it is used with.
fn check_numbers(found: usize, expected: usize) -> Result<()> {
    ensure(found == expected, || {
        Error::Usage(format!("a set of choices with {found} numbers is used where {expected} are expected"))
    })
}

impl Algebra<StateSet> for SymbolicEngine {
    fn union(&self, x: &StateSet, y: &StateSet) -> Result<StateSet> {
        Ok(StateSet(self.store.or(self.diagram_of(x)?, self.diagram_of(y)?)?))
    }

    fn intersection(&self, x: &StateSet, y: &StateSet) -> Result<StateSet> {
        Ok(StateSet(self.store.and(self.diagram_of(x)?, self.diagram_of(y)?)?))
    }

    fn difference(&self, x: &StateSet, y: &StateSet) -> Result<StateSet> {
        Ok(StateSet(self.store.minus(self.diagram_of(x)?, self.diagram_of(y)?)?))
    }

    fn is_empty(&self, x: &StateSet) -> Result<bool> {
        Ok(self.store.is_zero(self.diagram_of(x)?))
    }

    fn same(&self, x: &StateSet, y: &StateSet) -> Result<bool> {
        Ok(self.diagram_of(x)? == self.diagram_of(y)?)
    }

    fn count(&self, x: &StateSet) -> Result<Count> {
        self.store.count(self.diagram_of(x)?, self.encoding.width() as u32)
    }
}

impl Algebra<ChoiceSet> for SymbolicEngine {
    fn union(&self, c: &ChoiceSet, d: &ChoiceSet) -> Result<ChoiceSet> {
        self.zip(c, d, Store::or)
    }

    fn intersection(&self, c: &ChoiceSet, d: &ChoiceSet) -> Result<ChoiceSet> {
        self.zip(c, d, Store::and)
    }

    fn difference(&self, c: &ChoiceSet, d: &ChoiceSet) -> Result<ChoiceSet> {
        self.zip(c, d, Store::minus)
    }

    fn is_empty(&self, c: &ChoiceSet) -> Result<bool> {
        Ok(self.diagrams_of(c)?.iter().all(|f| self.store.is_zero(f)))
    }

    fn same(&self, c: &ChoiceSet, d: &ChoiceSet) -> Result<bool> {
        let (c, d) = (self.diagrams_of(c)?, self.diagrams_of(d)?);
        check_numbers(c.len(), d.len())?;
        Ok(c == d)
    }

    fn count(&self, c: &ChoiceSet) -> Result<Count> {
        self.diagrams_of(c)?.iter().map(|f| self.store.count(f, self.encoding.width() as u32)).sum()
    }
}
