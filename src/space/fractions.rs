//! Fractions by number, with the numbers of their products and sums.

use ahash::AHashMap;

use meliora_base::exact::{Ratio, Real};

/// Fractions, each stored once.
#[derive(Debug, Clone, Default)]
pub struct Fractions {
    list: Vec<Ratio>,
    /// The numbers by fraction; see the hash of [`Real`].
    numbers: AHashMap<Real, u32>,
    products: AHashMap<(u32, u32), u32>,
    sums: AHashMap<(u32, u32), u32>,
}

impl Fractions {
    /// Returns the fractions in the order of their numbers.
    pub fn list(&self) -> &[Ratio] {
        &self.list
    }

    /// Returns the number of a fraction; a new one if the fraction is new.
    pub fn number(&mut self, fraction: Ratio) -> u32 {
        let Fractions { list, numbers, .. } = self;
        *numbers.entry(Real::Finite(fraction)).or_insert_with_key(|fraction| {
            list.extend(fraction.finite().cloned());
            list.len() as u32 - 1
        })
    }

    /// Returns the sums of the fractions and a number, in the same order.
    #[must_use]
    pub fn moved_by(&self, number: &Ratio) -> Self {
        let mut moved = Fractions::default();
        self.list.iter().for_each(|fraction| {
            moved.number(fraction + number);
        });
        moved
    }

    pub(crate) fn product(&mut self, a: u32, b: u32) -> u32 {
        if let Some(&known) = self.products.get(&(a, b)) {
            return known;
        }
        let product = self.number(&self.list[a as usize] * &self.list[b as usize]);
        self.products.insert((a, b), product);
        product
    }

    /// Sorts things with the numbers of their probabilities, and adds those of equal things.
    pub(crate) fn unite<T: Ord>(&mut self, things: &mut Vec<(T, u32)>) {
        if things.len() > 1 {
            things.sort_unstable();
            things.dedup_by(|next, kept| {
                let same = next.0 == kept.0;
                if same {
                    kept.1 = self.sum(kept.1, next.1);
                }
                same
            });
        }
    }

    fn sum(&mut self, a: u32, b: u32) -> u32 {
        if let Some(&known) = self.sums.get(&(a, b)) {
            return known;
        }
        let sum = self.number(&self.list[a as usize] + &self.list[b as usize]);
        self.sums.insert((a, b), sum);
        sum
    }
}
