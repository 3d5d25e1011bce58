//! An engine of the same states with the bits in another order, and copies of sets.

use std::sync::Arc;

use super::build::Explored;
use super::order::{Bit, Order, candidates};
use super::store::Store;
use super::store::diagram::Bdd;
use super::{ChoiceSet, Encoding, StateSet, SymbolicEngine};
use crate::settings::Settings;
use meliora_base::error::Result;

impl SymbolicEngine {
    /// Returns the order of this engine and the others of [`candidates`]; the first alone if the user has given it.
    pub(crate) fn orders(&self) -> Vec<Vec<Bit>> {
        let mut orders = vec![self.encoding.order().to_vec()];
        if self.settings.order == Order::Auto {
            let others = candidates(&self.program, false).into_iter().map(|order| order.bits);
            orders.extend(others.filter(|order| order != self.encoding.order()));
        }
        orders
    }

    /// Creates an engine of all states of this one's model, with the bits in another order and in a store of its own.
    /// Both number the groups of choices in the same way, since these depend on the guards alone.
    ///
    /// Cost: a translation of the program, and a copy of the states.
    ///
    /// # Errors
    /// A limit.
    pub(crate) fn reordered(&self, bits: &[Bit], settings: Settings) -> Result<Self> {
        let (bits, program) = (bits.to_vec(), Arc::clone(&self.program));
        let encoding = Encoding::new(&program, bits.clone());
        let copy = |store: &Store| {
            let mut states = [self.states.0.clone()];
            copy_all(store, &encoding, self, &mut states)?;
            let [states] = states;
            Ok(states)
        };
        let settings = Settings { order: Order::Bits(bits.clone()), ..settings };
        Explored::with(program, bits, settings, Some(&copy))?.engine()
    }

    /// Lowers the memory limit, unless more has been used. Returns whether it is at most this one now.
    pub(crate) fn limit_to(&self, memory: u64) -> bool {
        self.store.limit_to(memory)
    }

    /// Returns whether a set is one of this engine.
    pub(crate) fn owns(&self, x: &StateSet) -> bool {
        self.diagram_of(x).is_ok()
    }

    /// Returns whether a set is one of this engine.
    pub(crate) fn owns_choices(&self, c: &ChoiceSet) -> bool {
        self.diagrams_of(c).is_ok()
    }

    /// Returns the set of the same states as one of another engine for the model. Cost: see [`Store::adopt_all`].
    ///
    /// # Errors
    /// A limit.
    pub(crate) fn copied(&self, from: &SymbolicEngine, x: &StateSet) -> Result<StateSet> {
        let mut copy = [from.diagram_of(x)?.clone()];
        copy_all(&self.store, &self.encoding, from, &mut copy)?;
        let [copy] = copy;
        Ok(StateSet(copy))
    }

    /// Returns the set of the same pairs as one of another engine for the model. Cost: see [`Store::adopt_all`].
    ///
    /// # Errors
    /// A limit.
    pub(crate) fn copied_choices(&self, from: &SymbolicEngine, c: &ChoiceSet) -> Result<ChoiceSet> {
        let mut copies = from.groups_of(c)?.to_vec();
        copy_all(&self.store, &self.encoding, from, &mut copies)?;
        Ok(ChoiceSet(Arc::new(copies)))
    }
}

/// Copies diagrams over the present bits from another engine's store, with the bits at the levels of an encoding.
fn copy_all(store: &Store, encoding: &Encoding, from: &SymbolicEngine, diagrams: &mut [Bdd]) -> Result<()> {
    let order = from.encoding.order();
    let level = |level: u32| {
        let bit = order[level as usize / 2];
        2 * encoding.positions(bit.variable)[bit.index as usize]
    };
    store.adopt_all(&from.store, level, diagrams.iter_mut())
}
