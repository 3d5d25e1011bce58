//! Decision rules: which of the permitted choices a strategy takes.

use super::finite_memory::Memory;

/// A rule that takes one permitted choice in each state, instead of the first one that makes
/// progress. It aims at a number of improvements: the level of its [`Memory`].
///
/// Arenas are given by their positions in [`crate::Improvement::arenas`].
pub trait DecisionRule: Send + Sync {
    /// Returns the number of improvements that the rule aims at from a state, compared with the
    /// reference of an arena; `None` if it does not know the state.
    fn level(&self, arena: Option<usize>, state: &[i64]) -> Option<usize>;

    /// Returns the choice of a state, by its position in the order of the program; `None` at level
    /// 0, and in states that the rule does not know.
    fn pick(&self, memory: Memory, state: &[i64]) -> Option<usize>;

    /// Returns the cost of the choice that [`DecisionRule::pick`] returns; 0 if there is none.
    fn cost(&self, memory: Memory, state: &[i64]) -> f64;

    /// Returns the level after a step by a kept choice, and whether the step counts as an
    /// improvement; `None` if the step is lost or not by a kept choice.
    fn after(&self, memory: Memory, from: &[i64], to: &[i64]) -> Option<(usize, bool)>;
}
