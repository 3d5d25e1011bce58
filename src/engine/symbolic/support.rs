//! Which bits a relation touches.

use std::hash::{Hash, Hasher};
use std::sync::Arc;

/// The bits that a relation touches, in the order of their levels: its bits and their next copies are
/// in it. Below a bit only the later ones count.
#[derive(Debug, Clone)]
pub(super) struct Support {
    bits: Arc<[u32]>,
    /// How many of the bits lie above.
    passed: usize,
}

impl Support {
    /// The set of the given bits.
    pub(super) fn new(bits: impl IntoIterator<Item = u32>) -> Self {
        let mut bits: Vec<u32> = bits.into_iter().collect();
        bits.sort_unstable();
        bits.dedup();
        Support { bits: bits.into(), passed: 0 }
    }

    /// The support bits in the order of their levels.
    pub(super) fn bits(&self) -> &[u32] {
        &self.bits[self.passed..]
    }

    /// The first support bit; `u32::MAX` where nothing is support.
    pub(super) fn top(&self) -> u32 {
        self.bits().first().copied().unwrap_or(u32::MAX)
    }

    /// The support bits after `bit`, before which there are none.
    pub(super) fn below(&self, bit: u32) -> Self {
        let passed = self.passed + usize::from(self.top() == bit);
        Support { bits: self.bits.clone(), passed }
    }

    /// The support bits from `bit` on.
    pub(super) fn from(&self, bit: u32) -> Self {
        let passed = self.passed + self.bits().partition_point(|&b| b < bit);
        Support { bits: self.bits.clone(), passed }
    }

    /// The bits of either.
    pub(super) fn union(&self, other: &Self) -> Self {
        Support::new(self.bits().iter().chain(other.bits()).copied())
    }

    /// Whether nothing is support.
    pub(super) fn is_empty(&self) -> bool {
        self.bits().is_empty()
    }

    /// How many bits are support.
    pub(super) fn len(&self) -> usize {
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
