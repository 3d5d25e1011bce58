//! Numbered codes of states, each with a key, and the way back from a code to its number.

use std::hash::{BuildHasher, Hasher};
use std::sync::OnceLock;

use ahash::RandomState;
use hashbrown::HashTable;

use super::narrow::Narrow;

/// A list of codes with keys, each pair once.
#[derive(Debug, Default)]
pub(super) struct Codes {
    words: usize,
    /// The codes, one after the other.
    codes: Vec<u64>,
    keys: Narrow,
    /// The numbers by code and key. Large models need the memory for their equations, so this can be
    /// dropped; it is built again for the next question.
    numbers: OnceLock<HashTable<u32>>,
    hasher: RandomState,
}

impl Codes {
    /// Creates an empty list of codes with this number of words.
    pub(super) fn new(words: usize) -> Self {
        Codes { words, ..Codes::default() }
    }

    /// Returns the number of codes.
    pub(super) fn len(&self) -> usize {
        self.keys.len()
    }

    /// Returns a code.
    pub(super) fn code(&self, number: u32) -> &[u64] {
        &self.codes[number as usize * self.words..][..self.words]
    }

    /// Returns the key of a code.
    pub(super) fn key(&self, number: u32) -> u32 {
        self.keys.get(number as usize)
    }

    /// Returns the number of a code with a key.
    pub(super) fn find(&self, key: u32, code: &[u64]) -> Option<u32> {
        let same = |&number: &u32| self.code(number) == code && self.key(number) == key;
        let numbers = self.numbers.get_or_init(|| self.numbered());
        numbers.find(hash(&self.hasher, key, code), same).copied()
    }

    /// Adds a code with a key, which are not in the list.
    pub(super) fn add(&mut self, key: u32, code: &[u64]) {
        self.numbers.get_or_init(|| self.numbered());
        let number = self.len() as u32;
        self.codes.extend_from_slice(code);
        self.keys.push(key);
        let hash = hash(&self.hasher, key, code);
        let Codes { words, codes, keys, numbers, hasher } = self;
        let rehash = |&number: &u32| {
            self::hash(hasher, keys.get(number as usize), &codes[number as usize * *words..][..*words])
        };
        if let Some(numbers) = numbers.get_mut() {
            numbers.insert_unique(hash, number, rehash);
        }
    }

    /// Does the same as [`Codes::add`], without finding the code again soon.
    pub(super) fn push(&mut self, key: u32, code: &[u64]) {
        self.codes.extend_from_slice(code);
        self.keys.push(key);
        self.numbers.take();
    }

    /// Drops what finds numbers.
    pub(super) fn drop_numbers(&mut self) {
        self.numbers.take();
    }

    /// Returns the bytes of a code without what finds its number.
    pub(super) fn width(&self) -> usize {
        8 * self.words + self.keys.width()
    }

    fn numbered(&self) -> HashTable<u32> {
        let mut numbers = HashTable::with_capacity(self.len());
        for number in 0..self.len() as u32 {
            numbers.insert_unique(self.hash(number), number, |&number| self.hash(number));
        }
        numbers
    }

    fn hash(&self, number: u32) -> u64 {
        hash(&self.hasher, self.key(number), self.code(number))
    }
}

/// The bytes of a code in the table of numbers: it has up to twice as many places of five bytes.
pub(super) const PLACES: usize = 10;

fn hash(hasher: &RandomState, key: u32, code: &[u64]) -> u64 {
    let mut state = hasher.build_hasher();
    code.iter().for_each(|&word| state.write_u64(word));
    state.write_u32(key);
    state.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_that_were_pushed_are_found() {
        let mut codes = Codes::new(1);
        for i in 0..100 {
            if i % 3 == 0 { codes.add(0, &[i]) } else { codes.push(0, &[i]) }
        }
        assert!((0..100).all(|i| codes.find(0, &[i]) == Some(i as u32)));
        assert_eq!(codes.find(0, &[100]), None);
    }

    #[test]
    fn codes_keep_their_numbers_when_the_table_is_built_again() {
        let mut codes = Codes::new(2);
        let code = |i: u64| [i / 3, i];
        for i in 0..1000 {
            assert_eq!(codes.find((i % 5) as u32, &code(i)), None);
            codes.add((i % 5) as u32, &code(i));
        }
        codes.drop_numbers();
        for i in 0..1000 {
            assert_eq!(codes.find((i % 5) as u32, &code(i)), Some(i as u32));
            assert_eq!(codes.find((i % 5 + 1) as u32, &code(i)), None);
        }
        assert_eq!((codes.code(7), codes.key(7)), (&[2, 7][..], 2));
    }
}
