//! The choices of a state with their successors and the numbers of their probabilities.

use std::ops::Range;

use super::fractions::Fractions;
use meliora_model::step::{Choice, Combination};

/// The successors of all choices of a state.
#[derive(Debug, Default)]
pub struct Steps {
    /// The number of words of a code.
    words: usize,
    /// The codes of the successors, one after the other: each once per choice, ordered by values.
    codes: Vec<u64>,
    /// The number of the probability of each successor.
    weights: Vec<u32>,
    /// The end of each choice in `weights`.
    ends: Vec<u32>,
}

impl Steps {
    /// Returns the number of choices.
    pub fn choices(&self) -> usize {
        self.ends.len()
    }

    /// Returns the places of the successors of a choice among those of all choices.
    pub fn range(&self, choice: usize) -> Range<usize> {
        let start = choice.checked_sub(1).map_or(0, |before| self.ends[before]) as usize;
        start..self.ends[choice] as usize
    }

    /// Returns the successors of a choice, with the numbers of their probabilities.
    pub fn of(&self, choice: usize) -> impl Iterator<Item = (&[u64], u32)> {
        let own = self.range(choice);
        let codes = self.codes[own.start * self.words..own.end * self.words].chunks_exact(self.words);
        codes.zip(self.weights[own].iter().copied())
    }

    /// Returns the successors of all choices, in their order.
    pub fn codes(&self) -> impl Iterator<Item = &[u64]> {
        self.codes.chunks_exact(self.words)
    }

    /// Returns the numbers of the probabilities of the successors of a choice.
    pub fn weights(&self, choice: usize) -> &[u32] {
        &self.weights[self.range(choice)]
    }

    /// Forgets all choices.
    pub fn clear(&mut self, words: usize) {
        self.words = words;
        self.codes.clear();
        self.weights.clear();
        self.ends.clear();
    }

    /// Adds a choice. Its successors are sorted, and the probabilities of equal ones are added.
    pub fn add<const W: usize>(&mut self, successors: &mut Vec<([u64; W], u32)>, fractions: &mut Fractions) {
        fractions.unite(successors);
        for (code, weight) in successors.drain(..) {
            self.codes.extend(&code[..self.words]);
            self.weights.push(weight);
        }
        self.ends.push(self.weights.len() as u32);
    }
}

/// A choice, and the combinations of commands that it draws from; none for a deadlock.
#[derive(Debug, Clone)]
pub struct Taken {
    /// The choice.
    pub choice: Choice,
    /// The combinations.
    pub combinations: Vec<Combination>,
}
