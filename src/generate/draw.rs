//! Random draws that are the same for ever: a fixed stream cipher, and the few ways to draw from it
//! written here, since libraries reserve the right to change theirs.

use rand::rngs::ChaCha8Rng;
use rand::{Rng, SeedableRng};

/// A source of random draws.
pub(super) struct Draw(ChaCha8Rng);

impl Draw {
    /// The source for a seed.
    pub(super) fn new(seed: u64) -> Self {
        // The seed fills the key in a way that is ours, too.
        let mut key = [0; 32];
        key[..8].copy_from_slice(&seed.to_le_bytes());
        Draw(ChaCha8Rng::from_seed(key))
    }

    /// A number below `count` (0 where there is none), each as likely to within 2^-32 or better.
    pub(super) fn below(&mut self, count: usize) -> usize {
        let product = u128::from(self.0.next_u64()) * (count as u128);
        usize::try_from(product >> 64).unwrap_or(0)
    }

    /// Puts the items into a random order.
    pub(super) fn shuffle<T>(&mut self, items: &mut [T]) {
        for last in (1..items.len()).rev() {
            items.swap(last, self.below(last + 1));
        }
    }

    /// Takes a random item out; the order of the others changes.
    pub(super) fn take<T>(&mut self, items: &mut Vec<T>) -> Option<T> {
        (!items.is_empty()).then(|| items.swap_remove(self.below(items.len())))
    }
}
