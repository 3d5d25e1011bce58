//! The choices of one state, for callers that do not know how many words a code has.

use smallvec::SmallVec;

use super::layout::{Layout, by_words};
use super::program::Prepared;
use super::stepper::{Broken, Stepper};

/// A [`Stepper`] for codes of any number of words.
pub trait Expand {
    /// Moves to a state and discards the results for the last one.
    fn enter(&mut self, layout: &Layout, code: &[u64]);

    /// Lists the choices of the current state; see [`Stepper::expand`].
    ///
    /// # Errors
    /// A command has no meaning in the state, or there are too many choices.
    fn expand(&mut self) -> Result<(), Broken>;

    /// Lists the same choices, given the synchronisations that may have some, in their order.
    ///
    /// # Errors
    /// The errors of [`Expand::expand`].
    fn expand_among(&mut self, among: &mut dyn Iterator<Item = usize>) -> Result<(), Broken>;

    /// Returns the synchronisations that have choices in the current state, in their order.
    fn active(&self) -> &[usize];

    /// Returns the number of choices of a synchronisation in the current state, which is expanded.
    fn combinations(&self, index: usize) -> usize;

    /// Returns the commands of one of these choices; see [`Stepper::combination`].
    fn combination(&self, index: usize, number: usize) -> SmallVec<[u32; 4]>;

    /// Returns the end of each choice in the list of the successors of the current state.
    fn ends(&self) -> &[u32];

    /// Turns the code of the current state into that of a successor.
    fn step(&self, successor: usize, code: &mut [u64]);

    /// Returns the position of the choice of some commands; see [`Stepper::position`].
    ///
    /// # Errors
    /// A command has no meaning in the state.
    fn position(
        &mut self,
        synchronisation: usize,
        commands: &mut dyn ExactSizeIterator<Item = u32>,
    ) -> Result<Option<usize>, Broken>;
}

/// Creates a stepper for a program, for codes with a number of words.
pub fn stepper(prepared: &Prepared, words: usize) -> Box<dyn Expand + '_> {
    by_words!(words, W => Box::new(Stepper::<W>::new(prepared)))
}

impl<const W: usize> Expand for Stepper<'_, W> {
    fn enter(&mut self, layout: &Layout, code: &[u64]) {
        Stepper::enter(self, layout, code);
    }

    fn expand(&mut self) -> Result<(), Broken> {
        Stepper::expand(self)
    }

    fn expand_among(&mut self, among: &mut dyn Iterator<Item = usize>) -> Result<(), Broken> {
        Stepper::expand_among(self, among)
    }

    fn active(&self) -> &[usize] {
        &self.active
    }

    fn combinations(&self, index: usize) -> usize {
        Stepper::combinations(self, index)
    }

    fn combination(&self, index: usize, number: usize) -> SmallVec<[u32; 4]> {
        Stepper::combination(self, index, number)
    }

    fn ends(&self) -> &[u32] {
        &self.ends
    }

    fn step(&self, successor: usize, code: &mut [u64]) {
        code.iter_mut()
            .zip(&self.steps[successor])
            .for_each(|(word, change)| *word = word.wrapping_add(*change));
    }

    fn position(
        &mut self,
        synchronisation: usize,
        commands: &mut dyn ExactSizeIterator<Item = u32>,
    ) -> Result<Option<usize>, Broken> {
        Stepper::position(self, synchronisation, commands)
    }
}
