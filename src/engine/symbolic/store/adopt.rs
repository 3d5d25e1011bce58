//! A larger store in the place of another, with its diagrams.

use std::sync::atomic::Ordering::Relaxed;

use ahash::AHashMap;
use oxidd::{Function, HasLevel, InnerNode, Manager, Node};

use super::super::diagram::{Bdd, Diagram};
use super::super::tables::{cache_entries, cache_for_nodes};
use super::Store;
use crate::engine::Settings;
use crate::error::Result;

impl Store {
    /// A store with a larger operation cache, where the diagram of the states is large.
    ///
    /// OxiDD's tables do not grow, and it is the states that tell how much work is to come: the
    /// fixpoints after exploring take hundreds of nodes for each node of theirs.
    pub(in crate::engine::symbolic) fn larger(
        &self,
        states: &Bdd,
        threads: u32,
        settings: &Settings,
    ) -> Option<Self> {
        let wanted = cache_for_nodes(self.size(states));
        if cache_entries(settings.memory, wanted) <= self.cache_entries {
            return None;
        }
        // Where the system gives no more, the one there is will do.
        let larger = Store::sized(self.width(), threads, settings, wanted).ok()?;
        self.note_peak();
        larger.peak.store(self.peak.load(Relaxed), Relaxed);
        larger.work.take_over(&self.work);
        Some(larger)
    }

    /// Puts diagrams of this store in the place of those of another store of the same bits.
    pub(in crate::engine::symbolic) fn adopt_all<'a>(
        &self,
        from: &Store,
        diagrams: impl Iterator<Item = &'a mut Bdd>,
    ) -> Result<()> {
        let mut known = AHashMap::new();
        for f in diagrams {
            *f = self.deep(|| self.adopt(from, f, &mut known))?;
        }
        Ok(())
    }

    /// A diagram of another store; `known` remembers what was taken over of it.
    fn adopt(&self, from: &Store, f: &Bdd, known: &mut AHashMap<Bdd, Bdd>) -> Result<Bdd> {
        let root = from.shared(|m| match m.get_node(f.as_edge(m)) {
            Node::Terminal(_) => None,
            Node::Inner(n) => Some((n.level(), m.handle(n.child(0)), m.handle(n.child(1)))),
        });
        let Some((level, set, clear)) = root else {
            return Ok(if from.is_zero(f) { self.zero() } else { self.one() });
        };
        if let Some(adopted) = known.get(f) {
            return Ok(adopted.clone());
        }
        let (set, clear) = (self.adopt(from, &set, known)?, self.adopt(from, &clear, known)?);
        let node = || {
            self.shared(|m| {
                let made = m.node(level, m.held(set.as_edge(m)), m.held(clear.as_edge(m)))?;
                Ok(m.handle(made.borrowed()))
            })
        };
        let made = self.run(node)?;
        known.insert(f.clone(), made.clone());
        Ok(made)
    }
}
