//! The memory of the stores of an engine and its workers, which is one budget: the nodes of all
//! stores and, outside of OxiDD's node tables, relation lists, the tables of recursions, the values
//! of expressions, and the operation caches of workers.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// The bytes of a hash table per byte of its entries, shortly after it has grown.
pub(in crate::symbolic) const BYTES_OF_TABLE: usize = 2;

/// The bytes that are charged at present, and the largest number so far; the same for the nodes of
/// all stores. A store keeps the memory of its largest number of nodes, so that number counts.
#[derive(Default)]
pub(in crate::symbolic) struct Charges {
    now: AtomicU64,
    peak: AtomicU64,
    nodes: AtomicU64,
    peak_nodes: AtomicU64,
}

impl Charges {
    /// Returns the bytes that are charged at present.
    pub(in crate::symbolic) fn now(&self) -> u64 {
        self.now.load(Relaxed)
    }

    /// Returns the largest number of bytes charged at once.
    pub(in crate::symbolic) fn peak(&self) -> u64 {
        self.peak.load(Relaxed)
    }

    /// Returns the largest number of nodes of all stores at once.
    pub(in crate::symbolic) fn peak_nodes(&self) -> u64 {
        self.peak_nodes.load(Relaxed)
    }

    /// Returns the nodes of all stores except for one with `own` nodes.
    pub(in crate::symbolic) fn other_nodes(&self, own: usize) -> u64 {
        self.nodes.load(Relaxed).saturating_sub(own as u64)
    }

    /// Adds nodes of a store.
    pub(in crate::symbolic) fn add_nodes(&self, nodes: usize) {
        let now = self.nodes.fetch_add(nodes as u64, Relaxed) + nodes as u64;
        self.peak_nodes.fetch_max(now, Relaxed);
    }

    /// Releases the nodes of a store.
    pub(in crate::symbolic) fn release_nodes(&self, nodes: usize) {
        self.nodes.fetch_sub(nodes as u64, Relaxed);
    }
}

/// Some bytes that are charged while this value exists.
pub(in crate::symbolic) struct Charge {
    charges: Arc<Charges>,
    bytes: u64,
}

impl Charge {
    /// Charges nothing yet.
    pub(in crate::symbolic) fn new(charges: &Arc<Charges>) -> Self {
        Charge { charges: Arc::clone(charges), bytes: 0 }
    }

    /// Charges more bytes.
    pub(in crate::symbolic) fn add(&mut self, bytes: usize) {
        self.bytes += bytes as u64;
        let now = self.charges.now.fetch_add(bytes as u64, Relaxed) + bytes as u64;
        self.charges.peak.fetch_max(now, Relaxed);
    }
}

impl Drop for Charge {
    fn drop(&mut self) {
        self.charges.now.fetch_sub(self.bytes, Relaxed);
    }
}
