//! Copies of the diagrams of another store: a larger one, or one with another order of the bits.

use std::sync::atomic::Ordering::Relaxed;

use oxidd::{Function, HasLevel, InnerNode, LevelNo, Manager, Node};

use super::Store;
use super::diagram::{Bdd, Diagram, Edge, Held, ManagerOf};
use super::tables::cache_entries;
use super::walk::{ByNode, Halt, Pass, Walk};
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

    /// Copies diagrams of another store into this store and replaces them. `level` is the level here of one there.
    ///
    /// Cost: linear in their nodes if no two levels change their order, else that of an operation for each node.
    ///
    /// # Errors
    /// A limit.
    pub(in crate::symbolic) fn adopt_all<'a>(
        &self,
        from: &Store,
        level: impl Fn(LevelNo) -> LevelNo,
        diagrams: impl Iterator<Item = &'a mut Bdd>,
    ) -> Result<()> {
        from.shared(|source| {
            self.walk_to_the_end(Pass::forward(None), |w| {
                let mut adoption = Adoption { source, w, level: &level, known: ByNode::new(self) };
                for f in diagrams {
                    *f = w.m.handle(adoption.adopt(f.as_edge(source))?.borrowed());
                }
                Ok(())
            })
        })
    }
}

/// The diagrams of another manager that have been copied.
struct Adoption<'w, 'from: 'w, 'm, 'id: 'm> {
    source: &'w ManagerOf<'from>,
    w: &'w Walk<'m, 'id>,
    level: &'w dyn Fn(LevelNo) -> LevelNo,
    known: ByNode<'m, 'id>,
}

impl<'w, 'from: 'w, 'm, 'id: 'm> Adoption<'w, 'from, 'm, 'id> {
    fn adopt(&mut self, f: Edge<'_, 'from>) -> Result<Held<'m, 'id>, Halt> {
        let (w, m) = (self.w, self.w.m);
        let Node::Inner(node) = self.source.get_node(f) else {
            return Ok(m.constant(!self.source.is_zero(f)));
        };
        if let Some(adopted) = self.known.get(m, f.node_id()) {
            return Ok(adopted);
        }
        w.tick()?;
        let (set, clear) = (self.adopt(node.child(0))?, self.adopt(node.child(1))?);
        let level = (self.level)(node.level());
        let below = m.level_of(set.borrowed()).min(m.level_of(clear.borrowed()));
        let made = if level < below {
            w.node_on(level, set, clear)?
        } else {
            let bit = w.node_on(level, m.constant(true), m.constant(false))?;
            w.ite(bit.borrowed(), set.borrowed(), clear.borrowed())?
        };
        self.known.insert(m, f.node_id(), &made);
        Ok(made)
    }
}
