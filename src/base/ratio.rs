//! Exact fractions, and how long they may be.

use num_rational::BigRational;

/// An exact fraction.
pub type Ratio = BigRational;

/// Maximum number of bits of the numerator and of the denominator of a fraction.
pub const MOST_BITS: u64 = 1 << 14;

/// Returns whether a fraction has at most [`MOST_BITS`] bits.
pub(crate) fn is_short(x: &Ratio) -> bool {
    x.numer().bits().max(x.denom().bits()) <= MOST_BITS
}
