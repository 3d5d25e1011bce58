//! A queue of edges by estimates.

use super::super::index::NOBODY;
use super::super::meter::{Array, Meter};
use meliora_base::error::Result;

/// Edges by a number, the smallest first; equal ones in the order in which they came.
pub(super) struct Queue {
    /// The first and the last entry of each number.
    ends: Vec<[u32; 2]>,
    /// The edges, each with the next entry of the same number.
    entries: Array<[u32; 2]>,
    /// The first number that may have an entry.
    first: usize,
}

impl Queue {
    pub(super) fn new(meter: &Meter) -> Self {
        Queue { ends: Vec::new(), entries: Array::new(meter), first: 0 }
    }

    /// Adds an edge.
    ///
    /// # Errors
    /// The memory limit.
    pub(super) fn push(&mut self, key: u32, edge: u32) -> Result<()> {
        let (key, entry) = (key as usize, self.entries.len() as u32);
        if key >= self.ends.len() {
            self.ends.resize(key + 1, [NOBODY; 2]);
        }
        self.entries.push([edge, NOBODY])?;
        let [first, last] = &mut self.ends[key];
        match *last {
            NOBODY => *first = entry,
            last => self.entries[last as usize][1] = entry,
        }
        *last = entry;
        self.first = self.first.min(key);
        Ok(())
    }

    /// Removes and returns the first edge.
    pub(super) fn pop(&mut self) -> Option<u32> {
        while let Some([first, last]) = self.ends.get_mut(self.first) {
            if *first == NOBODY {
                self.first += 1;
                continue;
            }
            let [edge, next] = self.entries[*first as usize];
            *first = next;
            if next == NOBODY {
                *last = NOBODY;
            }
            return Some(edge);
        }
        None
    }

    pub(super) fn clear(&mut self) {
        self.ends.clear();
        self.entries.truncate(0);
        self.first = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_smallest_number_comes_first_and_equal_ones_in_their_order() {
        let mut queue = Queue::new(&Meter::new(1 << 20));
        for (key, edge) in [(3, 0), (1, 1), (3, 2), (1, 3)] {
            queue.push(key, edge).unwrap();
        }
        assert_eq!([queue.pop(), queue.pop()], [Some(1), Some(3)]);
        queue.push(0, 4).unwrap();
        queue.push(3, 5).unwrap();
        let rest: Vec<u32> = std::iter::from_fn(|| queue.pop()).collect();
        assert_eq!(rest, [4, 0, 2, 5]);
        queue.push(2, 6).unwrap();
        queue.clear();
        assert_eq!(queue.pop(), None);
    }
}
