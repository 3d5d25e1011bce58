//! A queue of edges by estimates.

use std::collections::BTreeMap;

use meliora_base::error::Result;
use meliora_space::index::NOBODY;
use meliora_space::meter::{Array, Meter};

/// Numbers, the first of them counts most.
pub(super) type Key = [u32; 3];

/// Edges by a number, the smallest first; equal ones in the order in which they came.
pub(super) struct Queue {
    /// The first and the last entry of each number.
    ends: BTreeMap<Key, [u32; 2]>,
    /// The edges, each with the next entry of the same number.
    entries: Array<[u32; 2]>,
}

impl Queue {
    pub(super) fn new(meter: &Meter) -> Self {
        Queue { ends: BTreeMap::new(), entries: Array::new(meter) }
    }

    /// Adds an edge.
    ///
    /// # Errors
    /// The memory limit.
    pub(super) fn push(&mut self, key: Key, edge: u32) -> Result<()> {
        let entry = self.entries.len() as u32;
        self.entries.push([edge, NOBODY])?;
        let [_, last] = self.ends.entry(key).or_insert([entry, NOBODY]);
        if let Some(last) = self.entries.get_mut(*last as usize) {
            last[1] = entry;
        }
        *last = entry;
        Ok(())
    }

    /// Removes and returns the first edge.
    pub(super) fn pop(&mut self) -> Option<u32> {
        let mut ends = self.ends.first_entry()?;
        let [edge, next] = self.entries[ends.get()[0] as usize];
        match next {
            NOBODY => drop(ends.remove()),
            next => ends.get_mut()[0] = next,
        }
        Some(edge)
    }

    pub(super) fn clear(&mut self) {
        self.ends.clear();
        self.entries.truncate(0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_smallest_number_comes_first_and_equal_ones_in_their_order() {
        let mut queue = Queue::new(&Meter::new(1 << 20));
        for (key, edge) in [(3, 0), (1, 1), (3, 2), (1, 3)] {
            queue.push([0, key, 0], edge).unwrap();
        }
        assert_eq!([queue.pop(), queue.pop()], [Some(1), Some(3)]);
        queue.push([0, 0, 0], 4).unwrap();
        queue.push([0, 3, 0], 5).unwrap();
        let rest: Vec<u32> = std::iter::from_fn(|| queue.pop()).collect();
        assert_eq!(rest, [4, 0, 2, 5]);
        queue.push([0, 2, 0], 6).unwrap();
        queue.clear();
        assert_eq!(queue.pop(), None);
    }
}
