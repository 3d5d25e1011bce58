//! The bytes of the engine's arrays, against `--memory`.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::error::{Limit, Result};

/// Counts bytes of arrays that are alive; clones count together.
#[derive(Debug, Clone)]
pub(super) struct Meter {
    limit: u64,
    used: Arc<AtomicU64>,
    peak: Arc<AtomicU64>,
    /// States reached so far: for the message where memory ends.
    states: Arc<AtomicU64>,
}

/// Bytes that are given back when it is dropped.
#[derive(Debug)]
pub(super) struct Charge {
    meter: Meter,
    bytes: u64,
}

impl Meter {
    /// A meter that refuses more than `limit` bytes.
    pub(super) fn new(limit: u64) -> Self {
        Meter { limit, used: Arc::default(), peak: Arc::default(), states: Arc::default() }
    }

    /// The bytes alive.
    pub(super) fn used(&self) -> u64 {
        self.used.load(Ordering::Relaxed)
    }

    /// The most bytes that were alive at once.
    pub(super) fn peak(&self) -> u64 {
        self.peak.load(Ordering::Relaxed)
    }

    /// Says how many states have been reached.
    pub(super) fn reached(&self, states: usize) {
        self.states.store(states as u64, Ordering::Relaxed);
    }

    /// Takes bytes for an array.
    ///
    /// # Errors
    /// The limit would be passed.
    pub(super) fn charge(&self, bytes: usize) -> Result<Charge> {
        if self.used() + bytes as u64 > self.limit { Err(self.full().into()) } else { Ok(self.note(bytes)) }
    }

    /// Takes bytes without looking at the limit.
    pub(super) fn note(&self, bytes: usize) -> Charge {
        let before = self.used.fetch_add(bytes as u64, Ordering::Relaxed);
        self.peak.fetch_max(before + bytes as u64, Ordering::Relaxed);
        Charge { meter: self.clone(), bytes: bytes as u64 }
    }

    /// The limit that was hit, with the states reached so far.
    pub(super) fn full(&self) -> Limit {
        let states = self.states.load(Ordering::Relaxed);
        let what = format!(
            "the arrays of the explicit engine would exceed {} bytes, with {states} states reached so far",
            self.limit
        );
        Limit::Memory { what }
    }
}

impl Drop for Charge {
    fn drop(&mut self) {
        self.meter.used.fetch_sub(self.bytes, Ordering::Relaxed);
    }
}

/// A growing array whose capacity is charged.
#[derive(Debug)]
pub(super) struct Array<T> {
    items: Vec<T>,
    charge: Charge,
}

impl<T: Copy> Array<T> {
    /// An empty array.
    pub(super) fn new(meter: &Meter) -> Self {
        Array { items: Vec::new(), charge: meter.note(0) }
    }

    /// `n` times the same item.
    ///
    /// # Errors
    /// The limit would be passed.
    pub(super) fn filled(meter: &Meter, n: usize, item: T) -> Result<Self> {
        let mut array = Array::new(meter);
        array.grow(n)?;
        array.items.resize(n, item);
        Ok(array)
    }

    /// Appends an item.
    ///
    /// # Errors
    /// The limit would be passed.
    #[inline]
    pub(super) fn push(&mut self, item: T) -> Result<()> {
        if self.items.len() == self.items.capacity() {
            self.grow(self.items.len() / 2 + 64)?;
        }
        self.items.push(item);
        Ok(())
    }

    /// Appends several items.
    ///
    /// # Errors
    /// The limit would be passed.
    #[inline]
    pub(super) fn extend(&mut self, items: &[T]) -> Result<()> {
        if self.items.capacity() - self.items.len() < items.len() {
            self.grow(self.items.len() / 2 + 64 + items.len())?;
        }
        self.items.extend_from_slice(items);
        Ok(())
    }

    /// Shortens the array.
    pub(super) fn truncate(&mut self, n: usize) {
        self.items.truncate(n);
    }

    /// The item at the end, taken away.
    pub(super) fn pop(&mut self) -> Option<T> {
        self.items.pop()
    }

    /// Gives back what is not used.
    pub(super) fn shrink(&mut self) {
        self.items.shrink_to_fit();
        self.charge = self.charge.meter.note(self.items.capacity() * size_of::<T>());
    }

    #[cold]
    fn grow(&mut self, more: usize) -> Result<()> {
        let meter = self.charge.meter.clone();
        let bytes = (self.items.len() + more) * size_of::<T>();
        // Large blocks grow in place: the old one is not counted beside the new.
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
