//! Lists of values most of which are equal to an earlier one.

use super::narrow::Narrow;

/// The number of bits of a hash. 2^BITS rows are remembered to find equal ones.
const BITS: u32 = 12;

/// A list of rows of K doubles. Equal rows share memory, as long as not too many different ones lie
/// between them; so a row takes one to four bytes, and a different one 8 K more.
#[derive(Debug, Default)]
pub(super) struct Repeated<const K: usize> {
    /// The number of each row in `distinct`.
    numbers: Narrow,
    distinct: Vec<[f64; K]>,
    /// A number of a row by the hash of the row.
    recent: Vec<u32>,
}

impl<const K: usize> Repeated<K> {
    /// Adds a row.
    pub(super) fn push(&mut self, row: [f64; K]) {
        self.recent.resize(1 << BITS, 0);
        let hash = row
            .iter()
            .fold(0u64, |hash, x| (hash.rotate_left(5) ^ x.to_bits()).wrapping_mul(0x9e37_79b9_7f4a_7c15));
        let recent = &mut self.recent[(hash >> (u64::BITS - BITS)) as usize];
        if self.distinct.get(*recent as usize) != Some(&row) {
            *recent = self.distinct.len() as u32;
            self.distinct.push(row);
        }
        self.numbers.push(*recent);
    }

    /// Returns the number of each row in [`Repeated::distinct`].
    pub(super) fn numbers(&self) -> &Narrow {
        &self.numbers
    }

    /// Returns the row at a position.
    #[inline]
    pub(super) fn get(&self, position: usize) -> &[f64; K] {
        &self.distinct[self.numbers.get(position) as usize]
    }

    /// Returns the different rows, each at least once.
    pub(super) fn distinct(&self) -> &[[f64; K]] {
        &self.distinct
    }

    /// Returns the bytes of the list.
    pub(super) fn bytes(&self) -> usize {
        self.numbers.len() * self.numbers.width() + self.distinct.len() * size_of::<[f64; K]>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_keep_their_values_and_equal_ones_share_memory() {
        let row = |i: usize| [(i % 7) as f64, if i.is_multiple_of(9) { i as f64 } else { 0.5 }];
        let mut list = Repeated::default();
        (0..10_000).for_each(|i| list.push(row(i)));
        assert!((0..10_000).all(|i| *list.get(i) == row(i)));
        assert!(list.distinct().len() < 2_000, "{}", list.distinct().len());
    }
}
