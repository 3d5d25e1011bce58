//! Choices by their states, and by their successors.

use std::ops::Range;

use super::ExplicitEngine;
use meliora_base::error::Result;
use meliora_space::set::{BitSet, set, test};

impl ExplicitEngine {
    /// Returns { (s,a) ∈ C : s ∈ X }.
    pub(super) fn choices_of_states(&self, c: &BitSet, x: &BitSet) -> Result<BitSet> {
        if self.graph.choices() == self.graph.states() {
            return c.zip(x, |c, x| c & x);
        }
        if x.count() == self.graph.states() as u64 {
            return Ok(c.clone());
        }
        let mut found = BitSet::empty(&self.meter, self.graph.choices());
        let words = found.words_mut();
        for states in x.runs() {
            set_range(words, self.graph.choices_of_range(states));
        }
        for (found, &c) in words.iter_mut().zip(c.words()) {
            *found &= c;
        }
        Ok(found)
    }

    /// Returns { (s,a) ∈ C : succ(s,a) ∩ X ≠ ∅ }.
    pub(super) fn choices_into(&self, c: &BitSet, x: &BitSet) -> Result<BitSet> {
        let mut found = BitSet::empty(&self.meter, self.graph.choices());
        let (words, within, into) = (found.words_mut(), c.words(), x.words());
        match self.graph.known_predecessors() {
            // A look at an edge backwards takes several times as long as one forwards.
            Some(graph) if x.count() < c.count() / 8 => {
                for state in x.iter() {
                    self.tick()?;
                    let entering = graph.of(state).iter().map(|&choice| choice as usize);
                    entering.filter(|&choice| test(within, choice)).for_each(|choice| set(words, choice));
                }
            }
            _ => {
                for choice in c.iter() {
                    self.tick()?;
                    if self.graph.successors_of(choice).iter().any(|&s| test(into, s as usize)) {
                        set(words, choice);
                    }
                }
            }
        }
        Ok(found)
    }
}

/// Sets the bits of a range.
fn set_range(words: &mut [u64], range: Range<usize>) {
    let mut at = range.start;
    while at < range.end {
        let bit = at & 63;
        let n = (64 - bit).min(range.end - at);
        words[at >> 6] |= (u64::MAX >> (64 - n)) << bit;
        at += n;
    }
}
