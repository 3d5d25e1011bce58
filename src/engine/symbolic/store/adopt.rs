//! Replacement of a store by a larger one, with its diagrams.

use std::sync::atomic::Ordering::Relaxed;

use oxidd::{Function, HasLevel, InnerNode, Manager, Node};

use super::Store;
use super::diagram::{Bdd, Diagram, Edge, Held, ManagerOf};
use super::tables::cache_entries;
use super::walk::{ByNode, PATIENCE};
use crate::settings::Settings;
use meliora_base::error::Result;

impl Store {
    /// Creates a store with an operation cache of `entries` entries. Returns `None` if this store has as many, or if the system does not
    /// grant the memory. A new store is needed because OxiDD's tables do not grow.
    pub(in crate::symbolic) fn larger(&self, entries: u64, settings: &Settings) -> Option<Self> {
        if cache_entries(settings.memory, entries) <= self.cache_entries {
            return None;
        }
        // If the system does not grant more, this store continues.
        let mut larger = Store::sized(self.width(), settings, entries).ok()?;
        self.note_peak(self.nodes());
        larger.replaced_peak = self.peak.load(Relaxed).max(self.replaced_peak);
        larger.work.add(&self.work);
        Some(larger)
    }

    /// Copies diagrams of another store of the same bits into this store and replaces them. The
    /// copying checks the memory, but cannot be cancelled.
    ///
    /// Cost: linear in their nodes.
    pub(in crate::symbolic) fn adopt_all<'a>(
        &self,
        from: &Store,
        diagrams: impl Iterator<Item = &'a mut Bdd>,
    ) -> Result<()> {
        from.shared(|source| {
            self.shared(|m| {
                let mut adoption = Adoption { source, store: self, m, known: ByNode::new(self), steps: 0 };
                self.deep(|| {
                    for f in diagrams {
                        *f = m.handle(adoption.adopt(f.as_edge(source))?.borrowed());
                    }
                    Ok(())
                })
            })
        })
    }
}

/// The diagrams of another manager that have been copied.
struct Adoption<'w, 'from: 'w, 'm, 'id: 'm> {
    source: &'w ManagerOf<'from>,
    store: &'m Store,
    m: &'m ManagerOf<'id>,
    known: ByNode<'m, 'id>,
    steps: u64,
}

impl<'w, 'from: 'w, 'm, 'id: 'm> Adoption<'w, 'from, 'm, 'id> {
    fn adopt(&mut self, f: Edge<'_, 'from>) -> Result<Held<'m, 'id>> {
        let (store, m) = (self.store, self.m);
        let Node::Inner(node) = self.source.get_node(f) else {
            return Ok(m.constant(!self.source.is_zero(f)));
        };
        if let Some(adopted) = self.known.get(m, f.node_id()) {
            return Ok(adopted);
        }
        if self.steps.is_multiple_of(PATIENCE) {
            store.check_memory(m)?;
        }
        self.steps += 1;
        let (set, clear) = (self.adopt(node.child(0))?, self.adopt(node.child(1))?);
        let made = m.node(node.level(), set, clear).map_err(|_| store.full())?;
        self.known.insert(m, f.node_id(), &made);
        Ok(made)
    }
}
