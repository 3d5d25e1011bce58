//! Random draws that never change: a fixed stream cipher, and own methods to draw from it, since
//! libraries may change theirs.

use num_bigint::BigUint;
use rand::rngs::ChaCha8Rng;
use rand::{Rng, SeedableRng};

/// A source of random draws.
pub struct Draw(ChaCha8Rng);

impl Draw {
    /// Returns the source for a seed.
    pub fn new(seed: u64) -> Self {
        Draw::numbered(seed, 0)
    }

    /// Returns one of many independent sources for a seed.
    pub fn numbered(seed: u64, number: u64) -> Self {
        // The key is also filled by a method of this program, which does not change.
        let mut key = [0; 32];
        key[..8].copy_from_slice(&seed.to_le_bytes());
        key[8..16].copy_from_slice(&number.to_le_bytes());
        Draw(ChaCha8Rng::from_seed(key))
    }

    /// Draws a number below `count` (0 if `count` is 0), uniformly up to 2^-32 or better.
    pub fn below(&mut self, count: usize) -> usize {
        let product = u128::from(self.0.next_u64()) * (count as u128);
        usize::try_from(product >> 64).unwrap_or(0)
    }

    /// Draws a number of any size below `count` (0 if `count` is 0), uniformly.
    pub fn below_large(&mut self, count: &BigUint) -> BigUint {
        let bits = count.bits();
        loop {
            let digits = (0..bits.div_ceil(32)).map(|_| (self.0.next_u64() >> 32) as u32).collect();
            let drawn = BigUint::new(digits) >> (bits.next_multiple_of(32) - bits);
            // At least half of the draws are accepted.
            if drawn < *count || bits == 0 {
                return drawn;
            }
        }
    }

    /// Draws a number in [0, 1) with 53 bits.
    pub fn unit(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Draws the position of one of some probabilities; the last one if their sum is slightly below 1 because of
    /// rounding.
    pub fn by_probability(&mut self, probabilities: impl ExactSizeIterator<Item = f64>) -> usize {
        let (drawn, last) = (self.unit(), probabilities.len().saturating_sub(1));
        let mut sum = 0.0;
        let reached = probabilities.into_iter().position(|p| {
            sum += p;
            drawn < sum
        });
        reached.unwrap_or(last)
    }

    /// Shuffles the items.
    pub fn shuffle<T>(&mut self, items: &mut [T]) {
        for last in (1..items.len()).rev() {
            items.swap(last, self.below(last + 1));
        }
    }

    /// Removes and returns a random item; the order of the others changes.
    pub fn take<T>(&mut self, items: &mut Vec<T>) -> Option<T> {
        (!items.is_empty()).then(|| items.swap_remove(self.below(items.len())))
    }
}

#[cfg(test)]
mod tests {
    use super::Draw;

    #[test]
    fn a_seed_means_the_same_numbers_for_ever() {
        let mut draw = Draw::numbered(1, 2);
        let first: Vec<usize> = (0..4).map(|_| draw.below(1_000_000)).collect();
        assert_eq!(first, [329_749, 276_517, 477_770, 239_322]);
        let mut draw = Draw::new(1);
        let numbers: Vec<usize> = (0..8).map(|_| draw.below(1000)).collect();
        assert_eq!(numbers, [381, 294, 798, 916, 855, 139, 733, 784]);
    }

    #[test]
    fn numbers_stay_in_their_ranges() {
        let mut draw = Draw::new(1);
        for n in 1..200 {
            assert!(draw.below(n) < n);
            assert!((0.0..1.0).contains(&draw.unit()));
        }
        assert_eq!(draw.below(0), 0);
        for bits in 0..200u32 {
            let count = num_bigint::BigUint::from(1u32) << bits;
            assert!(draw.below_large(&count) < count);
        }
        assert_eq!(draw.below_large(&num_bigint::BigUint::ZERO), num_bigint::BigUint::ZERO);
    }
}
