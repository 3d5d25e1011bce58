//! A list of codes of states, each with a key, and the way back from a code to its position.

use crate::graphs::meter::Meter;
use meliora_base::error::Result;
use meliora_engine::membership::Membership;
use meliora_space::index::{Index, Looked};
use meliora_space::meter::Meter as Bytes;
use meliora_space::weighted::{Code, Codec, Steps};

/// A list of codes with keys, each pair once. A key is in the low bits of the last word, if these are free, else in a word
/// of its own.
#[derive(Debug)]
pub struct Codes {
    index: Index,
    /// The words of the code of a state.
    words: usize,
    /// The bits of the last stored word that are those of the key.
    mask: u64,
}

impl Default for Codes {
    fn default() -> Self {
        Codes::with(1, 1, 0)
    }
}

impl Codes {
    /// Creates an empty list of codes whose keys are below `keys`.
    pub fn new(codec: &Codec, keys: u32) -> Self {
        let bits = u32::BITS - keys.saturating_sub(1).leading_zeros();
        match codec.spare() >= bits {
            true => Codes::with(codec.words(), codec.words(), (1 << bits) - 1),
            false => Codes::with(codec.words(), codec.words() + 1, u64::MAX),
        }
    }

    fn with(words: usize, stored: usize, mask: u64) -> Self {
        // The bytes are counted by the meter of the solver.
        Codes { index: Index::new(stored, &Bytes::new(u64::MAX)), words, mask }
    }

    /// Returns the number of codes.
    pub(crate) fn len(&self) -> usize {
        self.index.states()
    }

    /// Returns a code.
    pub fn code(&self, position: u32) -> Code {
        let stored = self.index.code(position as usize);
        let mut code = Code::from_slice(&stored[..self.words]);
        if stored.len() == self.words {
            code[self.words - 1] &= !self.mask;
        }
        code
    }

    /// Returns the key of a code.
    pub fn key(&self, position: u32) -> u32 {
        self.index.code(position as usize).last().map_or(0, |word| (word & self.mask) as u32)
    }

    /// Returns a code with its key, as it is stored.
    #[inline]
    fn stored(&self, key: u32, code: &[u64]) -> Code {
        let mut stored = Code::from_slice(code);
        if self.index.words() > self.words {
            stored.push(0);
        }
        if let Some(word) = stored.last_mut() {
            *word |= u64::from(key);
        }
        stored
    }

    /// Returns the position of a code with a key.
    pub fn find(&self, key: u32, code: &[u64]) -> Option<u32> {
        self.index.find(&self.stored(key, code))
    }

    /// Prepares [`Codes::find_looked`] for the successors of a state, all with the same key: many accesses to memory at the
    /// same time take less time than one after the other.
    pub fn look(&self, key: u32, steps: &Steps, into: &mut Looked) {
        self.index.look(steps.codes().map(|code| self.stored(key, code)), into);
    }

    /// Does the same as [`Codes::find`] for the code of a number among those that were looked up.
    #[inline]
    pub fn find_looked(&self, key: u32, code: &[u64], looked: &Looked, number: usize) -> Option<u32> {
        self.index.find_looked(&self.stored(key, code), looked, number)
    }

    /// Adds a code with a key, which are not in the list, and returns their position. Cost: constant on average.
    ///
    /// # Errors
    /// The memory limit is reached.
    pub fn add(&mut self, key: u32, code: &[u64], meter: &mut Meter<'_>) -> Result<u32> {
        meter.take(self.width())?;
        self.index.add(&self.stored(key, code))
    }

    /// Returns the bytes of a code.
    pub fn width(&self) -> usize {
        // The table of the index has up to 16 places of four bytes for seven codes.
        size_of::<u64>() * self.index.words() + 2 * size_of::<u32>()
    }
}

/// Returns the sets of a test that contain the state of a code.
///
/// # Errors
/// A set belongs to another engine.
pub(crate) fn marks(sets: &dyn Membership, codec: &Codec, code: &[u64]) -> Result<u64> {
    match sets.numbers() {
        Some(numbers) => Ok(numbers.number(code).map_or(0, |number| numbers.marks(number))),
        None => sets.of(&codec.decode(code)),
    }
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

    /// Adds codes with three keys, and looks them up.
    fn are_found(keys: u32, state: fn(i64) -> Vec<i64>) {
        let (program, mut meter) = (program(), Meter::unlimited(&NoProgress));
        let codec = Codec::new(&program).unwrap();
        let mut codes = Codes::new(&codec, keys);
        let code = |i: i64| codec.encode(&state(i)).unwrap();
        let key = |i: i64| (i % 7) as u32 % 3 * (keys / 4);
        for i in 0..20_000 {
            assert_eq!(codes.find(key(i), &code(i)), None);
            codes.add(key(i), &code(i), &mut meter).unwrap();
        }
        for i in 0..20_000 {
            assert_eq!(codes.find(key(i), &code(i)), Some(i as u32));
            assert_eq!(codes.find((key(i) + 1) % keys, &code(i)), None);
        }
        assert_eq!((codes.code(7), codes.key(7)), (code(7), key(7)));
    }

    #[test]
    fn codes_that_were_added_are_found() {
        are_found(4, |i| vec![i / 250, 3 + i % 250]);
        are_found(4, |i| vec![i * 37, 3 + i * 41]);
        // 24 bits of the word are free: greater keys have a word of their own.
        are_found(1 << 24, |i| vec![i * 37, 3 + i * 41]);
        are_found(1 << 25, |i| vec![i * 37, 3 + i * 41]);
    }
}
