//! Replacement of a store by a larger one, with its diagrams.

use std::sync::atomic::Ordering::Relaxed;

use oxidd::{Function, HasLevel, InnerNode, Manager, Node};

use super::super::diagram::{Bdd, Diagram, Edge, Held, ManagerOf};
use super::super::tables::{cache_entries, cache_for_bits};
use super::super::walk::{ByNode, Direction, Halt, Walk};
use super::Store;
use crate::engine::Settings;
use crate::error::Result;

impl Store {
    /// Creates a store with an operation cache of `entries` entries, or fewer if fewer suffice for
    /// the bits of a state. Returns `None` if this store has as many, or if the system does not
    /// grant the memory. A new store is needed because OxiDD's tables do not grow.
    pub(in crate::engine::symbolic) fn larger(&self, entries: u64, settings: &Settings) -> Option<Self> {
        let wanted = entries.min(cache_for_bits(self.width()));
        if cache_entries(settings.memory, wanted) <= self.cache_entries {
            return None;
        }
        // If the system does not grant more, this store continues.
        let mut larger = Store::sized(self.width(), settings, wanted).ok()?;
        self.note_peak(self.nodes());
        larger.replaced_peak = self.peak.load(Relaxed).max(self.replaced_peak);
        larger.work.take_over(&self.work);
        Some(larger)
    }

    /// Copies diagrams of another store of the same bits into this store and replaces them.
    ///
    /// Cost: linear in their nodes.
    pub(in crate::engine::symbolic) fn adopt_all<'a>(
        &self,
        from: &Store,
        diagrams: impl Iterator<Item = &'a mut Bdd>,
    ) -> Result<()> {
        from.shared(|source| {
            self.walk_to_the_end((Direction::Forward, None), |walk| {
                let mut adoption = Adoption { source, walk, known: ByNode::new(self) };
                for f in diagrams {
                    *f = walk.own(|_| adoption.adopt(f.as_edge(source)))?;
                }
                Ok(())
            })
        })
    }
}

/// The diagrams of another manager that have been copied.
struct Adoption<'w, 'from: 'w, 'm, 'id: 'm> {
    source: &'w ManagerOf<'from>,
    walk: &'w Walk<'m, 'id>,
    known: ByNode<'m, 'id>,
}

impl<'w, 'from: 'w, 'm, 'id: 'm> Adoption<'w, 'from, 'm, 'id> {
    fn adopt(&mut self, f: Edge<'_, 'from>) -> Result<Held<'m, 'id>, Halt> {
        let Walk { store, m, .. } = *self.walk;
        let Node::Inner(node) = self.source.get_node(f) else {
            let constant = if self.source.is_zero(f) { store.zero() } else { store.one() };
            return Ok(m.held(constant.as_edge(m)));
        };
        if let Some(adopted) = self.known.get(m, f.node_id()) {
            return Ok(adopted);
        }
        self.walk.tick()?;
        let (set, clear) = (self.adopt(node.child(0))?, self.adopt(node.child(1))?);
        let made = self.walk.node_on(node.level(), set, clear)?;
        self.known.insert(m, f.node_id(), &made);
        Ok(made)
    }
}
