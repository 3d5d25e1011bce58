//! The memory of a store outside of OxiDD's node table: relation lists, the tables of recursions, and the values
//! of expressions.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// The bytes of a hash table per byte of its entries, shortly after it has grown.
pub(in crate::symbolic) const BYTES_OF_TABLE: usize = 2;

/// The bytes that are charged at present, and the largest number so far.
#[derive(Default)]
pub(in crate::symbolic) struct Charges {
    now: AtomicU64,
    peak: AtomicU64,
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
