//! States with something new to a search.
//!
//! A best-first search visits all states with small estimates, also where these mislead. The states with a fact that no state
//! with the same estimate had before are few, and they differ (Lipovetzky and Geffner, "Best-first width search", AAAI
//! 2017, with novelty 1).

use ahash::AHashMap;

use super::Guide;
use super::estimate::Estimate;
use meliora_base::error::Result;
use meliora_space::meter::{Array, Meter};

/// The facts that the states of a search had.
pub(super) struct Novelty {
    /// For each estimate where its facts begin.
    classes: AHashMap<Estimate, usize>,
    /// For each estimate the facts that a state had, as bits.
    seen: Array<u64>,
}

impl Novelty {
    pub(super) fn new(meter: &Meter) -> Self {
        Novelty { classes: AHashMap::new(), seen: Array::new(meter) }
    }

    /// Adds the state whose facts the guide has read. Returns whether it has a fact that no earlier state with the same estimate had.
    ///
    /// # Errors
    /// The memory limit.
    pub(super) fn see(&mut self, guide: &Guide, estimate: Estimate) -> Result<bool> {
        let begin = *self.classes.entry(estimate).or_insert(self.seen.len());
        while self.seen.len() < begin + guide.relaxation.facts.div_ceil(64) {
            self.seen.push(0)?;
        }
        let mut is_new = false;
        for &fact in &guide.facts {
            let (word, bit) = (&mut self.seen[begin + fact as usize / 64], 1 << (fact % 64));
            is_new |= *word & bit == 0;
            *word |= bit;
        }
        Ok(is_new)
    }

    /// Forgets all states.
    pub(super) fn clear(&mut self) {
        self.classes.clear();
        self.seen.truncate(0);
    }
}
