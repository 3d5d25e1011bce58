//! A set of numbers from which the next one is taken near the last one.
//!
//! Fixpoints may examine states in any order. States that are found one after the other have numbers
//! near each other, and so do their predecessors: taken in the order of their numbers, their rows lie
//! side by side in memory. Like an elevator, the set is left downwards until no smaller number is in
//! it, then upwards, and so on.

use meliora_base::error::Result;
use meliora_space::meter::{Charge, Meter};

/// A set of numbers below a fixed size, as bits. A bit of a level says whether a word of the level
/// below is not 0, so both adding and taking a number cost a few words.
pub(super) struct Frontier {
    levels: Vec<Vec<u64>>,
    /// The number that was taken last.
    at: usize,
    rises: bool,
    _charge: Charge,
}

impl Frontier {
    /// Creates an empty set of numbers below `size`.
    ///
    /// # Errors
    /// The memory limit is reached.
    pub(super) fn new(meter: &Meter, size: usize) -> Result<Self> {
        let (mut levels, mut bits) = (Vec::new(), size);
        while levels.is_empty() || bits > 1 {
            bits = bits.div_ceil(64).max(1);
            levels.push(bits);
        }
        let charge = meter.charge(levels.iter().sum::<usize>() * size_of::<u64>())?;
        let levels = levels.into_iter().map(|words| vec![0; words]).collect();
        Ok(Frontier { levels, at: size.saturating_sub(1), rises: false, _charge: charge })
    }

    /// Adds a number.
    #[inline]
    pub(super) fn add(&mut self, number: usize) {
        let mut at = number;
        for level in &mut self.levels {
            let word = &mut level[at >> 6];
            let is_known = *word != 0;
            *word |= 1 << (at & 63);
            if is_known {
                return;
            }
            at >>= 6;
        }
    }

    /// Takes the next number out of the set; `None` if the set is empty.
    #[inline]
    pub(super) fn take(&mut self) -> Option<usize> {
        let next = match self.next() {
            Some(next) => next,
            None => {
                self.rises = !self.rises;
                self.next()?
            }
        };
        self.at = next;
        let mut at = next;
        for level in &mut self.levels {
            let word = &mut level[at >> 6];
            *word &= !(1 << (at & 63));
            if *word != 0 {
                break;
            }
            at >>= 6;
        }
        Some(next)
    }

    /// Returns the nearest number in the present direction.
    #[inline]
    fn next(&self) -> Option<usize> {
        let mut at = self.at;
        for (height, level) in self.levels.iter().enumerate() {
            // Level by level without the number itself, whose words were examined below.
            let own = u64::from(height == 0) << (at & 63);
            let ahead = if self.rises { !(u64::MAX >> (63 - (at & 63))) } else { (1 << (at & 63)) - 1 };
            let word = level.get(at >> 6).map_or(0, |word| word & (ahead | own));
            if word != 0 {
                let found = self.nearest(at >> 6, word);
                return Some(
                    self.levels[..height].iter().rev().fold(found, |at, level| self.nearest(at, level[at])),
                );
            }
            at >>= 6;
        }
        None
    }

    /// Returns the nearest number of a word that is not 0.
    #[inline]
    fn nearest(&self, index: usize, word: u64) -> usize {
        let bit = if self.rises { word.trailing_zeros() } else { 63 - word.leading_zeros() };
        index * 64 + bit as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_taken_once_downwards_then_upwards() {
        for size in [1, 64, 65, 5_000, 300_000] {
            let mut frontier = Frontier::new(&Meter::new(1 << 20), size).unwrap();
            assert_eq!(frontier.take(), None);
            let all: Vec<usize> = (0..40).map(|i| i * i * i * 7919 % size).collect();
            let mut wanted = all.clone();
            wanted.sort_unstable();
            wanted.dedup();
            all.iter().for_each(|&number| frontier.add(number));
            let middle = wanted.len() / 2;
            // The first half is added again while the second one is taken.
            let mut taken: Vec<usize> = (middle..wanted.len()).filter_map(|_| frontier.take()).collect();
            wanted[middle..].iter().rev().zip(&taken).for_each(|(a, b)| assert_eq!(a, b));
            let below: Vec<usize> = (0..middle).filter_map(|_| frontier.take()).collect();
            wanted[..middle].iter().rev().zip(&below).for_each(|(a, b)| assert_eq!(a, b));
            assert_eq!(frontier.take(), None);
            all.iter().for_each(|&number| frontier.add(number));
            taken.clear();
            taken.extend(std::iter::from_fn(|| frontier.take()));
            taken.sort_unstable();
            assert_eq!(taken, wanted);
        }
    }

    #[test]
    fn a_number_behind_the_last_one_waits_for_the_way_back() {
        let mut frontier = Frontier::new(&Meter::new(1 << 20), 10_000).unwrap();
        [9_000, 5_000, 100].iter().for_each(|&number| frontier.add(number));
        assert_eq!([frontier.take(), frontier.take()], [Some(9_000), Some(5_000)]);
        [5_001, 4_000].iter().for_each(|&number| frontier.add(number));
        let rest: Vec<usize> = std::iter::from_fn(|| frontier.take()).collect();
        assert_eq!(rest, [4_000, 100, 5_001]);
    }
}
