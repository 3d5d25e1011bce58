//! Random draws that are the same for ever: a fixed stream cipher, and the few ways to draw from it
//! written here, since libraries reserve the right to change theirs.

use num_bigint::BigUint;
use rand::rngs::ChaCha8Rng;
use rand::{Rng, SeedableRng};

/// A source of random draws.
pub(crate) struct Draw(ChaCha8Rng);

impl Draw {
    /// The source for a seed.
    pub(crate) fn new(seed: u64) -> Self {
        Draw::numbered(seed, 0)
    }

    /// One of many sources for a seed, which have nothing to do with each other.
    pub(crate) fn numbered(seed: u64, number: u64) -> Self {
        // Seed and number fill the key in a way that is ours, too.
        let mut key = [0; 32];
        key[..8].copy_from_slice(&seed.to_le_bytes());
        key[8..16].copy_from_slice(&number.to_le_bytes());
        Draw(ChaCha8Rng::from_seed(key))
    }

    /// A number below `count` (0 where there is none), each as likely to within 2^-32 or better.
    pub(crate) fn below(&mut self, count: usize) -> usize {
        let product = u128::from(self.0.next_u64()) * (count as u128);
        usize::try_from(product >> 64).unwrap_or(0)
    }

    /// A number below `count` (0 where there is none), however large, each as likely.
    pub(crate) fn below_large(&mut self, count: &BigUint) -> BigUint {
        let bits = count.bits();
        loop {
            let digits = (0..bits.div_ceil(32)).map(|_| (self.0.next_u64() >> 32) as u32).collect();
            let drawn = BigUint::new(digits) >> (bits.next_multiple_of(32) - bits);
            // At least every other draw fits.
            if drawn < *count || bits == 0 {
                return drawn;
            }
        }
    }

    /// A number in [0, 1) with 53 bits.
    pub(crate) fn unit(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Puts the items into a random order.
    pub(crate) fn shuffle<T>(&mut self, items: &mut [T]) {
        for last in (1..items.len()).rev() {
            items.swap(last, self.below(last + 1));
        }
    }

    /// Takes a random item out; the order of the others changes.
    pub(crate) fn take<T>(&mut self, items: &mut Vec<T>) -> Option<T> {
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
