//! Lists of numbers, many of which are equal. Each is stored once.

use std::sync::Arc;

use ahash::AHashMap;

use super::meter::{Array, Meter};
use meliora_base::error::Result;

/// Maximum number of different lists.
pub const MOST: usize = 1 << 16;

type Key = Arc<[u32]>;

/// Lists, while they are added one after the other.
pub(crate) struct Collected {
    numbers: AHashMap<Key, u16>,
    lists: Vec<Key>,
    of: Array<u16>,
    /// The list that is added next.
    pub(crate) key: Vec<u32>,
}

impl Collected {
    /// Begins with a list of no position.
    pub(crate) fn new(meter: &Meter, first: &[u32]) -> Self {
        let (key, of) = (Key::from(first), Array::new(meter));
        let numbers = AHashMap::from([(Arc::clone(&key), 0)]);
        Collected { numbers, lists: vec![key], of, key: Vec::new() }
    }

    /// Adds the list that it has begun with.
    ///
    /// # Errors
    /// The memory limit is reached.
    #[inline]
    pub(crate) fn add_first(&mut self) -> Result<()> {
        self.of.push(0)
    }

    /// Adds [`Collected::key`]; returns false if there are too many different lists.
    ///
    /// # Errors
    /// The memory limit is reached.
    pub(crate) fn add(&mut self) -> Result<bool> {
        let last = self.of.last().filter(|&&last| *self.lists[usize::from(last)] == *self.key);
        let number = match last.or_else(|| self.numbers.get(&self.key[..])) {
            Some(&known) => known,
            None if self.lists.len() == MOST => return Ok(false),
            None => {
                let (key, new) = (Key::from(&self.key[..]), self.lists.len() as u16);
                self.lists.push(Arc::clone(&key));
                self.numbers.insert(key, new);
                new
            }
        };
        self.of.push(number)?;
        Ok(true)
    }

    pub(crate) fn finish(mut self) -> Lists {
        self.of.shrink();
        Lists { lists: self.lists, of: self.of }
    }
}

/// A list for each of some positions.
#[derive(Debug)]
pub(crate) struct Lists {
    lists: Vec<Key>,
    of: Array<u16>,
}

impl Lists {
    /// Returns the number of the list of a position.
    #[inline]
    pub(crate) fn number(&self, position: usize) -> u32 {
        u32::from(self.of[position])
    }

    /// Returns a list, by its number.
    #[inline]
    pub(crate) fn list(&self, number: u32) -> &[u32] {
        &self.lists[number as usize]
    }

    /// Returns the number of different lists.
    pub(crate) fn count(&self) -> usize {
        self.lists.len()
    }
}
