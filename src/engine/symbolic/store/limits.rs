//! The limits of a store: cancellation, memory, and when garbage is collected.

use std::sync::PoisonError;
use std::sync::atomic::Ordering::Relaxed;

use oxidd::Manager;

use super::Store;
use super::diagram::ManagerOf;
use super::tables::{BYTES_PER_NODE, SPARE_NODES};
use meliora_base::error::{Error, Limit, Result};

/// A collection is futile if more than half of the nodes that the memory allows are in use after
/// it, and it freed less than one in this many of them, …
const LEAST_FREED: usize = 64;
/// … and the work ends when this many in a row are futile.
///
/// Each collection visits all nodes and clears the operation cache, which then has to be filled
/// anew. A grid of 64 by 64 cells with 6 items still succeeds in the least memory that its nodes
/// fit into (15 MiB), in 1.4 times the usual time.
const MOST_FUTILE: u32 = 6;

impl Store {
    /// Lets the progress sink cancel the work, collects garbage if enough has gathered, and checks
    /// the memory.
    ///
    /// Nodes are made only by recursions that call this regularly. OxiDD's table has room for all of
    /// them, so that it is never full and OxiDD never collects garbage next to this store.
    ///
    /// # Errors
    /// The limit of the progress sink, or the memory.
    pub(in crate::symbolic) fn check_limits(&self, m: &ManagerOf<'_>) -> Result<()> {
        if let Some(limit) = self.sink.stop() {
            return Err(limit.into());
        }
        self.check_memory(m)
    }

    /// Collects garbage if enough has gathered, and checks the memory.
    ///
    /// # Errors
    /// The memory.
    pub(in crate::symbolic) fn check_memory(&self, m: &ManagerOf<'_>) -> Result<()> {
        if self.has_reached(m, self.trigger()) {
            self.collect(m)?;
        }
        // OxiDD does not return the memory of freed nodes to the system.
        let is_over = || self.peak.load(Relaxed) > self.most_nodes();
        if is_over() {
            // Entries in use are kept.
            self.forget();
        }
        if is_over() { Err(self.full()) } else { Ok(()) }
    }

    /// Collects garbage, unless another thread has just done so.
    fn collect(&self, m: &ManagerOf<'_>) -> Result<()> {
        let mut futile = self.futile.lock().unwrap_or_else(PoisonError::into_inner);
        let (before, most) = (m.num_inner_nodes(), self.most_nodes());
        if before < self.trigger() {
            return Ok(());
        }
        if before >= most {
            self.forget();
        }
        self.note_peak(before);
        m.gc();
        self.work.collections.fetch_add(1, Relaxed);
        let live = m.num_inner_nodes();
        // Collect again at twice the live nodes (at least the threshold); earlier if room is short.
        let next = (2 * live).max(self.thresholds.first_collection);
        let room = live + most.saturating_sub(live) / 2;
        self.collect_at.store(next.min(room.max(1)), Relaxed);
        let is_futile = live > most / 2 && before.saturating_sub(live) < most / LEAST_FREED;
        *futile = if is_futile { *futile + 1 } else { 0 };
        if live >= most || *futile >= MOST_FUTILE { Err(self.full()) } else { Ok(()) }
    }

    /// Returns the number of nodes at which garbage is collected.
    fn trigger(&self) -> usize {
        self.collect_at.load(Relaxed).min(self.most_nodes())
    }

    /// Returns the number of nodes that the memory allows in addition to the charged bytes.
    fn most_nodes(&self) -> usize {
        let nodes = self.memory.load(Relaxed).saturating_sub(self.charges.now()) / BYTES_PER_NODE;
        nodes.min(self.capacity) as usize
    }

    /// Returns true if the table has at least `many` nodes.
    fn has_reached(&self, m: &ManagerOf<'_>, many: usize) -> bool {
        // The approximate number lags behind by less than the spare nodes.
        let approximate = m.approx_num_inner_nodes();
        let far = approximate + (SPARE_NODES as usize) < many;
        let nodes = if far { approximate } else { m.num_inner_nodes() };
        self.note_peak(nodes);
        nodes >= many
    }

    pub(in crate::symbolic) fn note_peak(&self, nodes: usize) {
        self.peak.fetch_max(nodes, Relaxed);
    }

    /// Returns the error for memory that does not suffice.
    pub(in crate::symbolic) fn full(&self) -> Error {
        let charged = self.charges.now();
        let what = if charged < self.memory.load(Relaxed) / 8 {
            format!("the node table of {} nodes is full", self.capacity)
        } else {
            let (nodes, mib) = (self.peak.load(Relaxed), charged >> 20);
            format!("{nodes} nodes, and {mib} MiB of relation lists and intermediate results")
        };
        Limit::Memory { what }.into()
    }
}
