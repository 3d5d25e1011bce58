//! The encoding of states as words.
//!
//! A state is a short vector of words, its *code*. Each variable has a weight in one word. Changing
//! a variable adds (new - old) · weight, independent of all other changes. The code of a successor
//! is therefore the code of its source plus one difference per command. There are two layouts:
//! `packed`, whose weights are powers of two, and `radix`, which numbers all valuations without a
//! gap. Codes compare as the values do, first variable first.

use smallvec::SmallVec;

use meliora_base::error::{Limit, Result};
use meliora_model::{Program, Variable};

/// Maximum number of words in a code.
pub const MOST_WORDS: usize = 32;

/// Computes an expression that names `$W`, the number of words of a code, as a constant.
macro_rules! by_words {
    ($words:expr, $W:ident => $result:expr) => {{
        macro_rules! with {
            ($constant:literal) => {{
                const $W: usize = $constant;
                $result
            }};
        }
        match $words {
            1 => with!(1),
            2 => with!(2),
            3..=4 => with!(4),
            5..=8 => with!(8),
            9..=16 => with!(16),
            _ => with!(32),
        }
    }};
}
pub(crate) use by_words;

/// A state in few bytes. Codes compare as the values do.
pub type Code = SmallVec<[u64; 2]>;

/// The position of a variable in a code.
#[derive(Debug, Clone, Copy)]
pub struct Field {
    word: u32,
    shift: u32,
    /// The amount that an increment of the variable adds to its word.
    weight: u64,
    low: i64,
    /// The number of values minus 1.
    width: u64,
    /// The bits of the greatest value, if the lowest one is 0.
    mask: u64,
}

/// The layout of codes.
#[derive(Debug, Clone)]
pub struct Layout {
    fields: Vec<Field>,
    words: usize,
    /// The number of valuations in a `radix` layout.
    valuations: Option<u64>,
}

impl Layout {
    /// Creates a layout in which each variable has its own bits within one word.
    ///
    /// # Errors
    /// A code would need more than [`MOST_WORDS`] words.
    pub fn packed(program: &Program) -> Result<Self> {
        let mut sizes: Vec<u32> = program.variables.iter().map(|v| v.bits()).collect();
        let mut places = Vec::new();
        let (mut word, mut used) = (0, 0);
        for bits in &mut sizes {
            if used + *bits > 64 {
                (word, used) = (word + 1, 0);
            }
            used += *bits;
            places.push((word, 64 - used));
        }
        let words = (word as usize + 1).next_power_of_two();
        if words > MOST_WORDS {
            let bits: u32 = sizes.iter().sum();
            let what = format!(
                "states of {bits} bits; where they are stored one by one, at most 2048 are supported"
            );
            return Err(Limit::Size { what }.into());
        }
        // A variable with one value may be placed after the last bit of a word; its weight is not
        // used.
        let field = |(v, (word, shift)): (&Variable, (u32, u32))| {
            Field::new(v, (word, shift & 63), 1 << (shift & 63))
        };
        let fields = program.variables.iter().zip(places).map(field).collect();
        Ok(Layout { fields, words, valuations: None })
    }

    /// Creates a layout that numbers all valuations in the order of their values; `None` if there
    /// are 2^32 or more.
    pub fn radix(program: &Program) -> Option<Self> {
        let mut fields = Vec::new();
        let mut weight: u64 = 1;
        for v in program.variables.iter().rev() {
            let width = width(v);
            fields.push(Field::new(v, (0, 0), weight));
            weight = weight.checked_mul(width.checked_add(1)?)?;
            u32::try_from(weight).ok()?;
        }
        fields.reverse();
        Some(Layout { fields, words: 1, valuations: Some(weight) })
    }

    /// Returns the number of words of a code: a power of two, at most [`MOST_WORDS`].
    pub fn words(&self) -> usize {
        self.words
    }

    /// Returns the number of low bits of the last word that no variable uses; 0 in a [`Layout::radix`].
    pub fn spare(&self) -> u32 {
        let last = self.words as u32 - 1;
        let own = self.fields.iter().filter(|field| field.word == last && field.width > 0);
        if self.valuations.is_some() { 0 } else { own.map(|field| field.shift).min().unwrap_or(u64::BITS) }
    }

    /// Returns the number of valuations of a [`Layout::radix`], else `None`.
    pub fn valuations(&self) -> Option<u64> {
        self.valuations
    }

    /// Returns the field of a variable.
    pub fn field(&self, variable: usize) -> Field {
        self.fields[variable]
    }

    /// Returns the bits of a code on which the values of some variables depend.
    pub fn mask(&self, variables: impl IntoIterator<Item = usize>) -> Code {
        let mut mask = Code::from_elem(0, self.words);
        for field in variables.into_iter().map(|variable| &self.fields[variable]) {
            let own = if self.valuations.is_some() { u64::MAX } else { field.mask << field.shift };
            mask[field.word as usize] |= own;
        }
        mask
    }

    /// Writes the values of a state to the first entries of `values`.
    #[inline]
    pub fn decode(&self, code: &[u64], values: &mut [i64]) {
        if self.valuations.is_some() {
            for (field, value) in self.fields.iter().zip(values) {
                *value = field.radix_value(code);
            }
        } else {
            for (field, value) in self.fields.iter().zip(values) {
                *value = field.packed_value(code);
            }
        }
    }

    /// Returns the value of one variable.
    #[inline]
    pub fn value(&self, code: &[u64], variable: usize) -> i64 {
        let field = &self.fields[variable];
        if self.valuations.is_some() { field.radix_value(code) } else { field.packed_value(code) }
    }

    /// Returns the code of a valuation; `None` if a value is out of range or the length is wrong.
    pub fn encode(&self, values: &[i64]) -> Option<Code> {
        if values.len() != self.fields.len() {
            return None;
        }
        let mut code = Code::from_elem(0, self.words);
        for (field, &value) in self.fields.iter().zip(values) {
            if !field.holds(value) {
                return None;
            }
            field.add(&mut code, field.low, value);
        }
        Some(code)
    }
}

impl Field {
    fn new(variable: &Variable, (word, shift): (u32, u32), weight: u64) -> Self {
        let width = width(variable);
        let mask = u64::MAX.checked_shr(width.leading_zeros()).unwrap_or(0);
        Field { word, shift, weight, low: variable.low, width, mask }
    }

    /// Returns whether a value is in the variable's range.
    #[inline]
    pub fn holds(&self, value: i64) -> bool {
        value >= self.low && value.wrapping_sub(self.low) as u64 <= self.width
    }

    /// Adds (new - old) · weight.
    #[inline]
    pub fn add(&self, code: &mut [u64], old: i64, new: i64) {
        let difference = (new.wrapping_sub(old) as u64).wrapping_mul(self.weight);
        let word = &mut code[self.word as usize];
        *word = word.wrapping_add(difference);
    }

    #[inline]
    fn packed_value(&self, code: &[u64]) -> i64 {
        self.low.wrapping_add((code[self.word as usize] >> self.shift & self.mask) as i64)
    }

    #[inline]
    fn radix_value(&self, code: &[u64]) -> i64 {
        self.low.wrapping_add((code[0] / self.weight % (self.width + 1)) as i64)
    }
}

/// Returns the number of values of a variable minus 1.
pub fn width(variable: &Variable) -> u64 {
    variable.high.wrapping_sub(variable.low) as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_field_of_one_value_takes_no_bits() {
        let field = Field { word: 0, shift: 0, weight: 1, low: 7, width: 0, mask: 0 };
        assert_eq!(field.packed_value(&[u64::MAX]), 7);
        assert!(field.holds(7) && !field.holds(8) && !field.holds(6));
    }
}
