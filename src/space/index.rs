//! The states reached, each stored once, and a hash index from a code to its number.
//!
//! A slot of the table has 32 bits: the number of a state in as many low bits as numbers need, and a part of
//! its hash in the others. A look-up reads one slot and one code, mostly, and both are far from the last ones
//! in memory. So the slots of all successors of a state are read before the first code.

use std::hash::{BuildHasher, Hasher};

use ahash::RandomState;

use super::meter::{Array, Meter};
use meliora_base::error::{Limit, Result};

/// A number that no state has, and a slot without a number.
pub const NOBODY: u32 = u32::MAX;
/// Maximum number of states: a number is 32 bits, and [`NOBODY`] is none.
const MOST_STATES: usize = 3 << 30;

/// Codes in the order in which they were reached, with a hash table of their numbers.
#[derive(Debug)]
pub struct Index {
    /// All codes, one after the other.
    codes: Array<u64>,
    words: usize,
    /// The slots: a power of two, of which an eighth at least is free.
    slots: Array<u32>,
    hasher: RandomState,
    meter: Meter,
}

/// The hashes and the first slots of some codes, by their positions. Slots are read before the first code is compared.
#[derive(Debug, Default)]
pub struct Looked {
    slots: Vec<(u64, u32)>,
    /// The number of slots of the table.
    size: usize,
}

impl Index {
    /// Creates an empty index for codes of `words` words.
    pub fn new(words: usize, meter: &Meter) -> Self {
        let (codes, slots) = (Array::new(meter), Array::new(meter));
        Index { codes, words, slots, hasher: hasher(), meter: meter.clone() }
    }

    /// Returns the number of states.
    #[inline]
    pub fn states(&self) -> usize {
        self.codes.len() / self.words
    }

    /// Returns the code of a state.
    #[inline]
    pub fn code(&self, id: usize) -> &[u64] {
        &self.codes[id * self.words..(id + 1) * self.words]
    }

    /// Returns the number of a code, a new one if the code is new.
    ///
    /// # Errors
    /// The memory limit or the maximum number of states is reached.
    #[inline]
    pub fn intern(&mut self, code: &[u64]) -> Result<u32> {
        let hash = self.hash_of(code);
        match self.search(code, hash) {
            Some(number) => Ok(number),
            None => self.insert(code, hash),
        }
    }

    /// Returns the number of a code, if the code is known.
    pub fn find(&self, code: &[u64]) -> Option<u32> {
        self.search(code, self.hash_of(code))
    }

    /// Returns the number of words of a code.
    #[inline]
    pub fn words(&self) -> usize {
        self.words
    }

    /// Adds a code that is not known, and returns its number.
    ///
    /// # Errors
    /// The memory limit or the maximum number of states is reached.
    pub fn add(&mut self, code: &[u64]) -> Result<u32> {
        self.insert(code, self.hash_of(code))
    }

    /// Reads the first slots of some codes, for [`Index::find_looked`].
    #[inline]
    pub fn look<C: AsRef<[u64]>>(&self, codes: impl Iterator<Item = C>, into: &mut Looked) {
        into.size = self.slots.len();
        into.slots.clear();
        into.slots.extend(codes.map(|code| {
            let hash = self.hash_of(code.as_ref());
            (hash, self.slot(hash))
        }));
    }

    /// Returns the first slot for a hash.
    #[inline]
    pub(crate) fn slot(&self, hash: u64) -> u32 {
        let at = hash as usize & self.slots.len().wrapping_sub(1);
        self.slots.get(at).copied().unwrap_or(NOBODY)
    }

    /// Returns the number of slots.
    #[inline]
    pub(crate) fn slots(&self) -> usize {
        self.slots.len()
    }

    /// Returns the number of a code, if the code is known; it has this position among those that were looked up.
    #[inline]
    pub fn find_looked(&self, code: &[u64], looked: &Looked, position: usize) -> Option<u32> {
        let (hash, slot) = looked.slots[position];
        self.find_from(code, hash, (slot, looked.size))
    }

    /// Returns the number of a code, given its hash and its first slot, which was read when the table had `size` slots.
    #[inline]
    pub(crate) fn find_from(&self, code: &[u64], hash: u64, (slot, size): (u32, usize)) -> Option<u32> {
        // Slots of a table that has grown meanwhile mean nothing.
        let first = (self.slots.len() == size).then(|| self.matches(slot, code, hash)).flatten();
        first.or_else(|| self.search(code, hash))
    }

    /// Returns the hash of a code.
    #[inline]
    pub(crate) fn hash_of(&self, code: &[u64]) -> u64 {
        hash(&self.hasher, code.iter().copied())
    }

    /// Frees unused capacity.
    pub fn shrink(&mut self) {
        self.codes.shrink();
    }

    /// Returns the number in a slot, if it is that of a code.
    #[inline]
    fn matches(&self, slot: u32, code: &[u64], hash: u64) -> Option<u32> {
        let low = self.slots.len().wrapping_sub(1) as u32;
        let number = slot & low;
        let is_same = slot != NOBODY
            && (slot ^ part(hash)) & !low == 0
            // Most codes have one or two words: a loop takes less time than a call to compare memory.
            && self.codes[number as usize * code.len()..][..code.len()].iter().eq(code);
        is_same.then_some(number)
    }

    #[inline]
    fn search(&self, code: &[u64], hash: u64) -> Option<u32> {
        let mask = self.slots.len().checked_sub(1)?;
        let mut at = hash as usize & mask;
        loop {
            let slot = self.slots[at];
            if slot == NOBODY {
                return None;
            }
            if let Some(number) = self.matches(slot, code, hash) {
                return Some(number);
            }
            at = (at + 1) & mask;
        }
    }

    /// Adds a code that is not known, given its hash, and returns its number.
    ///
    /// # Errors
    /// The memory limit or the maximum number of states is reached.
    pub(crate) fn insert(&mut self, code: &[u64], hash: u64) -> Result<u32> {
        let number = self.states();
        if number >= MOST_STATES {
            return Err(Limit::States(number as u64).into());
        }
        if room(self.slots.len()) <= number {
            self.meter.reached(number);
            self.reserve(2 * number.max(1 << 8))?;
        }
        self.codes.extend(code)?;
        enter(&mut self.slots, hash, number as u32);
        Ok(number as u32)
    }

    /// Makes room in the table for a number of states. The old and the new table exist while numbers move.
    ///
    /// # Errors
    /// The memory limit is reached.
    pub fn reserve(&mut self, states: usize) -> Result<()> {
        if states <= room(self.slots.len()) {
            return Ok(());
        }
        let mut slots = Array::filled(&self.meter, (states * 8).div_ceil(7).next_power_of_two(), NOBODY)?;
        for (number, code) in (0..).zip(self.codes.chunks_exact(self.words)) {
            enter(&mut slots, hash(&self.hasher, code.iter().copied()), number);
        }
        self.slots = slots;
        Ok(())
    }
}

/// Returns the number of states for which a table has room.
fn room(slots: usize) -> usize {
    slots - slots.div_ceil(8)
}

/// Returns the part of a hash that slots contain, in their high bits.
#[inline]
fn part(hash: u64) -> u32 {
    (hash >> 32) as u32
}

/// Enters a number that is not in the slots, of which one is free.
fn enter(slots: &mut [u32], hash: u64, number: u32) {
    let mask = slots.len() - 1;
    let mut at = hash as usize & mask;
    while slots[at] != NOBODY {
        at = (at + 1) & mask;
    }
    slots[at] = part(hash) & !(mask as u32) | number;
}

/// Returns a hash function. Its seeds are fixed: results do not depend on them, and run times should not either.
pub fn hasher() -> RandomState {
    RandomState::with_seeds(0x243f_6a88, 0x85a3_08d3, 0x1319_8a2e, 0x0370_7344)
}

/// Returns the hash of some words.
#[inline]
pub fn hash(hasher: &RandomState, words: impl Iterator<Item = u64>) -> u64 {
    let mut hasher = hasher.build_hasher();
    for word in words {
        hasher.write_u64(word);
    }
    hasher.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn room_for_all_codes_is_made_once_if_the_memory_suffices() {
        let meter = Meter::new(1 << 20);
        let mut index = Index::new(1, &meter);
        assert!(index.reserve(1 << 20).is_err());
        assert_eq!(meter.used(), 0);
        index.reserve(20_000).unwrap();
        let slots = index.slots.len();
        assert_eq!(slots, 32_768);
        for i in 0..20_000 {
            assert_eq!(index.intern(&[i]).unwrap(), i as u32);
        }
        index.reserve(10_000).unwrap();
        assert_eq!(index.slots.len(), slots);
    }

    #[test]
    fn every_code_keeps_its_number_while_the_index_grows() {
        let meter = Meter::new(1 << 30);
        let mut index = Index::new(2, &meter);
        let code = |i: u64| [i.wrapping_mul(0x9e37_79b9_7f4a_7c15), i % 7];
        for i in 0..20_000u64 {
            assert_eq!(index.intern(&code(i)).unwrap(), i as u32);
            assert_eq!(index.intern(&code(i / 2)).unwrap(), (i / 2) as u32);
        }
        assert!((0..20_000).all(|i| index.find(&code(i)) == Some(i as u32)));
        assert_eq!(index.find(&code(70_000)), None);
    }
}
