//! Sets of states and sets of choices: one bit per number.
//!
//! Operations work on words. Those of `bitvec` 1.1 work bit by bit: on 10^6 bits, a union takes 1.2 ms
//! in place of 6 µs, and a list of the members 28 ms in place of 36 µs; counting takes the same time.

use std::sync::Arc;

use bitvec::prelude::{BitVec, Lsb0};

use super::meter::{Charge, Meter};
use meliora_base::error::Result;

/// A set of numbers below a fixed size. Bits past the size are always 0.
///
/// Clones share their bits until one of them is modified.
#[derive(Debug, Clone)]
pub struct BitSet(Arc<Charged>);

#[derive(Debug)]
struct Charged {
    bits: BitVec<u64, Lsb0>,
    _charge: Charge,
    meter: Meter,
}

impl Clone for Charged {
    fn clone(&self) -> Self {
        let charge = self.meter.note(self.bits.as_raw_slice().len() * 8);
        Charged { bits: self.bits.clone(), _charge: charge, meter: self.meter.clone() }
    }
}

impl BitSet {
    /// Creates an empty set.
    pub fn empty(meter: &Meter, size: usize) -> Self {
        Self::filled(meter, size, false)
    }

    /// Creates the set of all numbers below `size`.
    pub fn full(meter: &Meter, size: usize) -> Self {
        Self::filled(meter, size, true)
    }

    fn filled(meter: &Meter, size: usize, value: bool) -> Self {
        let mut bits: BitVec<u64, Lsb0> = BitVec::repeat(value, size);
        bits.set_uninitialized(false);
        let charge = meter.note(bits.as_raw_slice().len() * 8);
        BitSet(Arc::new(Charged { bits, _charge: charge, meter: meter.clone() }))
    }

    /// Returns whether the set was charged to this meter: whether it belongs to the meter's engine.
    pub fn is_of(&self, meter: &Meter) -> bool {
        self.0.meter.is(meter)
    }

    /// Returns the bits as words, the smallest number in the lowest bit.
    #[inline]
    pub fn words(&self) -> &[u64] {
        self.0.bits.as_raw_slice()
    }

    /// Returns the words for modification; a shared set is copied first.
    #[inline]
    pub fn words_mut(&mut self) -> &mut [u64] {
        Arc::make_mut(&mut self.0).bits.as_raw_mut_slice()
    }

    /// Returns whether i ∈ X.
    #[inline]
    pub fn has(&self, i: usize) -> bool {
        test(self.words(), i)
    }

    /// Returns whether X = ∅.
    pub fn is_empty(&self) -> bool {
        self.words().iter().all(|&w| w == 0)
    }

    /// Returns whether X = Y.
    pub fn same(&self, other: &BitSet) -> bool {
        Arc::ptr_eq(&self.0, &other.0) || self.words() == other.words()
    }

    /// Returns |X|.
    pub fn count(&self) -> u64 {
        self.words().iter().map(|w| u64::from(w.count_ones())).sum()
    }

    /// Computes `op(X, Y)` word by word.
    ///
    /// # Errors
    /// The memory limit is reached.
    pub fn zip(&self, other: &BitSet, op: impl Fn(u64, u64) -> u64) -> Result<BitSet> {
        let mut result = self.copy()?;
        for (x, &y) in result.words_mut().iter_mut().zip(other.words()) {
            *x = op(*x, y);
        }
        Ok(result)
    }

    /// Returns a copy that shares no bits with this set.
    ///
    /// # Errors
    /// The memory limit is reached.
    pub fn copy(&self) -> Result<BitSet> {
        self.0.meter.charge(self.words().len() * 8)?;
        Ok(BitSet(Arc::new(Charged::clone(&self.0))))
    }

    /// Returns the numbers of the set in ascending order.
    #[inline]
    pub fn iter(&self) -> impl Iterator<Item = usize> {
        ones(self.words())
    }
}

/// Returns whether bit `i` is set.
#[inline]
pub fn test(words: &[u64], i: usize) -> bool {
    words[i >> 6] >> (i & 63) & 1 != 0
}

/// Sets bit `i`.
#[inline]
pub fn set(words: &mut [u64], i: usize) {
    words[i >> 6] |= 1 << (i & 63);
}

/// Clears bit `i`.
#[inline]
pub fn clear(words: &mut [u64], i: usize) {
    words[i >> 6] &= !(1 << (i & 63));
}

/// Returns the positions of the bits that are set.
#[inline]
pub fn ones(words: &[u64]) -> impl Iterator<Item = usize> {
    words.iter().enumerate().flat_map(|(index, &word)| {
        std::iter::successors((word != 0).then_some(word), |&w| Some(w & (w - 1)).filter(|&w| w != 0))
            .map(move |w| index * 64 + w.trailing_zeros() as usize)
    })
}
