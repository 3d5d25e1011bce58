//! The numbers of several codes, which are looked up together.
//!
//! A look-up waits for memory, and look-ups of different codes wait at the same time. States that are explored one after
//! the other have many successors in common, so the last codes are kept with their numbers.

use super::index::{Index, NOBODY};
use meliora_base::error::Result;

/// Number of codes that are kept: they stay in a cache of the processor.
const PLACES: usize = 1 << 12;

/// Looks up the numbers of codes.
pub(crate) struct Lookup<const W: usize> {
    /// The last code of each place with its number, or [`NOBODY`].
    kept: Vec<([u64; W], u32)>,
    /// The codes that are not kept.
    open: Vec<Open>,
}

/// A code that is looked up.
#[derive(Clone, Copy)]
struct Open {
    position: u32,
    /// The first slot.
    slot: u32,
    hash: u64,
}

impl<const W: usize> Lookup<W> {
    pub(crate) fn new() -> Self {
        Lookup { kept: vec![([0; W], NOBODY); PLACES], open: Vec::new() }
    }

    /// Replaces the content of `numbers` by those of some codes in their order, new ones for those that are new.
    ///
    /// # Errors
    /// The errors of [`Index::intern`].
    pub(crate) fn numbers(
        &mut self,
        index: &mut Index,
        codes: &[[u64; W]],
        numbers: &mut Vec<u32>,
    ) -> Result<()> {
        self.recall(index, codes, numbers);
        self.open.iter_mut().for_each(|code| code.slot = index.slot(code.hash));
        let size = index.slots();
        for &Open { position, slot, hash } in &self.open {
            let code = &codes[position as usize];
            let number = match index.find_from(code, hash, (slot, size)) {
                Some(number) => number,
                None => index.insert(code, hash)?,
            };
            numbers[position as usize] = number;
            self.kept[place(hash)] = (*code, number);
        }
        Ok(())
    }

    /// Replaces the content of `numbers` by those of the codes that are kept. The others are open.
    fn recall(&mut self, index: &Index, codes: &[[u64; W]], numbers: &mut Vec<u32>) {
        numbers.clear();
        self.open.resize(codes.len(), Open { position: 0, slot: NOBODY, hash: 0 });
        // Often half of the codes are kept. Without branches, no prediction of this is wrong.
        let mut open = 0;
        for (position, code) in (0..).zip(codes) {
            let hash = index.hash_of(code);
            let (kept, number) = &self.kept[place(hash)];
            let differences = kept.iter().zip(code).fold(0, |all, (one, other)| all | (one ^ other));
            let is_kept = (differences == 0) & (*number != NOBODY);
            numbers.push(*number);
            self.open[open] = Open { position, slot: NOBODY, hash };
            open += usize::from(!is_kept);
        }
        self.open.truncate(open);
    }
}

/// Returns the place of a code with this hash.
#[inline]
fn place(hash: u64) -> usize {
    hash as usize % PLACES
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::meter::Meter;

    #[test]
    fn codes_keep_their_numbers_while_the_index_grows() {
        let mut index = Index::new(2, &Meter::new(1 << 30));
        let code = |i: u64| [i.wrapping_mul(0x9e37_79b9_7f4a_7c15), i % 7];
        let (mut lookup, mut found) = (Lookup::new(), Vec::new());
        (0..20_000).for_each(|i| assert_eq!(index.intern(&code(i)).unwrap(), i as u32));
        // New ones after old ones, again while they are kept, and after others took their places.
        for numbers in [19_990..70_000, 69_000..70_010, 0..40_000, 0..10] {
            let codes = Vec::from_iter(numbers.clone().chain(numbers.clone()).map(code));
            lookup.numbers(&mut index, &codes, &mut found).unwrap();
            let wanted = numbers.clone().chain(numbers).map(|i| i as u32);
            assert_eq!(found, Vec::from_iter(wanted));
        }
        assert_eq!(index.find(&code(70_010)), None);
        // No code is kept where the first one is all zeros.
        let mut empty = Index::new(2, &Meter::new(1 << 20));
        Lookup::new().numbers(&mut empty, &[[0, 0], [0, 0], [1, 0]], &mut found).unwrap();
        assert_eq!(found, [0, 0, 1]);
    }
}
