//! The truth values of a condition by the bits of a code on which they depend.

use super::layout::Code;

/// Number of values that are kept.
const PLACES: usize = 1 << 12;

/// The last values of a condition. Many states agree in the few variables of a condition.
pub struct Known {
    /// The bits on which the condition depends.
    mask: Code,
    /// For each place, 2 for true, 1 for false or 0 without a value, and the bits of a code.
    places: Vec<u64>,
}

impl Known {
    /// Begins without values, given the bits on which the condition depends.
    pub fn new(mask: Code) -> Self {
        Known { places: vec![0; PLACES * (mask.len() + 1)], mask }
    }

    /// Returns the value for a code; evaluates the condition if it is not known.
    ///
    /// # Errors
    /// The error of the evaluation.
    #[inline]
    pub fn get<E>(
        &mut self,
        code: &[u64],
        evaluate: impl FnOnce(&[u64]) -> Result<bool, E>,
    ) -> Result<bool, E> {
        let words = || code.iter().zip(&*self.mask).map(|(word, mask)| word & mask);
        let hash = words().fold(0, |hash: u64, word| (hash ^ word).wrapping_mul(0x9e37_79b9_7f4a_7c15));
        let at = (hash >> (u64::BITS - PLACES.trailing_zeros())) as usize * (self.mask.len() + 1);
        let [value, bits @ ..] = &mut self.places[at..=at + self.mask.len()] else {
            return evaluate(code);
        };
        if *value == 0 || !bits.iter().copied().eq(words()) {
            *value = 1 + u64::from(evaluate(code)?);
            bits.iter_mut().zip(words()).for_each(|(to, from)| *to = from);
        }
        Ok(*value == 2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_is_kept_for_all_codes_with_the_same_bits_and_for_no_others() {
        let mut known = Known::new(Code::from_slice(&[0xffff << 40, 1]));
        let mut evaluated = 0;
        for round in 0..3 {
            for i in 0..9_000u64 {
                let code = [i << 40 | round, i ^ round << 1];
                let wanted = i % 7 < 3;
                let evaluate = |_: &[u64]| {
                    evaluated += 1;
                    Ok::<bool, ()>(wanted)
                };
                assert_eq!([known.get(&code, evaluate), known.get(&code, |_| Err(()))], [Ok(wanted); 2]);
            }
        }
        assert!(evaluated > 9_000 && known.get(&[1 << 55, 0], |_| Err(())) == Err(()));
        let mut constant = Known::new(Code::from_slice(&[0, 0]));
        assert_eq!(constant.get(&[1, 2], |_| Ok::<bool, ()>(false)), Ok(false));
        assert_eq!(constant.get(&[3, 4], |_| Err(())), Ok(false));
    }
}
