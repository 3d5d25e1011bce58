//! The value that a strategy attains: that of the chain that its nodes leave, or of the choices of the opponent there.
//!
//! Nodes remember the steps, so a bound is a set of nodes, and the chain has the equations of a formula without bounds.

use bitvec::vec::BitVec;
use meliora_base::error::Result;
use meliora_base::exact::Ratio;

use super::nodes::Key;
use super::{Accepting, Aim, Nodes};
use crate::equations::arena::{Arena, Extremes, Rewards};
use crate::equations::choices::Choices;
use crate::equations::game_graph::{Edge, GameGraph};
use crate::equations::meter::Meter;
use crate::path_values::Value;
use crate::solvers::reaching::Vector;
use crate::vector::{self, Accumulation, Until};
use meliora_base::number::Number;

/// Computes the values of a strategy in its first nodes, against the best choices of the opponent; with fractions where
/// bounds are wider than the precision. Cost: that of the values of a model of this size.
///
/// # Errors
/// A limit is reached.
pub fn attained(
    arena: &Arena<'_>,
    aim: &Aim<'_>,
    goal: Extremes,
    (nodes, starts): (&Nodes, usize),
    precision: f64,
) -> Result<Vec<Value>> {
    let mut meter = arena.meter();
    let chain = Chain::new(arena, aim, nodes, &mut meter)?;
    let most = if matches!(aim, Aim::Reward(..)) { f64::INFINITY } else { 1.0 };
    let mut found = vector::computed!(precision, most, N => chain.found::<N>(aim, goal, arena))?;
    found.values.truncate(starts);
    found.end.map(|()| found.values)
}

/// Returns the sets of nodes that reach each other, and no others, by the successors of each node. Cost: linear.
pub fn bottoms(successors: impl Iterator<Item = Vec<u32>>) -> Vec<Vec<u32>> {
    let mut chain = Choices::default();
    for own in successors {
        chain.to.extend(own);
        chain.end_choice();
        chain.end_node();
    }
    chain.bottoms()
}

/// The nodes of a strategy as a game in which we have one choice. Where a path is decided, it stays; with a last node
/// for the ends of paths that a reward is earned in.
struct Chain<'n> {
    keys: &'n [Key],
    game: GameGraph,
    /// The rewards of the choices, by the structure of the aim; none for a probability.
    rewards: Rewards,
}

impl<'n> Chain<'n> {
    fn new(arena: &Arena<'_>, aim: &Aim<'_>, nodes: &'n Nodes, meter: &mut Meter<'_>) -> Result<Self> {
        let mut game = GameGraph { fractions: arena.fractions.clone(), ..GameGraph::default() };
        let sure = game.fractions.number(Ratio::from_integer(1.into()));
        let (of, at_end) = match aim {
            Aim::Reward(rewards, accumulation) => {
                (Some(*rewards), matches!(accumulation, Accumulation::At(_)))
            }
            Aim::Until(_) | Aim::Recur(_) => (None, false),
        };
        let mut rewards = of.map(|of| Rewards { fractions: of.fractions.clone(), ..Rewards::default() });
        let nothing = rewards.as_mut().map_or(0, |own| own.fractions.number(Ratio::default()));
        let mut earn = |of_choice: u32| {
            rewards.iter_mut().for_each(|own| own.of_choice.push(of_choice));
        };
        let last = nodes.count() as u32;
        for (number, key) in (0..).zip(&nodes.keys) {
            let choices = nodes.game.choices(number);
            let edges = nodes.game.positions(choices.clone()).len();
            meter.take((edges + choices.len()) * 8 + 16)?;
            for choice in choices.clone() {
                nodes.game.edges(choice).for_each(|edge| game.add_edge(edge));
                game.end_choice();
                let of_choice = |of: &Rewards| of.of_choice.get(nodes.numbers[choice as usize] as usize);
                earn(of.filter(|_| !at_end).map_or(nothing, of_choice));
            }
            if choices.is_empty() {
                game.add_edge(Edge::new(if at_end { last } else { number }, sure, false));
                game.end_choice();
                earn(of.filter(|_| at_end).map_or(nothing, |of| of.of_state.get(key.state as usize)));
            }
            game.end_node();
        }
        if at_end {
            game.add_edge(Edge::new(last, sure, false));
            game.end_choice();
            game.end_node();
            earn(nothing);
        }
        game.theirs = nodes.game.theirs.clone();
        if at_end {
            game.theirs.iter_mut().for_each(|theirs| theirs.push(false));
        }
        Ok(Chain { keys: &nodes.keys, game, rewards: rewards.unwrap_or_default() })
    }

    /// Returns the values of the nodes.
    fn found<N: Number>(&self, aim: &Aim<'_>, goal: Extremes, arena: &Arena<'_>) -> Result<Vector<N>> {
        let (game, meter) = (&self.game, &mut arena.meter());
        let of = |set: &BitVec| self.members(|node| set[node.state as usize]);
        let accumulation = match aim {
            Aim::Until(Until { left, right, least, .. }) => {
                let right =
                    self.members(|node| right[node.state as usize] && u64::from(node.steps) >= *least);
                return vector::until_of(game, &Until::unbounded(of(left), right), goal, meter);
            }
            Aim::Recur(all_of) => {
                let all = BitVec::repeat(true, game.states());
                return vector::until_of(game, &Until::unbounded(all, self.accepting(all_of)), goal, meter);
            }
            Aim::Reward(_, accumulation) => match accumulation {
                Accumulation::Until(target) => Accumulation::Until(of(target)),
                Accumulation::Anyway(target) => Accumulation::Anyway(of(target)),
                Accumulation::IfReached(target) => Accumulation::IfReached(of(target)),
                Accumulation::Within(_) | Accumulation::Total | Accumulation::At(_) => Accumulation::Total,
                Accumulation::LongRun => Accumulation::LongRun,
            },
        };
        vector::reward_of(game, &self.rewards, &accumulation, goal, meter)
    }

    fn members(&self, inside: impl Fn(&Key) -> bool) -> BitVec {
        let mut members: BitVec = self.keys.iter().map(inside).collect();
        members.resize(self.game.states(), false);
        members
    }

    /// Returns the nodes of the components that are never left and satisfy one of some conditions.
    fn accepting(&self, all: &[Accepting]) -> BitVec {
        let mut accepting = BitVec::repeat(false, self.game.states());
        for component in self.game.choices.bottoms() {
            let of: Vec<usize> =
                component.iter().map(|&node| self.keys[node as usize].state as usize).collect();
            let is_satisfied = |condition: &Accepting| {
                of.iter().all(|&state| condition.always[state])
                    && condition.again.iter().all(|set| of.iter().any(|&state| set[state]))
            };
            let is_accepting = all.iter().any(is_satisfied);
            component.iter().for_each(|&node| accepting.set(node as usize, is_accepting));
        }
        accepting
    }
}
