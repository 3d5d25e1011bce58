//! The states of a scope, by number.

use super::index::Index;
use meliora_base::error::Result;

/// The states of a scope, by number.
#[derive(Debug)]
pub enum Space {
    /// The states reached, numbered in this order.
    Indexed(Box<Index>),
    /// Every valuation, numbered in the order of the values; contains their number.
    Every(usize),
}

impl Space {
    /// Returns the number of states.
    #[inline]
    pub fn states(&self) -> usize {
        match self {
            Space::Indexed(index) => index.states(),
            Space::Every(n) => *n,
        }
    }

    /// Returns the code of a state.
    #[inline]
    pub(crate) fn code<const W: usize>(&self, state: usize) -> [u64; W] {
        match self {
            Space::Indexed(index) => fixed(index.code(state)),
            Space::Every(_) => fixed(&[state as u64]),
        }
    }

    /// Returns the number of the state with this code; assigns a new number if necessary.
    #[inline]
    pub(crate) fn number<const W: usize>(&mut self, code: &[u64; W]) -> Result<u32> {
        match self {
            Space::Indexed(index) => index.intern(code),
            Space::Every(_) => Ok(code[0] as u32),
        }
    }

    /// Returns the number of the state with this code, if it is in the scope.
    pub fn find(&self, code: &[u64]) -> Option<usize> {
        match self {
            Space::Indexed(index) => index.find(code).map(|id| id as usize),
            Space::Every(_) => code.first().map(|&c| c as usize),
        }
    }
}

/// Copies words to a code of fixed length; missing words are 0.
#[inline]
pub fn fixed<const W: usize>(words: &[u64]) -> [u64; W] {
    let mut code = [0; W];
    for (to, from) in code.iter_mut().zip(words) {
        *to = *from;
    }
    code
}
