//! Memory accounting: the bytes of the engine's arrays, limited by `--memory`.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use meliora_base::error::{Limit, Result};

/// A counter of the bytes of live arrays; clones share the counter.
#[derive(Debug, Clone)]
pub struct Meter {
    limit: Arc<AtomicU64>,
    used: Arc<AtomicU64>,
    peak: Arc<AtomicU64>,
    /// The number of states reached so far, for the message about the memory limit.
    states: Arc<AtomicU64>,
}

/// Bytes that are released on drop.
#[derive(Debug)]
pub struct Charge {
    meter: Meter,
    bytes: u64,
}

impl Meter {
    /// Creates a meter that refuses more than `limit` bytes.
    pub fn new(limit: u64) -> Self {
        let limit = Arc::new(AtomicU64::new(limit));
        Meter { limit, used: Arc::default(), peak: Arc::default(), states: Arc::default() }
    }

    /// Sets the limit of the meter and of its clones.
    pub fn set_limit(&self, limit: u64) {
        self.limit.store(limit, Ordering::Relaxed);
    }

    fn limit(&self) -> u64 {
        self.limit.load(Ordering::Relaxed)
    }

    /// Returns whether both are clones of one meter.
    pub fn is(&self, other: &Meter) -> bool {
        Arc::ptr_eq(&self.used, &other.used)
    }

    /// Returns the number of live bytes.
    pub fn used(&self) -> u64 {
        self.used.load(Ordering::Relaxed)
    }

    /// Returns the largest number of bytes that were live at the same time.
    pub fn peak(&self) -> u64 {
        self.peak.load(Ordering::Relaxed)
    }

    /// Records the number of states reached.
    pub fn reached(&self, states: usize) {
        self.states.store(states as u64, Ordering::Relaxed);
    }

    /// Charges bytes for an array.
    ///
    /// # Errors
    /// The memory limit is reached.
    pub fn charge(&self, bytes: usize) -> Result<Charge> {
        if self.used() + bytes as u64 > self.limit() { Err(self.full().into()) } else { Ok(self.note(bytes)) }
    }

    /// Charges bytes without checking the limit.
    pub fn note(&self, bytes: usize) -> Charge {
        let before = self.used.fetch_add(bytes as u64, Ordering::Relaxed);
        self.peak.fetch_max(before + bytes as u64, Ordering::Relaxed);
        Charge { meter: self.clone(), bytes: bytes as u64 }
    }

    /// Returns the error for the memory limit, with the number of states reached so far.
    pub fn full(&self) -> Limit {
        let states = self.states.load(Ordering::Relaxed);
        let what = format!(
            "the arrays of the explicit engine would exceed {} bytes, with {states} states reached so far",
            self.limit()
        );
        Limit::Memory { what }
    }
}

impl Drop for Charge {
    fn drop(&mut self) {
        self.meter.used.fetch_sub(self.bytes, Ordering::Relaxed);
    }
}

/// A growing array whose capacity is charged to a meter.
#[derive(Debug)]
pub struct Array<T> {
    items: Vec<T>,
    charge: Charge,
}

impl<T: Copy> Array<T> {
    /// Creates an empty array.
    pub fn new(meter: &Meter) -> Self {
        Array { items: Vec::new(), charge: meter.note(0) }
    }

    /// Creates an array of `n` copies of an item.
    ///
    /// # Errors
    /// The memory limit is reached.
    pub fn filled(meter: &Meter, n: usize, item: T) -> Result<Self> {
        let mut array = Array::new(meter);
        array.grow(n)?;
        array.items.resize(n, item);
        Ok(array)
    }

    /// Appends an item.
    ///
    /// # Errors
    /// The memory limit is reached.
    #[inline]
    pub fn push(&mut self, item: T) -> Result<()> {
        if self.items.len() == self.items.capacity() {
            self.grow(self.items.len() / 2 + 64)?;
        }
        self.items.push(item);
        Ok(())
    }

    /// Appends several items.
    ///
    /// # Errors
    /// The memory limit is reached.
    #[inline]
    pub fn extend(&mut self, items: &[T]) -> Result<()> {
        if self.items.capacity() - self.items.len() < items.len() {
            self.grow((self.items.len() / 2 + 64).max(items.len()))?;
        }
        self.items.extend_from_slice(items);
        Ok(())
    }

    /// Shortens the array.
    pub fn truncate(&mut self, n: usize) {
        self.items.truncate(n);
    }

    /// Frees unused capacity.
    pub fn shrink(&mut self) {
        self.items.shrink_to_fit();
        self.charge = self.charge.meter.note(self.items.capacity() * size_of::<T>());
    }

    #[cold]
    fn grow(&mut self, more: usize) -> Result<()> {
        let meter = self.charge.meter.clone();
        let bytes = (self.items.len() + more) * size_of::<T>();
        // Large blocks grow in place, so the old block is not counted in addition to the new one.
        let old = std::mem::replace(&mut self.charge, meter.note(0));
        drop(old);
        self.charge = meter.charge(bytes)?;
        self.items.try_reserve_exact(more).map_err(|_| meter.full())?;
        Ok(())
    }
}

impl<T> std::ops::Deref for Array<T> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        &self.items
    }
}

impl<T> std::ops::DerefMut for Array<T> {
    fn deref_mut(&mut self) -> &mut [T] {
        &mut self.items
    }
}
