//! The support of a partial relation.

use std::hash::{Hash, Hasher};
use std::sync::Arc;

/// The bits that a partial relation may write, in the order of their levels. The relation is over
/// their present and next copies; other bits it may only read. Bits above the current level are
/// skipped.
#[derive(Debug, Clone)]
pub(in crate::symbolic) struct Support {
    bits: Arc<[u32]>,
    /// The number of leading bits that are skipped.
    passed: usize,
}

impl Support {
    /// Creates the set of the given bits.
    pub(in crate::symbolic) fn new(bits: impl IntoIterator<Item = u32>) -> Self {
        let mut bits: Vec<u32> = bits.into_iter().collect();
        bits.sort_unstable();
        bits.dedup();
        Support { bits: bits.into(), passed: 0 }
    }

    /// Returns the support bits in the order of their levels.
    pub(in crate::symbolic) fn bits(&self) -> &[u32] {
        &self.bits[self.passed..]
    }

    /// Returns the first support bit; `u32::MAX` if there is none.
    pub(in crate::symbolic) fn top(&self) -> u32 {
        self.bits().first().copied().unwrap_or(u32::MAX)
    }

    /// Returns the support bits after `bit`; there must be none before it.
    pub(in crate::symbolic) fn below(&self, bit: u32) -> Self {
        let passed = self.passed + usize::from(self.top() == bit);
        Support { bits: self.bits.clone(), passed }
    }

    /// Returns the support bits from `bit` on.
    pub(in crate::symbolic) fn from(&self, bit: u32) -> Self {
        let passed = self.passed + self.bits().partition_point(|&b| b < bit);
        Support { bits: self.bits.clone(), passed }
    }

    /// Returns the union of two supports.
    pub(in crate::symbolic) fn union(&self, other: &Self) -> Self {
        Support::new(self.bits().iter().chain(other.bits()).copied())
    }

    /// Returns true if there are no support bits.
    pub(in crate::symbolic) fn is_empty(&self) -> bool {
        self.bits().is_empty()
    }

    /// Returns the number of support bits.
    pub(in crate::symbolic) fn len(&self) -> usize {
        self.bits().len()
    }
}

impl PartialEq for Support {
    fn eq(&self, other: &Self) -> bool {
        self.bits() == other.bits()
    }
}

impl Eq for Support {}

impl PartialOrd for Support {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Support {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.bits().cmp(other.bits())
    }
}

impl Hash for Support {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.bits().hash(state);
    }
}
