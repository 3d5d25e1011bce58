//! The nodes of a strategy as a game in which we have one choice: a Markov chain, or the choices of the opponent.

use bitvec::vec::BitVec;
use meliora_base::error::Result;
use meliora_equations::vector::Asked;
use meliora_equations::{Arena, Extremes, GameGraph};

/// The nodes of a strategy for an arena, as a game.
pub(super) struct Chain<'a> {
    pub(super) arena: &'a Arena<'a>,
    pub(super) game: GameGraph,
}

impl<'a> Chain<'a> {
    /// Asks for the values of all nodes.
    pub(super) fn asked(&'a self, goal: Extremes, precision: f64) -> Asked<'a> {
        Asked { game: &self.game, ..Asked::all(self.arena, goal, precision) }
    }

    /// Returns all nodes, or none.
    pub(super) fn all(&self, inside: bool) -> BitVec {
        BitVec::repeat(inside, self.game.states())
    }

    /// Returns the nodes of the components that are never left and satisfy a condition.
    pub(super) fn ends(&self, is_satisfied: impl Fn(&[u32]) -> bool) -> BitVec {
        let mut ends = self.all(false);
        for component in self.game.choices.bottoms() {
            let is_end = is_satisfied(&component);
            component.iter().for_each(|&node| ends.set(node as usize, is_end));
        }
        ends
    }

    /// Returns the nodes from which some are reached through others. Cost: linear.
    pub(super) fn near(&self, target: &BitVec, left: &BitVec) -> Result<BitVec> {
        self.game.reaching(target, left, &mut self.arena.meter())
    }
}
