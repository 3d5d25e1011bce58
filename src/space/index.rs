//! The states reached, each stored once, and a hash index from a code to its number.

use std::hash::{BuildHasher, Hasher};

use ahash::RandomState;
use hashbrown::HashTable;

use super::meter::{Array, Charge, Meter};
use meliora_base::error::{Limit, Result};

/// A number that no state has.
pub const NOBODY: u32 = u32::MAX;
/// Maximum number of states: a number is 32 bits, and [`NOBODY`] is none.
const MOST_STATES: usize = 3 << 30;
/// Bytes of the table for each slot: a number and a control byte.
const SLOT: usize = 5;

/// Codes in the order in which they were reached, with a hash table of their numbers.
#[derive(Debug)]
pub struct Index {
    /// All codes, one after the other.
    codes: Array<u64>,
    words: usize,
    numbers: HashTable<u32>,
    hasher: RandomState,
    meter: Meter,
    charge: Charge,
}

impl Index {
    /// Creates an empty index for codes of `words` words.
    pub fn new(words: usize, meter: &Meter) -> Self {
        Index {
            codes: Array::new(meter),
            words,
            numbers: HashTable::new(),
            hasher: hasher(),
            meter: meter.clone(),
            charge: meter.note(0),
        }
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
    pub fn intern<const W: usize>(&mut self, code: &[u64; W]) -> Result<u32> {
        let hash = hash(&self.hasher, code.iter().copied());
        let same = |&id: &u32| self.codes[id as usize * W..][..W] == code[..];
        match self.numbers.find(hash, same) {
            Some(&id) => Ok(id),
            None => self.insert(code, hash),
        }
    }

    /// Returns the number of a code, if the code is known.
    pub fn find(&self, code: &[u64]) -> Option<u32> {
        let same = |&id: &u32| self.code(id as usize) == code;
        self.numbers.find(hash(&self.hasher, code.iter().copied()), same).copied()
    }

    /// Frees unused capacity.
    pub fn shrink(&mut self) {
        self.codes.shrink();
    }

    fn insert(&mut self, code: &[u64], hash: u64) -> Result<u32> {
        let id = self.states();
        if id >= MOST_STATES {
            return Err(Limit::States(id as u64).into());
        }
        if self.numbers.len() == self.numbers.capacity() {
            self.meter.reached(id);
            self.reserve(2 * id.max(1 << 8))?;
        }
        self.codes.extend(code)?;
        let Index { codes, words, numbers, hasher, .. } = self;
        numbers.insert_unique(hash, id as u32, rehash(hasher, codes, *words));
        Ok(id as u32)
    }

    /// Makes room in the table for a number of states. The old and the new table exist while numbers move.
    ///
    /// # Errors
    /// The memory limit is reached.
    pub fn reserve(&mut self, states: usize) -> Result<()> {
        let more = states.saturating_sub(self.numbers.len());
        if more <= self.numbers.capacity() - self.numbers.len() {
            return Ok(());
        }
        let slots = (states * 8 / 7).next_power_of_two();
        let charge = self.meter.charge(slots * SLOT)?;
        let Index { codes, words, numbers, hasher, .. } = self;
        numbers.try_reserve(more, rehash(hasher, codes, *words)).map_err(|_| self.meter.full())?;
        self.charge = charge;
        Ok(())
    }
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

/// Returns the hash of a number: that of its code.
fn rehash<'a>(hasher: &'a RandomState, codes: &'a [u64], words: usize) -> impl Fn(&u32) -> u64 + 'a {
    move |&id| hash(hasher, codes[id as usize * words..][..words].iter().copied())
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
        let room = index.numbers.capacity();
        assert!((20_000..60_000).contains(&room), "{room}");
        for i in 0..20_000 {
            assert_eq!(index.intern(&[i]).unwrap(), i as u32);
        }
        index.reserve(10_000).unwrap();
        assert_eq!(index.numbers.capacity(), room);
    }

    #[test]
    fn every_code_keeps_its_number_while_the_index_grows() {
        let meter = Meter::new(1 << 30);
        let mut index = Index::new(2, &meter);
        let code = |i: u64| [i.wrapping_mul(0x9e37_79b9_7f4a_7c15), i % 7];
        for i in 0..20_000u64 {
            assert_eq!(index.intern::<2>(&code(i)).unwrap(), i as u32);
            assert_eq!(index.intern::<2>(&code(i / 2)).unwrap(), (i / 2) as u32);
        }
        assert!((0..20_000).all(|i| index.find(&code(i)) == Some(i as u32)));
        assert_eq!(index.find(&code(20_000)), None);
    }
}
