//! Integers as vectors of diagrams, in two's complement, least significant bit first.
//!
//! Every integer has bounds that are valid in every state. The widths follow from the bounds, so
//! that no operation overflows.

use crate::symbolic::store::Store;
use crate::symbolic::store::diagram::Bdd;
use meliora_base::error::Result;

/// Largest absolute value of a bound. Beyond it, [`super::partition`] computes value by value and
/// detects overflow.
const LARGEST: i128 = 1 << 62;

/// An integer that depends on the state.
#[derive(Clone)]
pub(in crate::symbolic) struct SymbolicInteger {
    /// The bits, least significant first; the last one is the sign.
    bits: Vec<Bdd>,
    /// A lower bound of the values.
    pub(in crate::symbolic) low: i64,
    /// An upper bound of the values.
    pub(in crate::symbolic) high: i64,
}

impl SymbolicInteger {
    /// Creates a constant.
    pub(in crate::symbolic) fn constant(store: &Store, value: i64) -> Self {
        let bit = |k: u32| if value >> k.min(63) & 1 == 1 { store.one() } else { store.zero() };
        SymbolicInteger { bits: (0..width(value, value)).map(bit).collect(), low: value, high: value }
    }

    /// Returns `low` plus the unsigned number of the given bits, least significant first.
    pub(in crate::symbolic) fn offset(
        store: &Store,
        mut bits: Vec<Bdd>,
        low: i64,
        high: i64,
    ) -> Result<Self> {
        bits.push(store.zero());
        let span = (i128::from(high) - i128::from(low)) as i64;
        let unsigned = SymbolicInteger { bits, low: 0, high: span };
        let sum = unsigned.add(store, &SymbolicInteger::constant(store, low))?.unwrap_or(unsigned);
        Ok(SymbolicInteger { low, high, ..sum }.narrowed())
    }

    /// Returns bit k; the sign for k past the end.
    pub(in crate::symbolic) fn bit(&self, k: usize) -> &Bdd {
        &self.bits[k.min(self.bits.len() - 1)]
    }

    /// Returns the number of bits, with the sign.
    pub(in crate::symbolic) fn len(&self) -> usize {
        self.bits.len()
    }

    /// Creates an integer from bits whose value is known to be within the bounds.
    pub(in crate::symbolic) fn from_bits(bits: Vec<Bdd>, low: i64, high: i64) -> Self {
        SymbolicInteger { bits, low, high }.narrowed()
    }

    /// Narrows the bounds to tighter ones that the caller knows.
    pub(in crate::symbolic) fn bounded(self, low: i64, high: i64) -> Self {
        SymbolicInteger { low: self.low.max(low), high: self.high.min(high), ..self }.narrowed()
    }

    fn narrowed(mut self) -> Self {
        self.bits.truncate(width(self.low, self.high) as usize);
        self
    }

    /// Computes a + b; `None` if the bounds exceed 2^62.
    pub(in crate::symbolic) fn add(
        &self,
        store: &Store,
        other: &SymbolicInteger,
    ) -> Result<Option<SymbolicInteger>> {
        let low = i128::from(self.low) + i128::from(other.low);
        let high = i128::from(self.high) + i128::from(other.high);
        let Some((low, high)) = within(low, high) else { return Ok(None) };
        if let Some(sum) = self.plus_zero(other) {
            return Ok(Some(sum));
        }
        let (mut bits, mut carry) = (Vec::new(), store.zero());
        for k in 0..width(low, high) as usize {
            let (a, b) = (self.bit(k), other.bit(k));
            let half = store.xor(a, b)?;
            bits.push(store.xor(&half, &carry)?);
            carry = store.ite(&half, &carry, a)?;
        }
        Ok(Some(SymbolicInteger::from_bits(bits, low, high)))
    }

    fn plus_zero(&self, other: &SymbolicInteger) -> Option<SymbolicInteger> {
        match (self.low, self.high, other.low, other.high) {
            (0, 0, ..) => Some(other.clone()),
            (.., 0, 0) => Some(self.clone()),
            _ => None,
        }
    }

    /// Computes -a; `None` if the bounds exceed 2^62.
    pub(in crate::symbolic) fn neg(&self, store: &Store) -> Result<Option<SymbolicInteger>> {
        let Some((low, high)) = within(-i128::from(self.high), -i128::from(self.low)) else {
            return Ok(None);
        };
        let (mut bits, mut carry) = (Vec::new(), store.one());
        for k in 0..width(low, high) as usize {
            let flipped = store.not(self.bit(k))?;
            bits.push(store.xor(&flipped, &carry)?);
            carry = store.and(&flipped, &carry)?;
        }
        Ok(Some(SymbolicInteger::from_bits(bits, low, high)))
    }

    /// Computes a · b by shifted sums; `None` if the bounds exceed 2^62.
    pub(in crate::symbolic) fn mul(
        &self,
        store: &Store,
        other: &SymbolicInteger,
    ) -> Result<Option<SymbolicInteger>> {
        let corner = |x: i64, y: i64| i128::from(x) * i128::from(y);
        let corners = [
            corner(self.low, other.low),
            corner(self.low, other.high),
            corner(self.high, other.low),
            corner(self.high, other.high),
        ];
        let bounds = corners.iter().min().zip(corners.iter().max());
        let Some((low, high)) = bounds.and_then(|(&l, &h)| within(l, h)) else { return Ok(None) };
        let width = width(low, high) as usize;
        // Modulo 2^width, where the sign bits of both factors are extended as far as needed.
        let mut sum: Vec<Bdd> = vec![store.zero(); width];
        for shift in 0..width {
            let factor = other.bit(shift);
            if store.is_zero(factor) {
                continue;
            }
            let mut carry = store.zero();
            for (k, digit) in sum.iter_mut().skip(shift).enumerate() {
                let term = store.and(factor, self.bit(k))?;
                let half = store.xor(digit, &term)?;
                let next = store.ite(&half, &carry, &term)?;
                *digit = store.xor(&half, &carry)?;
                carry = next;
            }
        }
        Ok(Some(SymbolicInteger::from_bits(sum, low, high)))
    }

    /// Computes a mod n for a constant n > 0; the result is never negative. `None` if intermediate
    /// bounds exceed 2^62.
    pub(in crate::symbolic) fn modulo(&self, store: &Store, n: i64) -> Result<Option<SymbolicInteger>> {
        // Shift into the non-negative numbers by a multiple of n.
        let lift = if self.low < 0 {
            (-i128::from(self.low) + i128::from(n) - 1) / i128::from(n) * i128::from(n)
        } else {
            0
        };
        let Some((lift, _)) = within(lift, lift) else { return Ok(None) };
        let Some(mut rest) = self.add(store, &SymbolicInteger::constant(store, lift))? else {
            return Ok(None);
        };
        let mut shift = 0;
        while i128::from(n) << (shift + 1) <= i128::from(rest.high) {
            shift += 1;
        }
        for k in (0..=shift).rev() {
            let subtrahend = SymbolicInteger::constant(store, n << k);
            let fits = subtrahend.le(store, &rest)?;
            let Some(less) = rest.add(store, &SymbolicInteger::constant(store, -(n << k)))? else {
                return Ok(None);
            };
            let high = ((n << k) - 1).min(rest.high);
            rest = less.select(store, &fits, &rest)?;
            rest = SymbolicInteger { low: 0, high, ..rest }.narrowed();
        }
        Ok(Some(rest))
    }

    /// Computes: if c then a else b.
    pub(in crate::symbolic) fn select(
        &self,
        store: &Store,
        c: &Bdd,
        other: &SymbolicInteger,
    ) -> Result<SymbolicInteger> {
        let (low, high) = (self.low.min(other.low), self.high.max(other.high));
        let bit = |k| store.ite(c, self.bit(k), other.bit(k));
        let bits = (0..width(low, high) as usize).map(bit).collect::<Result<_>>()?;
        Ok(SymbolicInteger::from_bits(bits, low, high))
    }

    /// Computes a = b.
    pub(in crate::symbolic) fn eq(&self, store: &Store, other: &SymbolicInteger) -> Result<Bdd> {
        if self.high < other.low || other.high < self.low {
            return Ok(store.zero());
        }
        let mut equal = store.one();
        for k in 0..self.len().max(other.len()) {
            equal = store.and(&store.iff(self.bit(k), other.bit(k))?, &equal)?;
        }
        Ok(equal)
    }

    /// Computes a ≤ b.
    pub(in crate::symbolic) fn le(&self, store: &Store, other: &SymbolicInteger) -> Result<Bdd> {
        self.ordered(store, other, store.one())
    }

    /// Computes a < b.
    pub(in crate::symbolic) fn lt(&self, store: &Store, other: &SymbolicInteger) -> Result<Bdd> {
        self.ordered(store, other, store.zero())
    }

    fn ordered(&self, store: &Store, other: &SymbolicInteger, if_equal: Bdd) -> Result<Bdd> {
        if self.high < other.low {
            return Ok(store.one());
        }
        if self.low > other.high {
            return Ok(store.zero());
        }
        let mut result = if_equal;
        let width = self.len().max(other.len());
        for k in 0..width {
            let (a, b) = (self.bit(k), other.bit(k));
            let differ = store.xor(a, b)?;
            // The most significant bit in which they differ decides; for the sign bit, 1 is the
            // smaller.
            let less = if k + 1 == width { a } else { b };
            result = store.ite(&differ, less, &result)?;
        }
        Ok(result)
    }
}

/// Returns the number of bits, with the sign, of a two's complement number that can represent both
/// bounds.
fn width(low: i64, high: i64) -> u32 {
    let needed = |x: i64| 65 - if x < 0 { (!x).leading_zeros() } else { x.leading_zeros() };
    needed(low).max(needed(high))
}

fn within(low: i128, high: i128) -> Option<(i64, i64)> {
    (-LARGEST <= low && high <= LARGEST).then_some((low as i64, high as i64))
}
