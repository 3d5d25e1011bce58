//! The graph of the states of a game that have equations.

use bitvec::vec::BitVec;

use super::game_graph::{GameGraph, Rewards};
use super::graph::{EVERY, Edge, Graph, LOST, Rank};
use super::meter::Meter;
use meliora_base::error::Result;
use meliora_base::exact::Ratio;

/// A part of a game: the states that have equations, and the exits.
pub(crate) struct Part<'a> {
    pub(crate) game: &'a GameGraph,
    /// The node of each state: the first ones are exits, the states inside follow in their order, and [`LOST`] is
    /// the node of all other states.
    pub(crate) nodes: Vec<u32>,
    /// The number of exits.
    pub(crate) exits: u32,
    /// The choices that may be taken.
    pub(crate) allowed: &'a BitVec,
    /// The rewards of choices; `None` for probabilities.
    pub(crate) rewards: Option<&'a Rewards>,
}

impl<'a> Part<'a> {
    /// Creates the part with one exit, the states of `end`; all states outside of `inside` are lost.
    pub(crate) fn between(
        game: &'a GameGraph,
        (end, inside): (&BitVec, &BitVec),
        allowed: &'a BitVec,
        rewards: Option<&'a Rewards>,
    ) -> Self {
        let mut next = 0;
        let node = |state: usize| match (end[state], inside[state]) {
            (true, _) => 0,
            (false, false) => LOST,
            (false, true) => {
                next += 1;
                next
            }
        };
        let nodes = (0..game.states()).map(node).collect();
        Part { game, nodes, exits: 1, allowed, rewards }
    }

    /// Returns the graph. Steps into exits are counted. Cost: linear.
    ///
    /// # Errors
    /// The memory limit is reached.
    pub(crate) fn graph(&self, meter: &mut Meter<'_>) -> Result<Graph> {
        let mut graph = Graph::default();
        graph.known.clone_from(&self.game.fractions);
        let free = graph.fraction(Ratio::default());
        (0..self.exits).try_for_each(|_| graph.add_node(Rank::default(), false, meter).map(drop))?;
        let rank = Rank { positive: EVERY, sure: if self.rewards.is_some() { EVERY } else { 0 } };
        let inside = |node: u32| node >= self.exits && node != LOST;
        for &node in self.nodes.iter().filter(|node| inside(**node)) {
            debug_assert_eq!(node as usize, graph.nodes());
            graph.add_node(rank, false, meter)?;
        }
        for (state, &node) in (0..).zip(&self.nodes).filter(|(_, node)| inside(**node)) {
            meter.step()?;
            graph.begin(node, meter)?;
            for (position, choice) in (0..).zip(self.game.choices.of(state)) {
                if !self.allowed[choice] {
                    continue;
                }
                let gain = self.rewards.map(|rewards| rewards.choice(choice).clone());
                let cost = gain.map_or(free, |gain| graph.fraction(gain));
                graph.add_choice(position, cost);
                for (to, weight) in self.game.edges(choice) {
                    let to = self.nodes[to as usize];
                    graph.add_edge(Edge::new(to, weight, to < self.exits));
                }
            }
            graph.end(node, meter)?;
        }
        Ok(graph)
    }
}
