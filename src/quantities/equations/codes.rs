//! A list of codes of states, each with a key, and the way back from a code to its position.

use std::hash::{BuildHasher, Hasher};

use ahash::RandomState;
use hashbrown::HashTable;

use crate::equations::meter::Meter;
use crate::equations::narrow::Narrow;
use meliora_base::error::Result;
use meliora_space::weighted::{Code, Codec};

/// A list of codes with keys, each pair once.
#[derive(Debug, Default)]
pub(crate) struct Codes {
    words: usize,
    /// The codes, one after the other.
    codes: Vec<u64>,
    keys: Narrow,
    /// The positions by code and key.
    positions: HashTable<u32>,
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
        words(&self.codes, position, self.words).collect()
    }

    /// Returns the key of a code.
    pub(crate) fn key(&self, position: u32) -> u32 {
        self.keys.get(position as usize)
    }

    /// Returns the position of a code with a key.
    pub(crate) fn find(&self, key: u32, code: &[u64]) -> Option<u32> {
        let same = |&position: &u32| {
            let own = words(&self.codes, position, self.words);
            own.eq(code.iter().copied()) && self.key(position) == key
        };
        self.positions.find(hash(&self.hasher, key, code.iter().copied()), same).copied()
    }

    /// Adds a code with a key, which are not in the list. Cost: constant on average.
    ///
    /// # Errors
    /// The memory limit is reached.
    pub(crate) fn add(&mut self, key: u32, code: &[u64], meter: &mut Meter<'_>) -> Result<()> {
        let position = self.len() as u32;
        self.codes.extend_from_slice(code);
        self.keys.push(key);
        meter.take(self.width())?;
        let Codes { words: number, codes, keys, positions, hasher } = self;
        let hash =
            |&position: &u32| hash(hasher, keys.get(position as usize), words(codes, position, *number));
        positions.insert_unique(hash(&position), position, hash);
        Ok(())
    }

    /// Returns the bytes of a code.
    pub(crate) fn width(&self) -> usize {
        // A hash table has up to twice as many places of five bytes.
        size_of::<u64>() * self.words + self.keys.width() + 2 * (size_of::<u32>() + 1)
    }
}

/// Returns the words of a code.
fn words(codes: &[u64], position: u32, words: usize) -> impl Iterator<Item = u64> {
    codes[position as usize * words..][..words].iter().copied()
}

/// Returns the hash of a code with a key.
fn hash(hasher: &RandomState, key: u32, code: impl Iterator<Item = u64>) -> u64 {
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
        for i in 0..20_000 {
            assert_eq!(codes.find(key(i), &code(i)), Some(i as u32));
            assert_eq!(codes.find(key(i) + 1, &code(i)), None);
        }
        assert_eq!((codes.code(7), codes.key(7)), (code(7), key(7)));
    }

    #[test]
    fn codes_that_were_added_are_found() {
        are_found(|i| vec![i / 250, 3 + i % 250]);
        are_found(|i| vec![i * 37, 3 + i * 41]);
    }
}
