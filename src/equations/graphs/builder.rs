//! A game that is made state by state.

use bitvec::vec::BitVec;
use meliora_base::exact::Ratio;
use num_traits::Zero;

use super::game_graph::{Edge, GameGraph, Rewards};

/// A game that is made state by state, with rewards of its choices.
#[derive(Debug)]
pub struct Builder {
    game: GameGraph,
    rewards: Rewards,
}

impl Builder {
    /// Begins a game with the probabilities of another one, and with an opponent if that has one.
    pub fn new(of: &GameGraph) -> Self {
        let theirs = of.theirs.as_ref().map(|_| BitVec::new());
        let game = GameGraph { fractions: of.fractions.clone(), theirs, ..GameGraph::default() };
        Builder { game, rewards: Rewards::default() }
    }

    /// Returns the number of a probability, for [`Edge::new`].
    pub fn number(&mut self, probability: Ratio) -> u32 {
        self.game.fractions.number(probability)
    }

    /// Adds an edge to the next choice.
    pub fn edge(&mut self, edge: Edge) {
        self.game.add_edge(edge);
    }

    /// Ends the next choice, which earns a reward.
    pub fn end_choice(&mut self, reward: Ratio) {
        self.game.end_choice();
        let reward = self.rewards.fractions.number(reward);
        self.rewards.of_choice.push(reward);
    }

    /// Ends the next state, in which the opponent chooses or we do; it earns nothing itself.
    pub fn end_state(&mut self, is_theirs: bool) {
        self.game.end_node();
        self.game.theirs.iter_mut().for_each(|theirs| theirs.push(is_theirs));
        let nothing = self.rewards.fractions.number(Ratio::zero());
        self.rewards.of_state.push(nothing);
    }

    /// Returns the game and the rewards.
    pub fn built(self) -> (GameGraph, Rewards) {
        (self.game, self.rewards)
    }
}
