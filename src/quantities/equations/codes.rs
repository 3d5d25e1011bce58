//! A list of codes of states, each with a key, and the way back from a code to its position.

use std::hash::{BuildHasher, Hasher};
use std::sync::OnceLock;

use ahash::RandomState;
use hashbrown::HashTable;

use crate::equations::meter::Meter;
use crate::equations::narrow::Narrow;
use meliora_base::error::Result;
use meliora_engine::explicit::weighted::{Code, Codec};

/// A list of words. Codes use their upper bits first, so the upper halves suffice for small models.
#[derive(Debug)]
enum Words {
    Halves(Vec<u32>),
    Whole(Vec<u64>),
}

impl Default for Words {
    fn default() -> Self {
        Words::Halves(Vec::new())
    }
}

impl Words {
    /// Adds a word. Cost: constant, except where the word is the first one that needs its lower half.
    fn push(&mut self, word: u64) {
        match self {
            Words::Halves(list) if word as u32 == 0 => list.push((word >> 32) as u32),
            Words::Halves(list) => {
                *self = Words::Whole(list.iter().map(|&half| u64::from(half) << 32).collect());
                self.push(word);
            }
            Words::Whole(list) => list.push(word),
        }
    }

    #[inline]
    fn get(&self, position: usize) -> u64 {
        match self {
            Words::Halves(list) => u64::from(list[position]) << 32,
            Words::Whole(list) => list[position],
        }
    }

    /// Returns the words of a code, whose number is given.
    fn code(&self, number: u32, words: usize) -> impl Iterator<Item = u64> {
        let start = number as usize * words;
        (start..start + words).map(|position| self.get(position))
    }

    /// Returns the bytes of a word.
    fn width(&self) -> usize {
        match self {
            Words::Halves(_) => 4,
            Words::Whole(_) => 8,
        }
    }
}

/// A list of codes with keys, each pair once.
#[derive(Debug, Default)]
pub(crate) struct Codes {
    words: usize,
    /// The codes, one after the other.
    codes: Words,
    keys: Narrow,
    /// The positions by code and key. Large models need the memory for their equations, so this can be
    /// dropped; it is built again for the next question.
    positions: OnceLock<HashTable<u32>>,
    hasher: RandomState,
}

impl Codes {
    /// Creates an empty list of codes.
    pub(crate) fn new(codec: &Codec) -> Self {
        Codes { words: codec.words(), ..Codes::default() }
    }

    /// Returns the number of codes.
    pub(crate) fn len(&self) -> usize {
        self.keys.len()
    }

    /// Returns a code.
    pub(crate) fn code(&self, position: u32) -> Code {
        self.codes.code(position, self.words).collect()
    }

    /// Returns the key of a code.
    pub(crate) fn key(&self, position: u32) -> u32 {
        self.keys.get(position as usize)
    }

    /// Returns the position of a code with a key.
    pub(crate) fn find(&self, key: u32, code: &[u64]) -> Option<u32> {
        let same = |&position: &u32| {
            let own = self.codes.code(position, self.words);
            own.eq(code.iter().copied()) && self.key(position) == key
        };
        let table = self.positions.get_or_init(|| self.hashed());
        table.find(hash(&self.hasher, key, code.iter().copied()), same).copied()
    }

    /// Adds a code with a key, which are not in the list. Cost: constant on average.
    ///
    /// # Errors
    /// The memory limit is reached.
    pub(crate) fn add(&mut self, key: u32, code: &[u64], meter: &mut Meter<'_>) -> Result<()> {
        self.positions.get_or_init(|| self.hashed());
        let position = self.append(key, code, meter)?;
        let Codes { words, codes, keys, positions, hasher, .. } = self;
        if let Some(table) = positions.get_mut() {
            meter.take(PLACES)?;
            let hash =
                |&position: &u32| hash(hasher, keys.get(position as usize), codes.code(position, *words));
            let own = hash(&position);
            table.insert_unique(own, position, hash);
        }
        Ok(())
    }

    /// Does the same as [`Codes::add`], without finding the code again soon.
    ///
    /// # Errors
    /// The memory limit is reached.
    pub(crate) fn push(&mut self, key: u32, code: &[u64], meter: &mut Meter<'_>) -> Result<()> {
        self.positions.take();
        self.append(key, code, meter).map(drop)
    }

    /// Adds a code with a key to the lists alone; returns its position.
    fn append(&mut self, key: u32, code: &[u64], meter: &mut Meter<'_>) -> Result<u32> {
        let position = self.len() as u32;
        code.iter().for_each(|&word| self.codes.push(word));
        self.keys.push(key);
        meter.take(self.width())?;
        Ok(position)
    }

    /// Drops what finds positions.
    pub(crate) fn drop_positions(&mut self) {
        self.positions.take();
    }

    /// Returns the bytes of a code without what finds its position.
    pub(crate) fn width(&self) -> usize {
        self.codes.width() * self.words + self.keys.width()
    }

    fn hashed(&self) -> HashTable<u32> {
        let hash =
            |&position: &u32| hash(&self.hasher, self.key(position), self.codes.code(position, self.words));
        let mut table = HashTable::with_capacity(self.len());
        for position in 0..self.len() as u32 {
            table.insert_unique(hash(&position), position, hash);
        }
        table
    }
}

/// The bytes of a code in a hash table: it has up to twice as many places of five bytes.
const PLACES: usize = 10;

/// Returns the hash of a code with a key.
pub(crate) fn hash(hasher: &RandomState, key: u32, code: impl Iterator<Item = u64>) -> u64 {
    let mut state = hasher.build_hasher();
    code.for_each(|word| state.write_u64(word));
    state.write_u32(key);
    state.finish()
}

#[cfg(test)]
mod tests {
    use super::*;
    use meliora_base::error::SourceFile;
    use meliora_engine::NoProgress;
    use meliora_model::Program;

    /// Returns a program with 2^40 valuations.
    fn program() -> Program {
        let text =
            "mdp module m x:[0..1048575]; y:[3..1048578]; [] x<9 -> (x'=x+1); [] y<7 -> (y'=y+1); endmodule";
        let read = |name, text: &str| SourceFile::new(name, text);
        meliora_lang::load(&read("model", text), &read("constants", "")).unwrap().program
    }

    /// Adds codes with three keys, and looks them up, also after what finds them was dropped.
    fn are_found(state: fn(i64) -> Vec<i64>) {
        let (program, mut meter) = (program(), Meter::unlimited(&NoProgress));
        let codec = Codec::new(&program).unwrap();
        let mut codes = Codes::new(&codec);
        let code = |i: i64| codec.encode(&state(i)).unwrap();
        let key = |i: i64| (i % 7 % 3) as u32;
        for i in 0..20_000 {
            assert_eq!(codes.find(key(i), &code(i)), None);
            codes.add(key(i), &code(i), &mut meter).unwrap();
        }
        for _ in 0..2 {
            for i in 0..20_000 {
                assert_eq!(codes.find(key(i), &code(i)), Some(i as u32));
                assert_eq!(codes.find(key(i) + 1, &code(i)), None);
            }
            codes.drop_positions();
        }
        assert_eq!((codes.code(7), codes.key(7)), (code(7), key(7)));
    }

    #[test]
    fn codes_that_were_pushed_are_found() {
        let (program, mut meter) = (program(), Meter::unlimited(&NoProgress));
        let codec = Codec::new(&program).unwrap();
        let mut codes = Codes::new(&codec);
        let code = |i: i64| codec.encode(&[i, 3]).unwrap();
        for i in 0..100 {
            let done = if i % 3 == 0 {
                codes.add(0, &code(i), &mut meter)
            } else {
                codes.push(0, &code(i), &mut meter)
            };
            done.unwrap();
        }
        assert!((0..100).all(|i| codes.find(0, &code(i)) == Some(i as u32)));
        assert_eq!(codes.find(0, &code(100)), None);
    }

    #[test]
    fn codes_that_were_added_are_found() {
        are_found(|i| vec![i / 250, 3 + i % 250]);
        are_found(|i| vec![i * 37, 3 + i * 41]);
    }

    #[test]
    fn words_are_widened_for_lower_halves() {
        let word = |i: u64| i << if i < 600 { 32 } else { 0 };
        let mut words = Words::default();
        (0..1000).for_each(|i| words.push(word(i)));
        assert!((0..500).all(|i| words.code(i, 2).eq([word(2 * u64::from(i)), word(2 * u64::from(i) + 1)])));
        assert_eq!(words.width(), 8);
    }
}
