//! The states reached, each stored once, and a hash index from a code to its number.

use std::hash::{BuildHasher, Hasher};

use ahash::RandomState;

use super::meter::{Array, Charge, Meter};
use crate::error::{Limit, Result};

/// A number that no state has.
pub(super) const NOBODY: u32 = u32::MAX;
/// Maximum number of states: the index keeps a quarter of its slots free.
const MOST_STATES: usize = 3 << 30;

/// Codes in the order in which they were reached, with an open-addressing hash index.
///
/// A slot contains the number of a state and, in the bits above, a tag from its hash. A probe of a
/// slot with another code therefore rarely reads the stored code.
#[derive(Debug)]
pub(super) struct Index {
    /// All codes, one after the other.
    codes: Array<u64>,
    words: usize,
    slots: Vec<u32>,
    /// Mask of the low bits of a slot, which contain the number; also the mask of slot positions.
    mask: u32,
    hasher: RandomState,
    meter: Meter,
    charge: Charge,
}

impl Index {
    /// Creates an empty index for codes of `words` words.
    pub(super) fn new(words: usize, meter: &Meter) -> Result<Self> {
        let size = 1usize << 10;
        Ok(Index {
            codes: Array::new(meter),
            words,
            slots: vec![NOBODY; size],
            mask: size as u32 - 1,
            // Fixed seeds: results do not depend on them, and run times should not either.
            hasher: RandomState::with_seeds(0x243f_6a88, 0x85a3_08d3, 0x1319_8a2e, 0x0370_7344),
            meter: meter.clone(),
            charge: meter.charge(size * 4)?,
        })
    }

    /// Returns the number of states.
    #[inline]
    pub(super) fn len(&self) -> usize {
        self.codes.len() / self.words
    }

    /// Returns the code of a state.
    #[inline]
    pub(super) fn code(&self, id: usize) -> &[u64] {
        &self.codes[id * self.words..(id + 1) * self.words]
    }

    /// Returns the number of a code, a new one if the code is new.
    ///
    /// # Errors
    /// The memory limit or the maximum number of states is reached.
    #[inline]
    pub(super) fn intern<const W: usize>(&mut self, code: &[u64; W]) -> Result<u32> {
        let hash = self.hash(code);
        let (slot, found) = self.probe::<W>(code, hash);
        if found != NOBODY {
            return Ok(found);
        }
        self.insert(code, hash, slot)
    }

    /// Returns the number of a code, if the code is known.
    pub(super) fn find(&self, code: &[u64]) -> Option<u32> {
        let hash = self.hash(code);
        let tag = self.tag(hash);
        let mut slot = hash as u32 & self.mask;
        loop {
            let entry = self.slots[slot as usize];
            if entry == NOBODY {
                return None;
            }
            let id = entry & self.mask;
            if entry & !self.mask == tag && self.code(id as usize) == code {
                return Some(id);
            }
            slot = (slot + 1) & self.mask;
        }
    }

    /// Frees unused capacity.
    pub(super) fn shrink(&mut self) {
        self.codes.shrink();
    }

    /// Returns the slot for a code, and the code's number or [`NOBODY`].
    #[inline]
    fn probe<const W: usize>(&self, code: &[u64; W], hash: u64) -> (u32, u32) {
        let tag = self.tag(hash);
        let mut slot = hash as u32 & self.mask;
        loop {
            let entry = self.slots[slot as usize];
            if entry == NOBODY {
                return (slot, NOBODY);
            }
            if entry & !self.mask == tag {
                let id = entry & self.mask;
                let from = id as usize * W;
                if self.codes[from..from + W] == code[..] {
                    return (slot, id);
                }
            }
            slot = (slot + 1) & self.mask;
        }
    }

    #[inline]
    fn hash(&self, code: &[u64]) -> u64 {
        let mut hasher = self.hasher.build_hasher();
        for &word in code {
            hasher.write_u64(word);
        }
        hasher.finish()
    }

    #[inline]
    fn tag(&self, hash: u64) -> u32 {
        (hash >> 32) as u32 & !self.mask
    }

    fn insert(&mut self, code: &[u64], hash: u64, slot: u32) -> Result<u32> {
        let id = self.len();
        if id >= MOST_STATES {
            return Err(Limit::States(id as u64).into());
        }
        self.codes.extend(code)?;
        self.slots[slot as usize] = id as u32 | self.tag(hash);
        if (id + 1) * 4 > self.slots.len() * 3 {
            self.meter.reached(id + 1);
            self.grow()?;
        }
        Ok(id as u32)
    }

    /// Doubles the slots; both tables exist while entries move.
    fn grow(&mut self) -> Result<()> {
        let size = self.slots.len() * 2;
        let charge = self.meter.charge(size * 4)?;
        let mut slots = Vec::new();
        slots.try_reserve_exact(size).map_err(|_| self.meter.full())?;
        slots.resize(size, NOBODY);
        self.mask = (size - 1) as u32;
        for id in 0..self.len() {
            let hash = self.hash(self.code(id));
            let mut slot = hash as u32 & self.mask;
            while slots[slot as usize] != NOBODY {
                slot = (slot + 1) & self.mask;
            }
            slots[slot as usize] = id as u32 | self.tag(hash);
        }
        self.slots = slots;
        self.charge = charge;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_code_keeps_its_number_while_the_index_grows() {
        let meter = Meter::new(1 << 30);
        let mut index = Index::new(2, &meter).unwrap();
        let code = |i: u64| [i.wrapping_mul(0x9e37_79b9_7f4a_7c15), i % 7];
        for i in 0..20_000u64 {
            assert_eq!(index.intern::<2>(&code(i)).unwrap(), i as u32);
            assert_eq!(index.intern::<2>(&code(i / 2)).unwrap(), (i / 2) as u32);
        }
        assert!((0..20_000).all(|i| index.find(&code(i)) == Some(i as u32)));
        assert_eq!(index.find(&code(20_000)), None);
    }
}
